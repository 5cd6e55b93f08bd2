# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a yarn is in the units of mills, laboratories and hand knitters, and the coefficients that follow from it."""

from __future__ import annotations

import math

from stitchmesh.reporting.figures import Figure
from stitchmesh.yarn.yarn_presets import CENTIMETRES_PER_INCH, TWIST_OVER_BEND, Yarn, YarnMechanics
from stitchmesh.yarnrelax.model.material import YarnMaterial

ENGLISH_COUNT = 590.5
"""English cotton count times tex: 840 yards of Ne 1 weigh a pound."""


def yarn_figures(yarn: Yarn) -> list[Figure]:
    """Return the figures of a yarn, first what it is, and then what the simulation makes of it."""
    material, mechanics = YarnMaterial.of_yarn(yarn), yarn.mechanics
    tex, thick, core = 1e5 * yarn.mass_per_length, 2.0 * yarn.apparent_radius, 2.0 * yarn.core_radius
    loop = yarn.loop_length
    counts = f"{tex:.4g} tex, Nm {1e3 / tex:.3g}, Ne {ENGLISH_COUNT / tex:.3g}, {9.0 * tex:.4g} denier"
    found = [
        Figure("linear density", counts, "mass of a length, and length of a mass"),
        Figure("thickness", f"{10.0 * thick:.3g} mm, {CENTIMETRES_PER_INCH / thick:.3g} wraps per inch", "as seen"),
        Figure("core", f"{10.0 * core:.3g} mm, {core / thick:.2g} of the thickness", "touches other yarn"),
        Figure("gauge", str(yarn.gauge), "of stockinette"),
        Figure(
            "plain stitch", f"{10.0 * loop:.4g} mm of yarn, {loop / core:.3g} core diameters",
            f"tightness factor {math.sqrt(tex) / (10.0 * loop):.3g} (sqrt(tex) / mm)",
        ),
    ]  # fmt: skip
    look, plies = yarn.look, "ply" if yarn.look.plies == 1 else "plies"
    turn = f"{look.plies} {plies} in {look.twist} twist, a turn in {10.0 * look.lay * thick:.3g} mm"
    smooth = look.plies == 1 and not look.fibres
    seen = "one smooth filament" if smooth else f"in pictures; plies lean by {look.lean:.3g} degrees outside"
    found.append(Figure("look", look.name if smooth else f"{look.name}, {turn}", seen))
    if mechanics is not None:
        found += _mechanics(mechanics, yarn, tex, thick)
    found += [
        Figure("k_len, k_length", f"{material.k_len:.4g}, {material.k_length:.4g} erg",
               f"for a segment of {material.segment_length:.3g} cm: EA = 2 (k_len + k_length) / segment"),
        Figure("k_bend", f"{material.k_bend:.4g} erg cm", "EI / 2"),
        Figure("k_contact", f"{material.k_contact:.4g} erg/cm2",
               f"a transverse modulus of {material.transverse_modulus(yarn.core_radius) / 1e4:.3g} kPa"
               + ("" if mechanics is not None and mechanics.transverse_modulus else ", assumed: none is given")),
    ]  # fmt: skip
    return found


def _mechanics(mechanics: YarnMechanics, yarn: Yarn, tex: float, thick: float) -> list[Figure]:
    along, bend = mechanics.axial_stiffness, mechanics.flexural_rigidity
    area = math.pi * thick**2 / 4.0
    solid = along * thick**2 / 16.0
    found = [
        Figure(
            "axial stiffness", f"{along / 1e5:.4g} N, {along / 1e3 / tex:.3g} cN/tex, {along / area / 1e7:.3g} MPa",
            "tension over strain (EA)",
        ),
        Figure(
            "bending rigidity", f"{bend / 1e3:.3g} cN cm2, {bend * 1e-9:.3g} N m2, {bend:.3g} dyn cm2",
            f"bending moment over curvature (EI), {bend / solid:.2g} of a solid rod's",
        ),
    ]  # fmt: skip
    if mechanics.least_rigidity is not None:
        least = mechanics.least_rigidity
        found.append(
            Figure("free fibres", f"{least / 1e3:.3g} cN cm2", "the least bending rigidity that this yarn can have",
                   good=bend > 0.99 * least)
        )  # fmt: skip
    if mechanics.twist is not None:
        angle = math.degrees(math.atan(math.pi * thick * mechanics.twist))
        turns = f"{100.0 * mechanics.twist:.4g} turns/m"
        found.append(Figure("twist", turns, f"the outer fibres lie at {angle:.3g} degrees"))
    if mechanics.residual_twist is not None:
        found += _torque(mechanics)
    if mechanics.friction is not None:
        found.append(Figure("friction", f"{mechanics.friction:.3g}", "of the yarn on itself; ask for it (--friction)"))
    if mechanics.source:
        found.append(Figure("source", mechanics.source, "where the values come from"))
    return found


def _torque(mechanics: YarnMechanics) -> list[Figure]:
    """Return the figures of a yarn that hangs under a torque."""
    assert mechanics.residual_twist is not None
    rigidity = mechanics.torsional_rigidity or TWIST_OVER_BEND * mechanics.flexural_rigidity
    torque = 2.0 * math.pi * rigidity * mechanics.residual_twist
    given = "measured" if mechanics.torsional_rigidity else "two thirds of the bending rigidity"
    turns = f"{100.0 * abs(mechanics.residual_twist):.4g} turns/m {'Z' if mechanics.residual_twist > 0.0 else 'S'}"
    return [
        Figure("residual twist", turns, "lost if the yarn hung free; ask for it (--residual-twist)"),
        Figure("torque", f"{torque * 1e2:.3g} nN m, {torque:.3g} dyn cm",
               f"with a torsional rigidity (GJ) of {rigidity:.3g} dyn cm2, {given}"),
    ]  # fmt: skip
