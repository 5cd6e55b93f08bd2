# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns in ``.yarns`` files: round trips, files of other programs, and one message for each malformed chunk."""

from __future__ import annotations

import dataclasses
import struct

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import read_yarns, write_yarns
from stitchmesh.io.yarn_formats.midpoint_curve import knots_of_polyline, midpoint_curve, polyline_of_knots
from tests.io.yarn_sets import awkward_yarns


def chunk(tag: bytes, *values: bytes) -> bytes:
    data = b"".join(values)
    return tag + struct.pack("<I", len(data)) + data


POINTS = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (0, 2, 0), (1, 2, 0), (1, 3, 0), (0, 2, 0)]


def file_of_another_program(
    *, points: list = POINTS, yarns: tuple = ((0, 4), (4, 8)), marks: tuple | None = ()
) -> bytes:
    """Return a straight yarn, and a closed one, with red and blue yarn and lengths in two units."""
    colours = [b"\xff\0\0\xff", b"\0\0\xff\x80"]
    parts = [
        chunk(b"f3..", *(struct.pack("<3f", *point) for point in points)),
        chunk(b"src.", struct.pack(f"<{len(points)}I", *range(len(points)))),
        chunk(b"yarn", *(struct.pack("<IIf", a, b, 0.25) + c for (a, b), c in zip(yarns, colours, strict=True))),
    ]
    if marks is not None:
        parts.append(chunk(b"strs", b"1na"))
        parts.append(chunk(b"unit", struct.pack("<IIf", 0, 1, 1.0), struct.pack("<IIf", 1, 3, 0.5)))
        parts.append(chunk(b"chk.", *(struct.pack("<IfI", *mark) for mark in marks)))
    return b"".join(parts)


def read(folder, content):
    (folder / "a.yarns").write_bytes(content)
    return read_yarns(folder / "a.yarns")


def test_yarns_return_from_a_file(tmp_path):
    """Coordinates, radii and rest lengths are rounded to float32; the ends of open yarns are read as straight."""
    yarns = dataclasses.replace(awkward_yarns(), colour=[0, 1, 1, 2], palette=np.eye(3, dtype=np.uint8) * 200)
    write_yarns(tmp_path / "a.yarns", yarns)
    again = read_yarns(tmp_path / "a.yarns")
    np.testing.assert_array_equal(again.closed, yarns.closed)
    for before, after in zip(yarns.sampled(1), again.sampled(1), strict=True):
        # The polyline solves 6 P + its neighbours = 8 K, so that the rounding of P, 6e-8 of it, stays as small in K.
        np.testing.assert_allclose(after, before, atol=1e-6 * np.abs(before).max())
    np.testing.assert_allclose(again.radius, yarns.radius, rtol=1e-7)
    np.testing.assert_allclose(again.rest_length, yarns.rest_length, rtol=1e-6)
    np.testing.assert_array_equal(again.palette[again.colour], yarns.palette[yarns.colour])


def test_a_file_of_another_program_is_read(tmp_path):
    """Checkpoints at points 1 and 3 of the first yarn: 1 + 2 * 0.5 is the length between them."""
    yarns = read(tmp_path, file_of_another_program(marks=((1, 1.0, 0), (1, 2.0, 1), (3, 0.0, 0))))
    assert yarns.closed.tolist() == [False, True]
    assert yarns.radius.tolist() == [0.25, 0.25]
    assert yarns.palette[yarns.colour].tolist() == [[255, 0, 0], [0, 0, 255]]
    np.testing.assert_allclose(yarns.lengths[:3], [1.0, 1.0, 1.0], rtol=1e-12)
    np.testing.assert_allclose(yarns.rest_length[:3], [1.0, 1.0, 1.0], rtol=1e-12)
    yarns = read(tmp_path, file_of_another_program(marks=((1, 1.0, 0), (1, 4.0, 1), (3, 0.0, 0))))
    np.testing.assert_allclose(yarns.rest_length[:3], [1.0, 1.5, 1.5], rtol=1e-12)


def test_the_last_three_chunks_may_be_missing(tmp_path):
    yarns = read(tmp_path, file_of_another_program(marks=None))
    np.testing.assert_array_equal(yarns.rest_length, yarns.lengths)


@pytest.mark.parametrize("closed", [False, True])
def test_knots_lie_on_the_curve_of_the_polyline(closed):
    corners = np.random.default_rng(1).normal(size=(9, 3))
    corners = np.concatenate([corners, corners[:1]]) if closed else corners
    knots = knots_of_polyline(corners, closed)
    curve = midpoint_curve(corners, False)
    at = np.stack([np.interp(curve.corner, np.arange(len(curve.points)), axis) for axis in curve.points.T], axis=1)
    np.testing.assert_allclose(at[: len(knots)], knots, atol=1e-12)
    np.testing.assert_allclose(polyline_of_knots(knots, closed), corners, atol=1e-12)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"BCC\x44", "byte 0: got 'BCCD'; expected the chunk 'f3..'"),
        (file_of_another_program(marks=((1, 1.0, 0),))[:-3], "chunk 'chk.' has 12 bytes; .*cut short"),
        (file_of_another_program() + b"x", "1 bytes are left after the last chunk"),
        (chunk(b"f3..", b"1234"), "chunk 'f3..' has 4 bytes; expected a multiple of 12"),
        (file_of_another_program(points=[(0, 0, np.nan), *POINTS[1:]]), "point 0 is .*must be finite"),
        (file_of_another_program(yarns=((0, 4), (3, 8))), "yarn 1: got points 3 to 8"),
        (file_of_another_program(yarns=((0, 4), (4, 9))), "yarn 1: got points 4 to 9"),
        (file_of_another_program(yarns=((0, 1), (4, 8))), "yarn 0: got points 0 to 1; expected two or more"),
        (file_of_another_program(marks=((1, 1.0, 2),)), "checkpoint 0: got point 1 and unit 2"),
        (file_of_another_program(marks=((1, -1.0, 0),)), "checkpoint 0: got a length of -1.0"),
    ],
)
def test_each_malformed_chunk_gets_its_message(tmp_path, content, message):
    with pytest.raises(FileError, match=message):
        read(tmp_path, content)
