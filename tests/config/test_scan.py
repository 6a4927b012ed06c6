"""Scan files: reading, repairs with notes, refusals."""

import hashlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from bearingsim.config.scan import file as scanfile
from bearingsim.config.scan.repair import read_scan
from bearingsim.study import load_study
from bearingsim.text.yamlfile import StudyError
from tests.scenes.scan_files import STUDY, S, Z, bowl, refusal, write_grid


def write_points(
    path: Path, depth: np.ndarray, head: str = "s [mm],z [mm],depth [um]", s: Any = S, z: Any = Z
) -> Path:
    lines = [
        f"{x:.6g},{y:.6g},{p:.6g}" for y, row in zip(z, depth, strict=True) for x, p in zip(s, row, strict=True)
    ]
    path.write_text("\n".join(["# by a profilometer", head, *lines, ""]).replace("nan", ""))
    return path


def write_hdf5(
    path: Path, depth: np.ndarray, name: str = "depth", unit: str = "um", s: Any = S, z: Any = Z
) -> Path:
    with h5py.File(path, "w") as file:
        for key, values, axis_unit in (("s", s, "mm"), ("z", z, "mm"), (name, depth, unit)):
            file[key] = values
            file[key].attrs["units"] = axis_unit
    return path


def notes_text(path: Path) -> str:
    return "\n".join(read_scan(path).notes)


@pytest.mark.parametrize("write", [write_grid, write_hdf5])
def test_a_file_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Any) -> None:
    """The digest is that of the content that was read, even if the file changes at once."""
    path = write(tmp_path / ("a.h5" if write is write_hdf5 else "a.csv"), bowl())
    content, ascending = path.read_bytes(), scanfile._ascending_grid

    def changing(*parts: np.ndarray) -> scanfile.Grid:
        path.write_bytes(b"changed")
        return ascending(*parts)

    monkeypatch.setattr(scanfile, "_ascending_grid", changing)
    scan = read_scan(path)
    assert scan.digest == hashlib.sha256(content).hexdigest()[:16]
    assert scan.sizes == pytest.approx((6e-3, 2e-3, 50e-6), rel=1e-5)


def test_all_formats_of_a_file_give_the_same_scan(tmp_path: Path) -> None:
    depth = bowl()
    files = [
        write_points(tmp_path / "a.csv", depth),
        write_grid(tmp_path / "b.csv", depth),
        write_grid(tmp_path / "c.csv", depth.T, "depth [um] | s [mm] | z [mm]", s=Z, z=S),
        write_grid(tmp_path / "d.csv", -depth * 1e-3, "height [mm] | z [mm] | s [mm]"),
        write_hdf5(tmp_path / "e.h5", depth),
        write_hdf5(tmp_path / "f.hdf5", -depth, "height"),
    ]
    for file in files:
        scan = read_scan(file)
        assert scan.notes == ()
        assert scan.sizes == pytest.approx((6e-3, 2e-3, 50e-6), rel=1e-5)
        inside = (np.abs(S) <= 1.0 + 1e-9)[None, :] & (np.abs(Z) <= 3.0 + 1e-9)[:, None]
        assert scan.depth.ravel() == pytest.approx(1e-6 * depth[inside], abs=1e-10)
        assert scan.s[[0, -1]] == pytest.approx([-1e-3, 1e-3])
    assert len({read_scan(file).digest for file in files}) == len(files)


@pytest.mark.parametrize("write", [write_grid, write_hdf5, write_points])
@pytest.mark.parametrize("axis", ["s", "z"])
def test_decreasing_axis_is_reversed(tmp_path: Path, write: Any, axis: str) -> None:
    lopsided = bowl() * (S < 0.5)
    straight = read_scan(write(tmp_path / ("a.h5" if write is write_hdf5 else "a.csv"), lopsided))
    turned = {"s": S[::-1]} if axis == "s" else {"z": Z[::-1]}
    depth = lopsided[:, ::-1] if axis == "s" else lopsided[::-1]
    scan = read_scan(write(tmp_path / ("b.h5" if write is write_hdf5 else "b.csv"), depth, **turned))
    assert f"{axis} is decreasing" in scan.notes[0]
    assert scan.depth == pytest.approx(straight.depth)
    assert not any("downwards" in note for note in straight.notes)


