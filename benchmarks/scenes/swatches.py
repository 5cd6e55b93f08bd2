# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches: the corpus of Leaf et al. 2018 (L), and variants of small repeats of the library."""

from __future__ import annotations

import itertools

import numpy as np

import stitchmesh as sm
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.library import weave_names
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet

LEAF: dict[str, tuple[float, float, int]] = {
    "alternating-diagonals": (2.18, 0.95, 3794), "basketweave-rib-stitch": (0.79, 0.58, 1714),
    "block1": (0.09, 1.17, 5686), "block2": (0.06, 0.78, 2054), "cartridge-belt-rib": (0.45, 0.44, 423),
    "double-basket-pattern": (3.00, 0.88, 4860), "garter-block": (0.13, 0.61, 2054), "honeycomb": (0.33, 0.77, 3392),
    "jacquard1": (0.38, 0.50, 1504), "jacquard2": (0.18, 0.54, 1433), "jacquard3": (0.29, 0.59, 2106),
    "king-charles-brocade": (1.36, 0.58, 2394), "lattice-with-seed-stitch": (0.55, 1.12, 7280),
    "left-diagonal": (0.05, 0.50, 723), "left-diagonal-rib": (0.68, 0.58, 1374),
    "long-slip-textured": (0.10, 0.42, 456), "parallelograms": (0.19, 0.64, 2732),
    "pie-crust-basketweave": (0.15, 0.65, 986), "pyramid-stitch": (0.68, 0.58, 2198),
    "rhombus-texture": (1.30, 0.60, 2394), "right-diagonal": (0.37, 0.44, 723),
    "right-diagonal-rib": (0.45, 0.55, 1374), "seersucker": (1.09, 0.49, 1230),
    "slip-stitch-honeycomb": (0.27, 0.43, 284), "slip-stitch-rib": (0.43, 0.41, 248),
    "stockinette-and-garter": (26.54, 1.52, 10890), "thunderbird": (10.91, 1.08, 7280),
    "tumbling-moss-blocks": (0.02, 1.14, 3214), "woven-transverse-herringbone": (0.61, 0.59, 1996),
    "basket-2x2": (0.09, 0.49, 180), "basket-3x3": (0.11, 0.50, 304), "plain": (0.16, 0.42, 88),
    "satin-2x3": (0.25, 0.48, 238), "satin-3x2": (0.23, 0.44, 238), "twill-2x1": (0.19, 0.44, 130),
    "twill-3x2": (0.12, 0.51, 238), "twill-4x1": (0.38, 0.45, 238),
}  # fmt: skip
"""Seconds until convergence, milliseconds per step, and number of control points in L's table 3."""
CELLS = (*LEAF, *(name for name in weave_names() if name not in LEAF))
"""The corpus, and all other weaves: periodic cells whose periods are as generated."""


def cell_of(name: str, quality: str | Quality) -> YarnSet:
    """One period of a pattern as generated."""
    return draw_swatch(resolve_pattern(name), SwatchOptions(), quality_named(quality))[1]


SMALL = (
    "stockinette", "reverse-stockinette", "garter", "rib1x1", "rib2x2", "rib3x3", "twisted-rib", "seed", "moss",
    "cartridge-belt-rib", "half-cardigan", "linen-stitch", "slip-stitch-rib", "slip-stitch-honeycomb",
    "long-slip-textured",
)  # fmt: skip
"""Patterns whose smallest cell has at most 16 stitches."""
MATERIALS = ("stitchmesh", "leaf", "kaldor-simulation")
LOOPS = np.linspace(14.5, 22.0, 23)
"""Loop lengths [yarn diameters]."""
DIAMETER = 0.25
"""Diameter of the yarn [cm]."""
Variant = tuple[str, float, str]
"""Pattern, loop length [yarn diameters] and material."""


def variants(count: int) -> list[Variant]:
    """Variants, evenly chosen from all small patterns, loop lengths and materials."""
    grid = list(itertools.product(SMALL, LOOPS.tolist(), MATERIALS))
    return [grid[number] for number in evenly(len(grid), count)]


def requested(variant: Variant, quality: str) -> sm.SwatchRequest:
    """A variant as a free swatch without friction."""
    pattern, loop, material = variant
    return sm.SwatchRequest(
        pattern, material=sm.YarnMaterial.named(material), quality=quality, relax_cell=True,
        options={"relaxation": "frictionless", "loop_length": loop * DIAMETER},
    )  # fmt: skip


def evenly(length: int, count: int) -> list[int]:
    """Evenly spaced indices of at most ``count`` entries of a sequence."""
    return np.linspace(0, length - 1, min(count, length)).round().astype(int).tolist()
