# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Other samplings of the same curves: they keep curves, lengths and linking, and are even."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import stitchmesh as sm
from stitchmesh.errors import YarnError
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.patterns import read_pattern
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.quality import PRESETS
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from tests.periodic.free_cells import drawn, free_swatch, yarn_lengths

PATTERNS = ["linen-stitch", "rope-cable", "plain"]


def sampled(pattern: str, points: int) -> YarnSet:
    """The yarns of a repeat with some control points for each stitch."""
    return drawn(pattern, replace(PRESETS["draft"], control_points_per_stitch=points))


def distance(curves: YarnSet, other: YarnSet) -> float:
    """Return the largest distance of a place on one set of yarns from the other set and its images [radii]."""
    assert curves.lattice is not None
    images = curves.lattice.shift(np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]))
    places = np.concatenate([np.concatenate(curves.sampled(40)) + shift for shift in images])
    return float(cKDTree(places).query(np.concatenate(other.sampled(4)))[0].max() / curves.radius[0])


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_finer_sampling_has_the_same_curves(pattern: str) -> None:
    yarns = sampled(pattern, 16)
    found = sample_evenly(yarns, sampled(pattern, 48))
    # a spline through places of a spline has its third derivative between other knots: a few hundredths of a radius
    assert distance(yarns, found) < 0.15
    refuse_pull_through(yarns, found)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_each_yarn_keeps_its_length_and_has_equal_segments(pattern: str) -> None:
    yarns, like = sampled(pattern, 16), sampled(pattern, 26)
    found = sample_evenly(yarns, like)
    np.testing.assert_array_equal(found.start, like.start)
    np.testing.assert_array_equal(found.face, like.face)
    before, after = (yarn_lengths(each) for each in (yarns, found))
    np.testing.assert_allclose(after, before, rtol=1e-14)  # rounding of sums
    for first, last in zip(found.segment_start, found.segment_start[1:], strict=False):
        assert np.ptp(found.rest_length[first:last]) == 0.0


def test_a_sampling_commutes_with_a_motion_along_the_yarn() -> None:
    """A closed yarn whose control points are numbered from another one passes through the same places."""
    yarns, like = sampled("stockinette", 16), sampled("stockinette", 32)
    step = yarns.lattice.shift(yarns.lattice_step)
    count = yarns.start[1]
    moved = yarns.points.copy()
    moved[:count] = np.concatenate([yarns.points[4:count], yarns.points[:4] + step[0]])
    found, turned = sample_evenly(yarns, like), sample_evenly(replace(yarns, points=moved), like)
    own = slice(0, like.start[1])
    expected = np.concatenate([found.points[own][8:], found.points[own][:8] + step[0]])
    np.testing.assert_allclose(turned.points[own], expected, rtol=0, atol=1e-6 * yarns.radius[0])


def test_an_open_yarn_keeps_its_ends() -> None:
    angle = np.linspace(0.0, 3.0, 20)
    arc = np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1)
    yarns = YarnSet.from_curves([arc], closed=[False], radius=0.05)
    found = sample_evenly(yarns, YarnSet.from_curves([np.repeat(arc, 2, axis=0)], closed=[False], radius=0.05))
    ends = [each.sampled(1)[0][[0, -1]] for each in (yarns, found)]
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-7)
    assert found.lengths.sum() == pytest.approx(yarns.lengths.sum(), rel=1e-3)


def test_other_yarns_are_refused() -> None:
    with pytest.raises(YarnError, match="got 2 yarns and 4 others; expected the same yarns"):
        sample_evenly(sampled("stockinette", 12), sampled("plain", 12))
    curved = sampled("plain", 12)
    with pytest.raises(YarnError, match="expected straight yarns"):
        sample_evenly(replace(curved, natural_curvature=np.ones(len(curved.points))), curved)


def test_yarns_as_generated_come_to_the_size_of_the_swatch_only_if_they_are_sampled_evenly() -> None:
    """Uneven segments hold stockinette in its generated shape: a free cell is too wide, and strained."""
    found, loop = free_swatch("stockinette"), 16.67 * 0.25
    fabric = sm.torus_mesh(read_pattern("stockinette"), stitch_width=1.0, stitch_height=0.77)
    quality = replace(PRESETS["draft"], control_points_per_stitch=16, tolerance=0.002)
    yarns = sm.generate_yarns(fabric, yarn_radius=0.125, quality=quality)
    yarns = sm.apply_rest_lengths(yarns, sm.RestLengths(loop_length=loop), fabric=fabric)

    def at_rest(start: YarnSet) -> sm.Relaxation:
        return sm.relax_yarns(start, quality=quality, device="cpu", cell=sm.RelaxCell(shear=False), run=Run(False))

    even, uneven = at_rest(sm.sample_evenly(yarns)), at_rest(yarns)
    width, held = (np.linalg.norm(each.yarns.lattice.periods[0]) for each in (even, uneven))
    # the sampling and the tolerance of draft leave less than 1 % each
    assert width == pytest.approx(found.report["wale_spacing"], rel=0.02)
    # no tolerance of a relaxation is near these bounds, which are half of 15 % and a tenth of a factor of 1,100
    assert held > 1.08 * width
    assert uneven.report["energies"]["stretch"] > 100.0 * even.report["energies"]["stretch"]
