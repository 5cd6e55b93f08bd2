# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn files: round trips, the estimated radius, and an error message for each kind of malformed file."""

from __future__ import annotations

import dataclasses
import logging
import struct
from pathlib import Path

import h5py
import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.errors import FileError, ParameterError, YarnError
from stitchmesh.io import read_yarns, write_yarns
from stitchmesh.io.yarns import FORMATS, check_writable
from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns
from tests.gallery import shared
from tests.io.refusals import refused
from tests.io.yarn_sets import ODD_POINTS, assert_same, awkward_yarns, ring, store_points_oddly
from tests.yarnrelax.stockinette import woven_cell

HEADER = 64


def test_hdf5_keeps_every_field(tmp_path):
    step = np.array([[1, 0], [0, -2], [0, 0], [3, 1]])
    yarns = dataclasses.replace(awkward_yarns(), lattice=Lattice([[1, 0, 0], [0.1, 2, 0]]), lattice_step=step)
    write_yarns(tmp_path / "y.h5", yarns)
    assert_same(read_yarns(tmp_path / "y.h5"), yarns)


def test_hdf5_of_before_yarns_had_a_mass_and_a_colour_is_read(tmp_path):
    write_yarns(tmp_path / "y.h5", awkward_yarns())
    with h5py.File(tmp_path / "y.h5", "r+") as file:
        del file["mass_per_length"], file["colour"]
    read = read_yarns(tmp_path / "y.h5")
    assert np.isnan(read.mass_per_length).all()
    assert read.colour.tolist() == [0, 0, 0, 0]


def cell_of_yarns() -> YarnSet:
    """Return a yarn without ends along the courses, one along the wales, and a ring, on a sheared lattice."""
    points = np.random.default_rng(5).normal(size=(24, 3))
    bare = YarnSet.from_curves([points[:9], points[9:14], points[14:]], closed=[True] * 3, radius=0.1)
    lattice, step = Lattice([[3.0, 0.0, 0.0], [0.5, 2.0, 0.0]]), np.array([[1, 0], [0, 1], [0, 0]])
    yarns = dataclasses.replace(bare, lattice=lattice, lattice_step=step)
    return dataclasses.replace(yarns, rest_length=yarns.lengths)


@pytest.mark.parametrize("suffix", [".bcc", ".obj", ".usda", ".vtp", ".yarns"])
def test_formats_without_a_lattice_hold_one_period_of_open_yarns(tmp_path, suffix, caplog):
    cell = cell_of_yarns()
    with caplog.at_level(logging.INFO, "stitchmesh"):
        write_yarns(tmp_path / f"y{suffix}", cell)
    assert "holds one period of the periodic yarns, as yarns with ends" in caplog.text
    again = read_yarns(tmp_path / f"y{suffix}", radius=0.1)
    assert again.lattice is None
    for yarn, (period, ends) in enumerate(zip(cell.sampled(1), (False, False, True), strict=True)):
        # USD keeps open yarns in a separate prim; the numbers of the yarns restore the order.
        assert again.closed[yarn] == ends
        kept = again.sampled(1)[yarn]
        kept = kept[:: round((len(kept) - 1 + ends) / len(period))]  # A polyline has more points than knots.
        np.testing.assert_allclose(kept[: len(period)], period, atol=1e-6)  # float32
        if not ends:
            # The end of one period is the start of the next.
            np.testing.assert_allclose(kept[-1] - kept[0], cell.lattice.shift(cell.lattice_step[yarn]), atol=1e-6)


@pytest.mark.parametrize("suffix", [".h5", ".glb"])
def test_tiles_are_written_as_a_finite_piece(tmp_path, suffix):
    cell = cell_of_yarns()
    for name, yarns, tiles in (("a", cell, (3, 2)), ("b", tile_yarns(cell, 3, 2), None)):
        write_yarns(tmp_path / f"{name}{suffix}", yarns, tiles=tiles)
    if suffix == ".h5":
        assert_same(read_yarns(tmp_path / "a.h5"), tile_yarns(cell, 3, 2))
    else:
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize("suffix", [".h5", ".usda"])
def test_tiles_of_yarns_that_are_not_periodic_are_errors(tmp_path, suffix):
    with pytest.raises(YarnError, match="expected a cell on a lattice"):
        write_yarns(tmp_path / f"y{suffix}", awkward_yarns(), tiles=(2, 2))
    with pytest.raises(ParameterError, match="got 0 rows; expected a whole number from 1"):
        write_yarns(tmp_path / f"y{suffix}", cell_of_yarns(), tiles=(2, 0))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("curve", ["bspline", "catmull-rom"])
