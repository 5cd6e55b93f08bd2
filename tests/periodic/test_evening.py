# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn evened out within stitches is the same in a cell and in its tilings, and as long as before."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.patterns import Pattern, parse_pattern, read_pattern
from stitchmesh.periodic.evening import evened
from stitchmesh.periodic.swatch import SwatchOptions, drawn
from stitchmesh.periodic.torus import torus_mesh
from stitchmesh.quality import quality_named
from stitchmesh.rest_length import segment_faces
from stitchmesh.yarngen import generate_yarns

ONE_STITCH = "round 1: k\n"
SLIPPED = "slip-stitch-honeycomb"


def by_stitch(pattern: Pattern, columns: int, rows: int) -> list[np.ndarray]:
    """Rest lengths in each stitch of the tiling, in ascending order."""
    options = SwatchOptions(columns=columns, rows=rows)
    fabric, yarns = drawn(pattern, options, quality_named("standard"))
    assert fabric is not None
    face = segment_faces(yarns)
    return [np.sort(yarns.rest_length[face == stitch]) for stitch in range(fabric.face_count)]


@pytest.mark.parametrize(("columns", "rows"), [(2, 1), (1, 2), (2, 2), (3, 3)])
def test_tilings_of_one_stitch_have_its_rest_lengths_in_every_segment(columns: int, rows: int) -> None:
    one = by_stitch(parse_pattern(ONE_STITCH), 1, 1)
    many = by_stitch(parse_pattern(ONE_STITCH), columns, rows)
    assert len(many) == columns * rows
    np.testing.assert_allclose(many, one * len(many), rtol=1e-12)  # sums in another order


def test_so_have_those_of_a_repeat_of_slips() -> None:
    """Faces are numbered tile by tile."""
    one, many = (by_stitch(read_pattern("slip-stitch-rib"), *size) for size in ((1, 1), (2, 2)))
    for found, expected in zip(many, 4 * one, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12)  # sums in another order


@pytest.mark.parametrize("pattern", ["stockinette", SLIPPED])
def test_own_yarn_and_the_loops_below_keep_their_lengths(pattern: str) -> None:
    fabric = torus_mesh(read_pattern(pattern), stitch_width=1.0, stitch_height=0.8)
    yarns = generate_yarns(fabric, quality="draft")
    even = evened(yarns, fabric)
    point = yarns.segment_points[:, 1]
    # these repeats have rows enough to tell a stitch's own yarn from the loops below by its row
    group = np.stack([yarns.segment_yarn, yarns.face[point], yarns.row[point]], axis=1)
    _, run = np.unique(group, axis=0, return_inverse=True)
    np.testing.assert_allclose(
        np.bincount(run, even.rest_length), np.bincount(run, yarns.rest_length), rtol=1e-12
    )  # rounding
    spread = [np.ptp(even.rest_length[run == number]) for number in range(run.max() + 1)]
    np.testing.assert_allclose(spread, 0.0, atol=1e-12)
