"""Cached code in folders that other users can write is not run."""

import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bearingsim import own_folder as trust
from bearingsim.core import jit
from bearingsim.own_folder import UntrustedFolder, own_folder

OTHER_USER = 65534
CALL = """
from bearingsim.core import jit
from bearingsim.core.geometry.plane import small_angle
assert small_angle(0.0) == 0.0
print(jit._CACHE)
"""
as_root = pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can make files of another user"
)


@pytest.fixture
def shared() -> Iterator[Path]:
    """Make a folder like the temporary one: writable by all, with the sticky bit."""
    folder = Path(tempfile.mkdtemp(prefix="shared-"))
    folder.chmod(0o1777)
    yield folder
    shutil.rmtree(folder)


def as_other_user(do: Callable[[], object]) -> None:
    """Run a function as another user."""
    child = os.fork()
    if child == 0:
        try:
            os.setgid(OTHER_USER)
            os.setuid(OTHER_USER)
            os.umask(0)
            do()
        except BaseException as error:
            print(error, file=sys.stderr)
            os._exit(1)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0


class FileOnUnpickling:
    """Object that creates a file when unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple:
        return os.system, (f"touch {self.file}",)


@pytest.fixture(scope="module")
def cache_files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return the files of a cache with ``small_angle``."""
    cache = tmp_path_factory.mktemp("cache")
    run_compiled(cache)
    return {str(file.relative_to(cache / "bearingsim")): file.read_bytes() for file in cache.rglob("*.nb?")}


def run_compiled(cache: Path, **variables: str) -> subprocess.CompletedProcess:
    """Call a compiled function in a new process."""
    environment = os.environ | {"BEARINGSIM_CACHE": str(cache)} | variables
    process = subprocess.run([sys.executable, "-c", CALL], capture_output=True, text=True, env=environment)
    assert process.returncode == 0, process.stderr
    return process


def plant(cache_files: dict[str, bytes], cache: Path, file: Path) -> None:
    """Write compiled code whose indices create a file when read."""
    for name, content in cache_files.items():
        target = cache / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(pickle.dumps(FileOnUnpickling(file)) if target.suffix == ".nbi" else content)


def test_planted_code_runs_in_a_trusted_folder(cache_files: dict[str, bytes], tmp_path: Path) -> None:
    """So the tests below can detect planted code."""
    plant(cache_files, tmp_path / "bearingsim", tmp_path / "run")
    (tmp_path / "bearingsim" / jit.source_digest()).chmod(0o700)
    run_compiled(tmp_path)
    assert (tmp_path / "run").exists()


def foreign_folder(shared: Path, make: Callable[[Path], None]) -> None:
    as_other_user(lambda: make(shared / "bearingsim"))


def foreign_digest(shared: Path, make: Callable[[Path], None]) -> None:
    (shared / "bearingsim").mkdir()
    (shared / "bearingsim").chmod(0o777)
    as_other_user(lambda: make(shared / "bearingsim"))


def foreign_link(shared: Path, make: Callable[[Path], None]) -> None:
    as_other_user(lambda: make(shared / "theirs"))
    as_other_user(lambda: (shared / "bearingsim").symlink_to(shared / "theirs"))


def own_link(shared: Path, make: Callable[[Path], None]) -> None:
    as_other_user(lambda: make(shared / "theirs"))
    (shared / "bearingsim").symlink_to(shared / "theirs")


def open_folder(shared: Path, make: Callable[[Path], None]) -> None:
    """Make the user's own folder below one in which others may rename it."""
    shared.chmod(0o777)
    make(shared / "bearingsim")


@as_root
@pytest.mark.parametrize("planted", [foreign_folder, foreign_digest, foreign_link, own_link, open_folder])
@pytest.mark.parametrize("names", ["BEARINGSIM_CACHE", "XDG_CACHE_HOME"])
def test_planted_code_of_another_user_is_not_run(
    shared: Path, cache_files: dict[str, bytes], planted: Callable, names: str
) -> None:
    planted(shared, lambda cache: plant(cache_files, cache, shared / "run"))
    process = run_compiled(Path(), **{"BEARINGSIM_CACHE": "", names: str(shared)})
    assert not (shared / "run").exists()
    assert not Path(process.stdout.strip()).is_relative_to(shared)
    (line,) = process.stderr.splitlines()
    assert line.startswith(f"bearingsim: compiled code is cached in {Path(process.stdout.strip()).parent}: ")
    assert str(shared) in line