def test_bcc_keeps_control_points_to_float32(tmp_path, curve):
    yarns = awkward_yarns()
    write_yarns(tmp_path / "y.bcc", yarns, curve=curve)
    again = read_yarns(tmp_path / "y.bcc", radius=0.1)
    np.testing.assert_array_equal(again.start, yarns.start)
    np.testing.assert_array_equal(again.closed, yarns.closed)
    for index in range(yarns.yarn_count):
        part = slice(yarns.start[index], yarns.start[index + 1])
        size = np.abs(yarns.points[part]).max()
        # The rounding error of float32 is 6e-8, and the solution for control points amplifies it by at most 3.
        np.testing.assert_allclose(again.points[part], yarns.points[part], atol=3e-7 * size)


@pytest.mark.parametrize(("name", "curve"), [("glove.bcc", "catmull-rom"), ("knittube.bcc", "bspline")])
def test_published_bcc_files_are_written_with_the_same_bytes(tmp_path, name, curve):
    source = shared(f"yarns/{name}")
    yarns = read_yarns(source, radius=0.1)
    write_yarns(tmp_path / name, yarns, curve=curve)
    before, after = source.read_bytes(), (tmp_path / name).read_bytes()
    assert before[:24] == after[:24]
    assert before[HEADER:] == after[HEADER:]  # The free text between them depends on the program.
    np.testing.assert_array_equal(read_yarns(tmp_path / name, radius=0.1).points, yarns.points)


def test_z_up_is_rotated_to_y_up(tmp_path):
    write_yarns(tmp_path / "y.bcc", YarnSet.from_curves([np.eye(3)], closed=[True], radius=0.1), curve="bspline")
    content = bytearray((tmp_path / "y.bcc").read_bytes())
    assert content[7] == 1
    content[7] = 2
    (tmp_path / "y.bcc").write_bytes(content)
    turned = read_yarns(tmp_path / "y.bcc", radius=0.1).points
    np.testing.assert_array_equal(turned, [[1, 0, 0], [0, 0, -1], [0, 1, 0]])


def bcc(
    *, magic: bytes = b"BCCD", kind: bytes = b"C0", dimensions: int = 3, up: int = 1, curves: int = 1, points: int = 4,
    count: int = -4, values: list[float] | None = None, tail: bytes = b"",
) -> bytes:  # fmt: skip
    numbers = list(range(12)) if values is None else values
    head = magic + kind + bytes([dimensions, up]) + struct.pack("<QQ40s", curves, points, b"")
    return head + struct.pack("<i", count) + struct.pack(f"<{len(numbers)}f", *numbers) + tail


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (bcc(magic=b"ABCD"), "does not start with a BCC header"),
        (bcc(magic=b"BCC\x88"), "byte 3 is 0x88; expected 0x44"),
        (bcc(kind=b"BZ"), "holds Bezier curves"),
        (bcc(dimensions=2), "points have 2 dimensions; expected 3"),
        (bcc(up=0), "up axis is 0; expected 1 (y) or 2 (z)"),
        (bcc()[:-1], "need 116 bytes, the file has 115; it was cut short or altered"),
        (bcc(curves=0, points=0, count=0, values=[]), "0 curves of 0 points"),
        (bcc(curves=2**60), "it was cut short or altered"),
        (bcc(count=0), "curve 0 is open and has 0 points; expected at least 4"),
        (bcc(count=5), "curve 0 overruns the file"),
        (bcc(count=-3), "12 bytes are left after the last curve"),
        (bcc(values=[0.0] * 11 + [np.nan]), "curve 0, point 3 is [0.0, 0.0, nan]; coordinates must be finite"),
    ],
)
def test_each_bad_bcc_gets_its_message(tmp_path, content, message):
    path = tmp_path / "y.bcc"
    path.write_bytes(content)
    with refused(path, message):
        read_yarns(path, radius=0.1)


