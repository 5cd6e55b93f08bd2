# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What weights that balance uniform tension do to cloth that wrinkles or is sheared, beside the weights of alpha.

The regions made by hand of ``mixed_loadings`` run from two starts each, with energies of stretch of weight alpha and
with balanced weights. A run is compared with the one with yarns everywhere from the same start, by the root mean square
distance of the nodes of the measured part in yarn spacings, and by the products that it takes.
"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass

import numpy as np
from tyro.conf import Positional

from benchmarks.measures.mixed.loadings import LOADINGS, Loading
from benchmarks.measures.mixed.mixed import End, run_scene, with_rings
from benchmarks.measures.mixed.mixed_patch_test import weights_of_alpha
from benchmarks.measures.mixed.node_errors import position_error
from benchmarks.table import Rows
from stitchmesh.mixed.scene.scene import SolverSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, with_region

SOLVER = SolverSection(force_tolerance=0.1, most_iterations=2000)
SEEDS = (0, 1)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    loading: Positional[tuple[str, ...]]
    rings: tuple[int, ...] = (1, 2)
    """hybrid widths"""


def mixed_weights(options: Options) -> Rows:
    """Yield a row for each region."""
    yield "loading", "region", "rings", "nodes", "alpha", "balanced", "products, alpha", "balanced"
    for name in options.loading:
        loading = LOADINGS[name](SOLVER)
        starts = [loading.shaken(seed) for seed in SEEDS]
        everything = np.arange(len(loading.prepared.fabric.cloth.triangles))
        full = [run_scene(with_region(start, everything)) for start in starts]
        for rings in options.rings:
            for size in loading.sizes:
                chosen = [with_region(with_rings(start, rings), loading.by_hand(size)) for start in starts]
                yield row(loading, size, chosen, full)


def row(loading: Loading, size: float, chosen: list[PreparedScene], full: list[End]) -> tuple[object, ...]:
    """A row of the table: distances from both starts, and products from the first one."""
    errors, products = [], []
    for context in (weights_of_alpha(), nullcontext()):
        with context:
            ends = [run_scene(prepared) for prepared in chosen]
        near = loading.near
        found = [
            position_error(end.nodes[near], one.nodes[near], loading.spacing)
            for end, one in zip(ends, full, strict=True)
        ]
        errors.append(", ".join(f"{error:.3f}" for error in found))
        products.append(f"{ends[0].products:,}")
    nodes, rings = len(chosen[0].region.nodes), chosen[0].scene.region.rings
    return loading.name, f"{size:.3g} cm", rings, nodes, *errors, *products