def test_missing_cells_are_filled_from_their_neighbours(tmp_path: Path) -> None:
    depth = bowl()
    depth[20, 30] = depth[20, 31] = depth[25, 10] = np.nan
    for file in (
        write_points(tmp_path / "a.csv", depth),
        write_grid(tmp_path / "b.csv", depth),
        write_hdf5(tmp_path / "c.h5", depth),
    ):
        assert "3 missing cells filled from the neighbours: s = 0 mm, z = 0 mm; " in notes_text(file)
        assert 50e-6 - read_scan(file).depth.max() < 1e-6


@pytest.mark.parametrize(
    ("missing", "part"),
    [(np.s_[10:14, 20:24], "16 missing cells are adjacent"), (np.s_[::3, ::3], "cells are missing (11.")],
)
def test_too_many_missing_cells_are_refused(tmp_path: Path, missing: Any, part: str) -> None:
    depth = bowl()
    depth[missing] = np.nan
    assert part in refusal(write_grid(tmp_path / "a.csv", depth))


def test_spikes_are_removed(tmp_path: Path) -> None:
    depth = bowl(noise=0.2)
    depth[20, 40] += 300.0
    depth[5, 5] -= 80.0
    file = write_grid(tmp_path / "a.csv", depth)
    assert "2 spikes of 80" in notes_text(file)
    assert "s = -1.25 mm, z = -3 mm; s = 0.5 mm, z = 0 mm" in notes_text(file)
    assert read_scan(file).sizes[2] < 52e-6


def test_a_slot_has_no_spikes(tmp_path: Path) -> None:
    """Neither its walls nor its corners, nor a step of one cell's width."""
    slot = np.where((np.abs(S) < 0.4)[None, :] & (np.abs(Z) < 2.0)[:, None], 50.0, 0.0)
    slot[:, 5] = np.where(np.abs(Z) < 2.0, 10.0, 0.0)
    assert notes_text(write_grid(tmp_path / "a.csv", slot)).startswith("the centre of the damage")


def test_too_many_spikes_are_refused(tmp_path: Path) -> None:
    depth = bowl(noise=0.2)
    depth[1:-1:4, 1:-1:4] += 200.0
    assert "filter the scan first" in refusal(write_grid(tmp_path / "a.csv", depth))


@pytest.mark.parametrize(
    ("head", "parts"),
    [
        ("depth [um] | z [um] | s [um]", ["only 2 um wide along s", "deeper (50 um) than wide (2 um)"]),
        ("depth [nm] | z [mm] | s [mm]", ["only 0.05 um deep"]),
        ("depth [mm] | z [mm] | s [mm]", ["deeper (5e+04 um) than wide (2e+03 um)"]),
        ("depth [um] | z [mm] | s [mm]", []),
    ],
)
def test_implausible_size_or_slope_is_noted(tmp_path: Path, head: str, parts: list[str]) -> None:
    scan_notes = read_scan(write_grid(tmp_path / "a.csv", bowl(), head)).notes
    assert list(scan_notes) == [f"the defect is {part}; is the unit right?" for part in parts]


def test_a_tilted_scan_is_levelled(tmp_path: Path) -> None:
    s, z = np.meshgrid(S, Z)
    file = write_grid(tmp_path / "a.csv", bowl(noise=0.1) + 12.0 + 3.0 * s - 2.0 * z)
    assert "offset 12 um, tilt 8.99 um along s and -16 um along z removed" in notes_text(file)
    assert "roughness of the surrounding race: 0.0883 um; depths within 0.265 um are set to 0" in notes_text(file)
    level = read_scan(write_grid(tmp_path / "b.csv", bowl(noise=0.1)))
    assert read_scan(file).sizes == pytest.approx(level.sizes, rel=0.03)