def test_an_open_polyline_bcc_of_two_points_is_a_straight_yarn(tmp_path):
    (tmp_path / "y.bcc").write_bytes(bcc(kind=b"PL", points=2, count=2, values=[0, 0, 0, 3, 0, 4]))
    yarns = read_yarns(tmp_path / "y.bcc", radius=0.1)
    assert yarns.lengths.sum() == pytest.approx(5.0, rel=1e-12)


def test_convert_writes_a_cell_in_every_format(tmp_path):
    write_yarns(tmp_path / "y.h5", woven_cell())
    assert cli.main(["convert", str(tmp_path / "y.h5"), str(tmp_path / "y.pyp")]) == 0
    for suffix in FORMATS:
        assert cli.main(["convert", str(tmp_path / "y.pyp"), str(tmp_path / f"z{suffix}")]) == 0
    assert read_yarns(tmp_path / "z.h5").lattice is not None


@pytest.mark.parametrize(
    ("suffix", "large"),
    [(".bcc", "points"), (".usda", "points"), (".usda", "radius"), (".glb", "radius"), (".yarns", "rest_length")],
)
def test_numbers_beyond_float32_are_not_written(tmp_path, suffix, large):
    values = {"points": np.eye(3), "radius": np.array([0.1]), "rest_length": np.ones(3)}
    values[large] = 1e41 * values[large]
    yarns = YarnSet.from_curves(
        [values["points"]], closed=[True], radius=values["radius"], rest_lengths=[values["rest_length"]]
    )
    with pytest.raises(FileError, match="too large for the format's float32"):
        write_yarns(tmp_path / f"y{suffix}", yarns)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 0\n", "has no 'l' elements"),
        ("v 0 0 0\nl 1 2\n", "line 2: vertex 2 does not exist"),
        ("v 0 0 0\nl 1\n", "line 2: got a polyline of 1 points; expected at least 2"),
        ("v 0 0 0\nv 1 0 0\nl 1 2 1\n", "line 3: got a polyline of 2 points; expected at least 3"),
        ("v 0 0 0\nv 0 0 0\nl 1 2\n", "expected a positive number of cm"),
    ],
)
def test_each_bad_obj_gets_its_message(tmp_path, text, message):
    (tmp_path / "y.obj").write_text(text)
    with refused(tmp_path / "y.obj", message):
        read_yarns(tmp_path / "y.obj", radius=0.1)


def damage(path: Path, name: str, values: object) -> None:
    with h5py.File(path, "r+") as file:
        del file[name]
        if values is not None:
            file[name] = values


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("points", None, "dataset 'points' is missing"),
        ("points", np.full((54, 3), np.nan), "coordinates are not finite"),
        ("start", np.zeros(0, dtype=int), "y.h5"),
        ("start", [0.5, 1.5], "dataset 'start' holds float64; expected int64"),
        ("radius", [0.1, 0.1, 0.1, -0.1], "expected a positive number of cm"),
        ("row", np.zeros(3, dtype=int), "row: got shape (3,)"),
    ],
)
def test_each_damaged_hdf5_gets_its_message(tmp_path, name, values, message):
    path = tmp_path / "y.h5"
    write_yarns(path, awkward_yarns())
    damage(path, name, values)
    with refused(path, message):
        read_yarns(path)


def test_other_hdf5_content_is_an_error(tmp_path):
    path = tmp_path / "y.h5"
    with h5py.File(path, "w") as file:
        file["points"] = np.eye(3)
    with pytest.raises(FileError, match="holds something else; expected 'stitchmesh yarns'"):
        read_yarns(path)
    write_yarns(path, awkward_yarns())
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = 99
    with pytest.raises(FileError, match="has version 99"):
        read_yarns(path)
    path.write_bytes(b"not HDF5")
    with pytest.raises(FileError, match="is not an HDF5 file"):
        read_yarns(path)