@as_root
def test_temporary_folder_of_another_user_is_not_used(shared: Path, cache_files: dict[str, bytes]) -> None:
    """The folder of the process is used instead."""
    first = shared / f"bearingsim-{os.getuid()}"
    as_other_user(lambda: plant(cache_files, first / "bearingsim", shared / "run"))
    process = run_compiled(Path("/dev/null"), TMPDIR=str(shared))
    assert not (shared / "run").exists()
    assert Path(process.stdout.strip()).parts[len(shared.parts)] not in ("bearingsim", first.name)
    assert [path.name for path in shared.iterdir()] == [first.name]


@as_root
def test_without_a_trusted_folder_nothing_is_cached(shared: Path) -> None:
    shared.chmod(0o777)
    process = run_compiled(shared, TMPDIR=str(shared))
    assert process.stdout.strip() == "None"
    assert process.stderr.startswith("bearingsim: compiled code is not cached")
    assert list(shared.iterdir()) == []


@as_root
def test_link_of_another_user_is_followed_only_to_a_trusted_folder(shared: Path, tmp_path: Path) -> None:
    """A dangling link creates no folder."""
    as_other_user(lambda: (shared / "link").symlink_to(tmp_path))
    assert own_folder(shared / "link", "mine") == tmp_path / "mine"
    as_other_user(lambda: (shared / "loose").symlink_to(tmp_path / "new"))
    with pytest.raises(UntrustedFolder, match="another user's link"):
        own_folder(shared / "loose", "mine")
    assert not (tmp_path / "new").exists()


def test_folders_are_made_for_this_user_alone(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        folder = own_folder(tmp_path / "a", "b", "c")
    finally:
        os.umask(before)
    assert [path.stat().st_mode & 0o777 for path in (folder, *folder.parents[:2])] == [0o700] * 3


@pytest.fixture
def shared_group(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the user's group other members."""
    monkeypatch.setattr(trust, "_is_own_group", lambda group: False)


@pytest.mark.usefixtures("shared_group")
def test_group_write_access_is_removed_from_the_outer_folder_only(tmp_path: Path) -> None:
    for name in ("bearingsim", "bearingsim/code"):
        (tmp_path / name).mkdir()
    (tmp_path / "bearingsim").chmod(0o775)
    assert own_folder(tmp_path, "bearingsim", "code") == tmp_path / "bearingsim/code"
    assert (tmp_path / "bearingsim").stat().st_mode & 0o777 == 0o755
    (tmp_path / "bearingsim/code").chmod(0o775)
    with pytest.raises(UntrustedFolder, match=r"other users can write to .*/code"):
        own_folder(tmp_path, "bearingsim", "code")


@pytest.mark.usefixtures("shared_group")
def test_a_folder_above_that_the_group_can_write_in_is_not_trusted(tmp_path: Path) -> None:
    tmp_path.chmod(0o775)
    with pytest.raises(UntrustedFolder, match=f"`chmod go-w {tmp_path}` prevents this"):
        own_folder(tmp_path, "bearingsim", "code")


def test_private_group_has_no_other_members(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With one group per user, files are often group-writable."""
    import grp
    import pwd

    own = pwd.struct_passwd(("me", "x", os.getuid(), 77, "", "", ""))
    monkeypatch.setattr(pwd, "getpwuid", lambda user: own)
    monkeypatch.setattr(pwd, "getpwall", lambda: [own])
    for members, private in ([], True), (["me"], True), (["me", "you"], False):
        monkeypatch.setattr(grp, "getgrgid", lambda group, m=members: grp.struct_group(("me", "x", group, m)))
        trust._is_own_group.cache_clear()
        assert trust._is_own_group(77) is private
        assert not trust._is_own_group(78)
    trust._is_own_group.cache_clear()
