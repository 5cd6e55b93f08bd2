# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation on a CPU has the same bits for any number of threads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.linking.certificate import linking_certificate
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.quality import PRESETS
from stitchmesh.simulation.dead_load import Gravity
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.energies.twist import Twist
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.compute.thread_counts import thread_count
from tests.gallery import grid, tube
from tests.yarnrelax.stockinette import periodic_patch, woven_cell

BRIEF = replace(PRESETS["draft"], max_iterations=60)


@cache
def piece() -> tuple[sm.StitchMesh, YarnSet]:
    """A piece of a garment with two dozen parts in each launch."""
    fabric = sm.tessellate(sm.label(tube(8, 2, radius=2.0, height=2.0)), stitch_width=0.9)
    return fabric, sm.generate_yarns(fabric, quality="draft")


def below(yarns: YarnSet) -> Mesh:
    """A floor below the yarns."""
    floor = grid(2, 2, width=8.0, height=8.0)
    down = float(yarns.points[:, 2].min()) - 0.5
    return replace(floor, vertices=floor.vertices + np.array([-8.0, -8.0, down]))


def garment() -> FloatArray:
    """A piece of a garment that keeps its shape."""
    fabric, yarns = piece()
    return relax_yarns(yarns, quality=BRIEF, device="cpu", keep_shape=fabric).yarns.points


def garment_with_all_terms() -> FloatArray:
    """The same in another precision and with every other term."""
    _, yarns = piece()
    terms = [Gravity(), Friction(0.2), Twist(5.0), Body(below(yarns))]
    quality = replace(BRIEF, precision="float64", max_iterations=40)
    return relax_yarns(yarns, quality=quality, device="cpu", terms=terms).yarns.points


def small_cells() -> FloatArray:
    """Cells that run all iterations of an interval in one launch."""
    cells = [periodic_patch(1, 1), woven_cell(), periodic_patch(2, 3), periodic_patch(1, 2)]
    found = relax_cells(cells, quality=BRIEF, free=[RelaxCell()] * len(cells), device="cpu")
    return np.concatenate([cell.yarns.points for cell in found.cells])


def large_cells() -> FloatArray:
    """Cells that run every step as a launch of its own."""
    cells = [periodic_patch(6, 6), periodic_patch(4, 7)]
    found = relax_cells(cells, quality=BRIEF, free=[RelaxCell()] * len(cells), device="cpu")
    return np.concatenate([cell.yarns.points for cell in found.cells])


def dynamics() -> FloatArray:
    """The other solver."""
    quality = replace(BRIEF, solver="dynamics")
    return relax_yarns(piece()[1], material=YarnMaterial.named("leaf"), quality=quality, device="cpu").yarns.points


@pytest.mark.parametrize("relaxed", [garment, garment_with_all_terms, small_cells, large_cells, dynamics])
def test_relaxed_yarns_have_the_same_bits_for_any_number_of_threads(relaxed: Callable[[], FloatArray]) -> None:
    found = []
    for threads in (1, 3):
        with thread_count(threads):
            found.append(relaxed())
    assert np.array_equal(*found)


def test_the_certificate_does_not_depend_on_the_number_of_threads() -> None:
    found = []
    for threads in (1, 3):
        with thread_count(threads):
            found.append(linking_certificate(piece()[1], device="cpu"))
    assert (found[0] != found[1]).nnz == 0
