# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A plain weave that is too dense for round yarns is reported as jammed, and other weaves are not."""

from __future__ import annotations

import logging
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.periodic.swatch import swatch
from stitchmesh.periodic.weave.jamming import interlaced_blocks, jam_report
from stitchmesh.periodic.weave.library import read_weave
from stitchmesh.periodic.weave.weave import Thread, Weave
from stitchmesh.periodic.weave.yarns import weave_yarns

pytestmark = pytest.mark.decides

RADIUS = 0.125
PLAIN = ((0, 1), (1, 0))


def report(weave: Weave, spacing: float | tuple[float, float]) -> dict[str, Any]:
    """Return the jam report of a generated weave; spacings of warps and of wefts are given in yarn diameters."""
    warp, weft = np.broadcast_to(spacing, 2).tolist()
    size = (2 * RADIUS * warp, 2 * RADIUS * weft)
    return jam_report(weave, weave_yarns(weave, yarn_radius=RADIUS, spacing=size, quality="draft"))


@pytest.mark.parametrize(("spacing", "jammed"), [(1.73, True), (1.734, False)])
def test_a_square_plain_weave_jams_below_the_square_root_of_three_diameters(spacing: float, jammed: bool) -> None:
    found = report(Weave(PLAIN), spacing)
    assert found["jammed"] is jammed
    assert found["jam_ratio"] == pytest.approx(2 * np.sqrt(1 - (spacing / 2) ** 2), rel=1e-9)  # rounding


def test_closer_wefts_need_wider_warp_spacing() -> None:
    """Peirce 1937: if both yarns jam, cos a + cos b = 1; at two diameters the other yarn has all the crimp."""
    weft = 1.5
    warp = 2 * np.sqrt(1 - (1 - np.sqrt(1 - (weft / 2) ** 2)) ** 2)
    assert report(Weave(PLAIN), (0.999 * warp, weft))["jammed"]
    assert not report(Weave(PLAIN), (1.001 * warp, weft))["jammed"]
    assert not report(Weave(PLAIN), (2.0, 1.01))["jammed"]


def test_the_jam_ratio_of_two_diameters_uses_their_sums() -> None:
    weave = Weave(PLAIN, wefts=(Thread(radius=1.5),) * 2, warps=(Thread(radius=0.5),) * 2)
    assert report(weave, 1.7)["jam_ratio"] == pytest.approx(report(Weave(PLAIN), 1.7)["jam_ratio"], rel=1e-9)
    uneven = Weave(PLAIN, warps=(Thread(radius=1.5), Thread(radius=0.5)))
    drawn = weave_yarns(uneven, yarn_radius=RADIUS, spacing=3.4 * RADIUS, quality="draft")
    # sums of radii of the arcs around both warps, and around the wefts for each warp
    along_wefts, thick, thin = 4.0, 2 * 2.5, 2 * 1.5
    expected = sum(np.sqrt(max(arcs**2 - 3.4**2, 0.0)) for arcs in (along_wefts, along_wefts, thick, thin)) / 8.0
    assert jam_report(uneven, drawn)["jam_ratio"] == pytest.approx(expected, rel=1e-9)


def test_the_closest_neighbours_decide_across_the_border_of_the_repeat_too() -> None:
    even = weave_yarns(Weave(PLAIN), yarn_radius=RADIUS, spacing=4 * RADIUS, quality="draft")
    points = even.points.copy()
    last = slice(even.start[-2], even.start[-1])
    points[last, 0] += 0.8 * RADIUS  # moves the last warp towards the first warp of the next repeat
    moved = replace(even, points=points)
    gaps = sorted(block.gap[0] / RADIUS for block in interlaced_blocks(Weave(PLAIN), moved))
    assert gaps == pytest.approx([3.2, 3.2, 4.8, 4.8], rel=1e-9)
    # at a spacing of two diameters wefts can bend freely; a warp spacing of 1.6 leaves half of the sum
    assert jam_report(Weave(PLAIN), moved)["jam_ratio"] == pytest.approx(0.6, rel=1e-9)
    # in another image of the lattice the warp has the same neighbour
    points[last] += even.lattice.periods[0]  # type: ignore[union-attr]
    assert jam_report(Weave(PLAIN), replace(even, points=points))["jam_ratio"] == pytest.approx(0.6, rel=1e-9)


@pytest.mark.parametrize("name", ["satin-3x2", "twill-2x1", "basket-2x2"])
def test_weaves_with_floats_have_no_blocks_of_plain_weave(name: str) -> None:
    assert report(read_weave(name), 1.6) == {"jammed": False, "jam_ratio": 0.0}


def test_layers_of_a_double_weave_are_checked_separately() -> None:
    found = report(read_weave("double-plain-stitched"), 1.8)
    assert found["jam_ratio"] == pytest.approx(2 * np.sqrt(1 - 0.9**2), rel=1e-9)


def test_a_rotated_cell_has_the_same_jam_ratio() -> None:
    yarns = weave_yarns(Weave(PLAIN), yarn_radius=RADIUS, spacing=3.2 * RADIUS, quality="draft")
    assert yarns.lattice is not None
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    turned = replace(yarns, points=yarns.points @ turn, lattice=Lattice(yarns.lattice.periods @ turn))
    assert jam_report(Weave(PLAIN), turned)["jam_ratio"] == pytest.approx(1.2, rel=1e-9)


def test_a_jammed_swatch_logs_one_warning(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "stitchmesh"):
        made = swatch("plain", spacing=0.4, quality="draft", device="cpu")
    warnings = [record.message for record in caplog.records if "jammed" in record.message]
    assert len(warnings) == 1
    pairs = "wefts (1 and 2|2 and 1) and warps (1 and 2|2 and 1)"  # either one is the nearer
    assert re.search(f"{pairs}: got warp spacing 1.60 and weft spacing 1.60 yarn diameters", warnings[0])
    assert "expected 1.73 and 1.73" in warnings[0] and "widen the spacing or take thinner yarn" in warnings[0]
    # with the relaxed positions
    assert made.report["jammed"] and made.report["jam_ratio"] == pytest.approx(1.2, rel=1e-3)


def test_wide_spacing_and_floats_cause_no_warning(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "stitchmesh"):
        plain = swatch("plain", spacing=0.45, quality="draft", device="cpu").report
        satin = swatch("satin-3x2", spacing=0.4, quality="draft", device="cpu").report
    assert (plain["jammed"], satin["jammed"]) == (False, False)
    assert "jammed" not in caplog.text
    assert "jammed" not in swatch("stockinette", quality="draft", device="cpu").report
