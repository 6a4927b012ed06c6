"""matplotlib's font list is in the user's folders, or in the program's cache if they cannot be written."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = "import bearingsim.plots, matplotlib; print(matplotlib.get_configdir(), matplotlib.get_cachedir())"


@pytest.mark.parametrize(
    ("variables", "folders"),
    [
        ({"HOME": "{}/home"}, ["{}/home/.config/matplotlib", "{}/home/.cache/matplotlib"]),
        ({"HOME": "{}/file"}, ["{}/bearingsim-USER/bearingsim/matplotlib"] * 2),
        ({"HOME": "{}/file", "BEARINGSIM_CACHE": "{}/home"}, ["{}/home/bearingsim/matplotlib"] * 2),
        ({"HOME": "{}/home", "XDG_CACHE_HOME": "{}/file"}, ["{}/bearingsim-USER/bearingsim/matplotlib"] * 2),
        ({"HOME": "{}/file", "MPLCONFIGDIR": "{}/home"}, ["{}/home"] * 2),
    ],
)
def test_matplotlib_folder_follows_environment(
    tmp_path: Path, variables: dict[str, str], folders: list[str]
) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "file").touch()
    unset = ("BEARINGSIM_CACHE", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR")
    environment = {name: value for name, value in os.environ.items() if name not in unset}
    environment |= {"TMPDIR": "{}"} | variables
    environment = {name: value.replace("{}", str(tmp_path)) for name, value in environment.items()}
    process = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True
    )
    assert process.stderr == ""
    expected = [text.format(tmp_path).replace("USER", str(os.getuid())) for text in folders]
    assert process.stdout.split() == expected