def test_noise_of_the_race_is_removed(tmp_path: Path) -> None:
    """Outside the bowl the depth is zero, without noise."""
    scan = read_scan(write_grid(tmp_path / "a.csv", bowl(noise=0.3)))
    s, z = np.meshgrid(scan.s, scan.z)
    assert not scan.depth[(s / 1.2e-3) ** 2 + (z / 3.6e-3) ** 2 > 1.0].any()
    assert scan.sizes == pytest.approx((6e-3, 2e-3, 50e-6), rel=0.12)


def test_curvature_of_the_race_is_subtracted(tmp_path: Path) -> None:
    """A race of 38.5 mm radius falls 29 um within 1.5 mm."""
    s, _ = np.meshgrid(S, Z)
    file = write_grid(tmp_path / "a.csv", bowl(noise=0.1) - 1e3 * s**2 / (2 * 38.5))
    assert "curvature: radius 38." in notes_text(file)
    assert read_scan(file).sizes[2] == pytest.approx(50e-6, rel=0.02)


def test_middle_of_the_damage_is_its_position(tmp_path: Path) -> None:
    scan = read_scan(write_grid(tmp_path / "a.csv", bowl(), s=S + 40.0, z=Z - 7.0))
    assert "the centre of the damage, s = 40 mm, z = -7 mm, is at the defect's position" in "\n".join(scan.notes)
    assert scan.s[[0, -1]] == pytest.approx([-1e-3, 1e-3])


def test_uneven_positions_are_kept(tmp_path: Path) -> None:
    s = np.sort(np.append(S, [0.01, 0.02]))
    x, z = np.meshgrid(s, Z)
    depth = 50.0 * np.clip(1.0 - x**2 - (z / 3.0) ** 2, 0.0, None)
    scan = read_scan(write_grid(tmp_path / "a.csv", depth, s=s))
    assert scan.notes == ()
    assert np.any(np.isclose(scan.s, 1e-5))


def test_damage_beyond_the_scan_along_the_roller(tmp_path: Path) -> None:
    file = write_grid(tmp_path / "a.csv", np.where(np.abs(S) < 0.4, 50.0, 0.0) * np.ones((len(Z), 1)))
    assert "extends to the scan's end along z and is cut off there" in notes_text(file)
    assert read_scan(file).sizes[0] == pytest.approx(8e-3)


def test_damage_beyond_the_scan_along_rolling(tmp_path: Path) -> None:
    """A bowl of 1.2 mm along z, cut 0.1 mm after its middle, is no wider than a fifth of a side of 8 mm."""
    depth, s = 50.0 * np.clip(1.0 - S**2 - (Z[:, None] / 0.6) ** 2, 0.0, None)[:, :33], S[:33]
    file = write_grid(tmp_path / "a.csv", depth, s=s)
    assert "extends to the scan's end along s and is cut off there" in notes_text(file)
    assert read_scan(file).sizes[1] == pytest.approx(1.1e-3)


def test_a_scan_with_small_regions_only_is_refused(tmp_path: Path) -> None:
    """Four cells in a square exceed the noise and are no spikes, but are too few for a defect."""
    depth = 0.0 * bowl()
    depth[20:22, 30:32] = 50.0
    message = "no defect: all damaged regions have fewer than 5 cells"
    assert message in refusal(write_grid(tmp_path / "a.csv", depth))


