"""Commands that compute nothing need no module, signal or function that only POSIX systems have."""

import json
import subprocess
import sys
from pathlib import Path

COMMANDS = [
    ["new"],
    ["new", "--list"],
    ["new", "--from", "shapes"],
    ["check", "study.yaml"],
    ["check", "--schema"],
    ["freq", "nu206"],
    ["show", "RESULTS"],
    ["show", "RESULTS", "--failed"],
    ["show", "RESULTS", "--assumptions"],
]
CODE = """
import asyncio, ctypes, json, multiprocessing.util, os, select, selectors, shutil, signal, subprocess, sys
# not hidden from packages and the standard library, which choose by the platform
import tempfile, filelock, h5py, joblib, numba, pandas

MODULES = "fcntl grp nis posix_ipc pty pwd resource spwd syslog termios tty _posixshmem _posixsubprocess".split()
SIGNALS = "SIGALRM SIGCHLD SIGHUP SIGKILL SIGPIPE SIGQUIT SIGSTOP SIGUSR1 SIGUSR2 SIGXCPU SIGXFSZ".split()
FUNCTIONS = {
    signal: "alarm pthread_kill pthread_sigmask setitimer sigwait".split(),
    os: "chown fchmod fork getgid getloadavg getpgid getpriority getuid geteuid killpg mkfifo nice "
        "posix_fallocate sched_getaffinity setsid statvfs sysconf wait3 wait4 O_DIRECTORY O_NOFOLLOW".split(),
    select: ["epoll", "poll"],
}
for name in MODULES:
    sys.modules[name] = None
for module, names in (FUNCTIONS | {signal: SIGNALS + FUNCTIONS[signal]}).items():
    for name in names:
        if hasattr(module, name):
            delattr(module, name)

from bearingsim.cli import main
for words in json.loads(sys.argv[1]):
    sys.argv = ["bearingsim", *words]
    try:
        main()
    except SystemExit as end:
        assert not end.code, words
"""


def test_posix_modules_are_optional(done: Path, tmp_path: Path) -> None:
    commands = [[str(done) if word == "RESULTS" else word for word in words] for words in COMMANDS]
    process = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", CODE, json.dumps(commands)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (process.returncode, "Traceback" in process.stderr) == (0, False), process.stderr[-2000:]
    assert "8 jobs: 8 done" in process.stdout
    assert {"study.yaml", "shapes.yaml"} <= {path.name for path in tmp_path.iterdir()}