def test_the_error_names_the_bad_parameter(tmp_path):
    yarns = awkward_yarns()
    write_yarns(tmp_path / "y.h5", yarns)
    write_yarns(tmp_path / "y.usda", yarns)
    for name in ("y.h5", "y.usda"):
        with pytest.raises(ParameterError, match="fixes or states its unit; leave the unit out"):
            read_yarns(tmp_path / name, unit="mm")
    for name in ("y.h5", "y.usdc", "y.glb"):
        with pytest.raises(ParameterError, match="fixes or states its unit; leave the unit out"):
            write_yarns(tmp_path / name, yarns, unit="mm")
    with pytest.raises(ParameterError, match="got 'ell'; expected one of mm"):
        write_yarns(tmp_path / "y.bcc", yarns, unit="ell")
    with pytest.raises(ParameterError, match="got 'hermite'; expected one of catmull-rom, bspline"):
        write_yarns(tmp_path / "y.bcc", yarns, curve="hermite")
    with pytest.raises(ParameterError, match="radius: got -1"):
        read_yarns(tmp_path / "y.h5", radius=-1.0)
    with pytest.raises(FileError, match=r"unknown format '.txt'; expected one of .h5 .pyp .bcc .usda"):
        write_yarns(tmp_path / "y.txt", yarns)


def test_an_estimated_radius_is_logged_and_a_given_one_is_not(tmp_path, caplog):
    rings = [ring([0, 0, 0]), ring([0, 0, 0.5])]
    write_yarns(tmp_path / "y.bcc", YarnSet.from_curves(rings, closed=[True, True], radius=1.0))
    # The file holds float32.
    np.testing.assert_allclose(read_yarns(tmp_path / "y.bcc").radius, [0.25, 0.25], rtol=1e-6)
    assert [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING] == [
        "yarn radius: 0.25 cm, estimated from the distances between yarns; --yarn-radius sets it"
    ]
    caplog.clear()
    np.testing.assert_array_equal(read_yarns(tmp_path / "y.bcc", radius=0.2).radius, [0.2, 0.2])
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]


@pytest.mark.parametrize("name", ["y.xyz", "y", "folder.bcc"])
def test_check_writable_finds_what_cannot_be_written(tmp_path, name):
    (tmp_path / "folder.bcc").mkdir()
    for refuse in (check_writable, write_yarns):
        with pytest.raises(FileError, match="expected"):
            refuse(tmp_path / name, awkward_yarns())


@pytest.mark.parametrize("kind", ODD_POINTS)
def test_hdf5_numbers_that_are_not_in_the_file_or_far_larger_are_refused(tmp_path, kind):
    path = tmp_path / "y.h5"
    write_yarns(path, awkward_yarns())
    (tmp_path / "secret").write_bytes(bytes(10_000))
    store_points_oddly(path, kind, str(tmp_path / "secret"))
    large = "bytes of numbers, more than 100 times"
    expected = {"bomb": large, "huge": large, "virtual": "other data than texts in a heap",
                "chunks": "into 1000[0-9]{2} chunks"}  # fmt: skip
    with pytest.raises(FileError, match=expected.get(kind, "expected numbers in the file itself")):
        read_yarns(path)


def test_a_heap_of_hdf5_that_leads_back_to_itself_is_an_error_and_not_read_for_ever(tmp_path):
    write_yarns(tmp_path / "y.h5", awkward_yarns())
    content = bytearray((tmp_path / "y.h5").read_bytes())
    place = content.find(b"GCOL") + 16
    while content[place : place + 2] != b"\0\0":  # The last object of the heap is the free space.
        place += 16 + -(-int.from_bytes(content[place + 8 : place + 16], "little") // 8) * 8
    content[place + 8 : place + 16] = bytes(8)
    (tmp_path / "y.h5").write_bytes(content)
    with pytest.raises(FileError, match="an object of 0 bytes in a heap"):
        read_yarns(tmp_path / "y.h5")


@pytest.mark.parametrize("options", [{"compression": "gzip"}, {"chunks": (100, 3)}])
def test_hdf5_datasets_that_other_programs_divide_into_chunks_are_read(tmp_path, options):
    points = np.cumsum(np.ones((100_000, 3)), axis=0)
    write_yarns(tmp_path / "y.h5", YarnSet.from_curves([points], closed=[False], radius=0.1))
    with h5py.File(tmp_path / "y.h5", "r+") as file:
        del file["points"]
        file.create_dataset("points", data=points, **options)
    np.testing.assert_array_equal(read_yarns(tmp_path / "y.h5").points, points)