@pytest.mark.parametrize(
    ("depth", "part"),
    [
        (bowl()[:, 20:], "there is no undamaged border"),
        (bowl()[:, 15:46], "there is no "),
        (
            0.0 * bowl(),
            "within the noise (0 um, 3 standard deviations of the border) (scan the area of the defect",
        ),
        (bowl(noise=40.0), "no"),
        (-bowl(), "name the column `height`"),
    ],
)
def test_a_scan_without_undamaged_surroundings_or_defect_is_refused(
    tmp_path: Path, depth: np.ndarray, part: str
) -> None:
    s = S[: depth.shape[1]]
    assert part in refusal(write_grid(tmp_path / "a.csv", depth, s=s))


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("s,z [mm],depth [um]\n1,1,1\n", "the unit of `s` is missing (write `s [um]`, or mm, m, nm)"),
        ("s [mm],z [mm],depth [furlong]\n1,1,1\n", "`depth [furlong]` has no unit of length"),
        ("s [mm],z [mm],depth [deg]\n1,1,1\n", "`deg` is a unit of angle"),
        (
            "s [mm],z [mm]\n1,1\n",
            "expected columns `s`, `z` and either `depth` or `height`, got `s [mm]`, `z [mm]`",
        ),
        ("x [mm],y [mm],depth [um]\n1,1,1\n", "got `x [mm]`, `y [mm]`, `depth [um]`"),
        ("s [mm],z [mm],depth [um]\n1,1,x\n", "line 2: expected a number, got `x`"),
        ("s [mm],z [mm],depth [um]\n1,1,inf\n", "line 2: `inf` is not finite"),
        ("s [mm],z [mm],depth [um]\n0,1,1,5,1\n", "line 2: 5 cells, the first line has 3"),
        ("s [mm],z [mm],depth [um]\n", "no points in this file"),
        ("s [mm],z [mm],depth [um]\n1,1,1\n1,1,2\n2,1,1\n2,2,1\n1,2,2\n", "two points have the same coordinates"),
        ("s [mm],z [mm],depth [um]\n1,,1\n", "a point has no coordinates"),
        ("s [mm],z [mm],depth [um],depth [um]\n1,1,1,2\n", "two columns are named `depth`"),
        ('s [mm],z [mm],depth [um]\n1,1,"1\n' + 50000 * "1,1,1\n", "has a quotation mark that is not closed"),
        (
            "s [mm],z [mm],depth [um]\n1,5,1\n2,6,1\n3,7,1\n",
            "the points do not form a grid: 3 points at 3 values of s",
        ),
        ("depth [um] | z [mm],1,2\n1,1,1\n", "expected columns"),
        ("z [mm] | depth [um] | s [mm],1,2\n1,1,1\n", "expected a first cell such as"),
        ("depth [um] | z [mm] | s [mm],1,3,2\n1,1,1,1\n", "s is not monotonic between values 2 and 3"),
        ("depth [um] | z [mm] | s [mm],1,2\n1,1,1\n2,1,1\n", "at least 5 each are needed"),
    ],
)
def test_invalid_scan_file_is_refused(tmp_path: Path, text: str, part: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    assert part in refusal(tmp_path / "a.csv")


def test_files_of_another_kind_are_refused(tmp_path: Path) -> None:
    assert "no file" in refusal(tmp_path / "none.csv")
    (tmp_path / "a.xlsx").touch()
    assert "ends in .csv, .txt, .h5 or .hdf5, got `a.xlsx`" in refusal(tmp_path / "a.xlsx")
    (tmp_path / "a.h5").write_text("no HDF5")
    assert "`a.h5` is not an HDF5 file, or truncated" in refusal(tmp_path / "a.h5")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00")
    assert "not a text file in UTF-8 (save it as UTF-8)" in refusal(tmp_path / "b.csv")
    assert "expected s (n_s,), z (n_z,) and depth (n_z, n_s), got s (61,)" in refusal(
        write_hdf5(tmp_path / "c.h5", bowl().T)
    )
    assert "expected datasets `s`, `z` and either" in refusal(write_hdf5(tmp_path / "d.h5", bowl(), "deep"))
    assert "(give `depth` the attribute `units`: um" in refusal(write_hdf5(tmp_path / "e.h5", bowl(), unit=""))
    (tmp_path / "folder.csv").mkdir()
    assert "folder.csv` is a folder" in refusal(tmp_path / "folder.csv")


def test_a_broken_hdf5_file_is_refused(tmp_path: Path) -> None:
    complete = write_hdf5(tmp_path / "whole.h5", bowl()).read_bytes()
    for content in (b"", bytes(range(256)) * 9, *(complete[: len(complete) * n // 9] for n in range(1, 9))):
        (tmp_path / "a.h5").write_bytes(content)
        assert refusal(tmp_path / "a.h5") == "`a.h5` is not an HDF5 file, or truncated"
    assert "no points in this file" in refusal(write_hdf5(tmp_path / "b.h5", np.empty((len(Z), 0)), s=np.empty(0)))


@pytest.mark.parametrize("broken", ["position", "unit"])
def test_unusable_values_of_an_hdf5_file_are_refused(tmp_path: Path, broken: str) -> None:
    path = write_hdf5(tmp_path / "a.h5", bowl(), s=np.append(S[:-1], np.inf) if broken == "position" else S)
    if broken == "unit":
        with h5py.File(path, "r+") as file:
            file["depth"].attrs["units"] = np.bytes_("µm".encode("latin-1"))
    part = {"position": "a value of s is missing or infinite", "unit": "`units` is not text in UTF-8"}[broken]
    assert part in refusal(path)


@pytest.mark.parametrize("write", [write_points, write_hdf5])
@pytest.mark.parametrize("name", ["s", "z", "depth"])
def test_values_far_beyond_a_bearing_are_refused(tmp_path: Path, write: Any, name: str) -> None:
    factor = {key: 1e200 if key == name else 1.0 for key in ("s", "z", "depth")}
    path = tmp_path / ("a.h5" if write is write_hdf5 else "a.csv")
    write(path, bowl() * factor["depth"], s=S * factor["s"], z=Z * factor["z"])
    assert f"a value of {name} exceeds 100 m (is the unit right?)" in refusal(path)


def test_separators_at_the_end_of_lines_are_no_column(tmp_path: Path) -> None:
    file = write_points(tmp_path / "a.csv", bowl())
    head, *lines = file.read_text().splitlines()
    file.write_text("\n".join([head, *(f"{line}," for line in lines)]))
    assert read_scan(file).notes == ()


def test_text_in_an_hdf5_file_is_refused(tmp_path: Path) -> None:
    with h5py.File(write_hdf5(tmp_path / "a.h5", bowl()), "r+") as file:
        del file["depth"]
        file["depth"] = np.full((len(Z), len(S)), "deep", dtype=h5py.string_dtype())
        file["depth"].attrs["units"] = "um"
    path = tmp_path / "study.yaml"
    path.write_text(STUDY.replace("FILE", "a.h5"))
    with pytest.raises(StudyError, match=r"defect\.file: `depth` contains other data than numbers"):
        load_study(path)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        (
            "s [mm];z [mm];depth [um]\n1,0;1,0;1,0\n",
            "the separator is `;` (use a comma, and a point for decimals)",
        ),
        ("depth [um] | z [mm] | s [mm];-1,0;1,0\n1,0;0;0\n", "the separator is `;` (use"),
        ("s [mm]\tz [mm]\tdepth [um]\n1\t1\t1\n", "the separator is a tab (use"),
        (
            's [mm],z [mm],depth [um]\n1,1,"1,5"\n',
            "line 2: expected a number, got `1,5` (use a point for decimals)",
        ),
    ],
)
def test_the_export_of_a_european_spreadsheet_is_refused(tmp_path: Path, text: str, part: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    assert part in refusal(tmp_path / "a.csv")


def test_a_long_first_line_is_not_repeated(tmp_path: Path) -> None:
    for text in ("x " * 250 + "\n1\n", ",".join(["something"] * 50) + "\n1\n", "x|" * 250 + ",1\n1,1\n"):
        (tmp_path / "a.csv").write_text(text)
        assert len(refusal(tmp_path / "a.csv")) < 240


def test_note_on_one_missing_cell_at_position_zero(tmp_path: Path) -> None:
    depth = bowl()
    depth[20, 30] = np.nan
    message = notes_text(write_points(tmp_path / "a.csv", depth, s=np.where(np.abs(S) < 1e-9, 5.421e-17, S)))
    assert "1 missing cell filled from the neighbours: s = 0 mm, z = 0 mm" in message


def test_a_file_too_large_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scanfile, "MAX_POINTS", 100)
    assert "use fewer points" in refusal(write_grid(tmp_path / "a.csv", bowl()))
