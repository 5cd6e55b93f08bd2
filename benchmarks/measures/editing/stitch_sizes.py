# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest sizes of stitches for mesh relaxation without a surface, from relaxed swatches of the library.

Relaxes patterns of the library as free swatches. The factors of ``stitchmesh.meshrelax.free.stitch_sizes`` are fitted
to the logarithms of wale and course spacing relative to stockinette: those of rib, garter stitch and seed stitch to the
pure fabrics, and that of slips to what remains in the patterns with slipped stitches. Prints the factors, the sizes by
the factors beside those of the yarns for every pattern of knit, purled and slipped stitches, and for lace, whose size
is not fitted, the size of the natural outline beside that of the yarns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import stitchmesh as sm
from benchmarks.table import Rows, note
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.meshrelax.free.stitch_sizes import fabric_shares
from stitchmesh.run import QUIET

FLAT_STITCHES = [Stitch.KNIT, Stitch.PURL, Stitch.SLIP_BACK, Stitch.SLIP_FRONT]
"""Stitches of the patterns that are fitted first."""
PURE = ("stockinette", "garter", "rib1x1", "rib2x2", "rib3x3", "seed")
"""Patterns that are one of the four fabrics."""
LARGEST = 150
"""Most stitches of a repeat; larger ones relax for minutes on a CPU."""


@dataclass(frozen=True)
class Measured:
    """A relaxed pattern."""

    name: str
    size: FloatArray
    """Logarithms of wale and course spacing [cm], shape (2,)."""
    outline: FloatArray
    """The same of the natural outline, over that of plain knit."""
    shares: FloatArray
    """Mean shares of its stitches, shape (4,)."""
    is_lace: bool
    """Whether it has yarn-overs, increases or decreases."""


def stitch_sizes() -> Rows:
    """Relax the swatches and fit the factors."""
    measured = [each for name in sm.pattern_names() if (each := measure(name)) is not None]
    plain = next(each.size for each in measured if each.name == "stockinette")
    flat, lace = ([each for each in measured if each.is_lace == kind] for kind in (False, True))
    shares = np.array([each.shares for each in flat])
    found = np.array([each.size - plain for each in flat])
    factors = fitted_factors([each.name for each in flat], shares, found)
    yield from fit("by the factors", flat, found, shares @ factors)
    for name, values in zip(("WIDTH", "HEIGHT"), factors.T, strict=True):
        yield f"{name} = {values.round(3).tolist()}"
    drawn = np.array([each.outline for each in lace])
    yield from fit("natural outline", lace, np.array([each.size - plain for each in lace]), drawn)


def fitted_factors(names: list[str], shares: FloatArray, found: FloatArray) -> FloatArray:
    """Return the factors of each share for width and height, shape (4, 2).

    Args:
        names: names of the patterns.
        shares: their mean shares, shape (n, 4).
        found: logarithms of their sizes over those of stockinette, shape (n, 2).
    """
    pure = np.isin(names, PURE)
    first = np.linalg.lstsq(shares[pure, :3], found[pure], rcond=None)[0]
    last = np.linalg.lstsq(shares[:, 3:], found - shares[:, :3] @ first, rcond=None)[0]
    return np.concatenate([first, last])


def fit(title: str, measured: list[Measured], found: FloatArray, fitted: FloatArray) -> Rows:
    """Yield the sizes over plain knit as measured and as fitted, and the root mean square of the differences."""
    yield "pattern", "relaxed yarns", title
    for each, one, other in zip(measured, np.exp(found), np.exp(fitted), strict=True):
        yield each.name, f"{one[0]:.2f} x {one[1]:.2f}", f"{other[0]:.2f} x {other[1]:.2f}"
    width, height = np.sqrt(np.mean((fitted - found) ** 2, axis=0))
    yield f"root mean square of the logarithm of the ratio: width {width:.3f}, height {height:.3f}"


def measure(name: str) -> Measured | None:
    """Relax a pattern, or return None if it is large or has cables, whose crossings draw in by themselves."""
    pattern = sm.read_pattern(name)
    fabric = sm.torus_mesh(pattern, stitch_width=1.0, stitch_height=1.0)
    if fabric.face_count > LARGEST or fabric.cable_shift.any():
        return None
    report = sm.swatch(pattern, relax_cell=True, quality="draft", progress=False).report
    size = np.array([report["wale_spacing"], report["course_spacing"]])
    note(f"{name}: {size.round(3).tolist()} cm")
    measures = sm.natural_outline(pattern, "lattice", run=QUIET).measures()
    outline = np.log([measures["width_over_plain"], measures["height_over_plain"]])
    shares = fabric_shares(fabric).mean(axis=0)
    return Measured(name, np.log(size), outline, shares, not np.isin(fabric.stitch, FLAT_STITCHES).all())
