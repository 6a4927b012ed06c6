"""A small study and a measured signal, and how the tests type a command."""

import numpy as np
from typer.testing import CliRunner

from bearingsim.cli.app import app

STUDY = """\
study: small
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
sweep:
  load: [150 N, 300 N]
  model: [static, ring]
duration: 30 ms
settle: 10 ms
figures:
  - {y: velocity@BPFO, x: load, by: model}
quick: {sweep: {model: [static]}}
"""


def type_(*words, code=0):
    """Type a command; its output, its messages on stderr, after checking its exit code."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == code, (result.output, result.exc_info)
    assert "Traceback" not in result.stderr
    return result.stdout, result.stderr


def write_signal(path):
    """Write 2 s of noise as a measured signal at 1800 rpm."""
    noise = np.random.default_rng(0).normal(size=51_200)
    np.savez(path, x=noise, fs=25_600.0, rpm=1800.0)
