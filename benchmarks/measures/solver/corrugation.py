# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How much a yarn is held by the hollows between the contact samples of another one.

Two straight yarns cross at an angle, pressed together by ``OVERLAP`` of their thickness, with segments as long as those
of a plain loop at ``draft``. One of them slides along itself by two spacings of samples. Between few samples its energy
goes up and down. The largest force along the slide over the force that presses the yarns together is the friction that
the sampling imitates; the coefficient of friction of yarn is 0.1 to 0.5. The last column is how far the energy goes up
and down, over the energy of bending for each of the four contacts of a stitch of stockinette at rest.
"""

from __future__ import annotations

import itertools

import numpy as np

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_RADIUS
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.evaluate import yarn_energies

OVERLAP = 0.1
"""Overlap of the yarns over their thickness; yarns of relaxed knits overlap by a tenth."""
PLACES = 48
"""Places of the slide."""
CONTACTS = 4
"""Contacts of a stitch of stockinette."""


def corrugation() -> Rows:
    """Yield the table."""
    bent = bending_of_a_contact()
    yield "angle", "samples a segment", "imitated friction", "energy up and down, over bending"
    for angle, samples in itertools.product((90.0, 45.0, 15.0), (2, 3, 5, 9, 12, 18)):
        friction, change = held(angle, samples)
        yield f"{angle:g}", samples, f"{friction:.2g}", f"{change / bent:.2g}"


def bending_of_a_contact() -> float:
    """Energy of bending for each contact of stockinette at rest [erg]."""
    report = sm.swatch("stockinette", quality="draft", device="cpu", relax_cell=True, progress=False).report
    return float(report["energies"]["bend"]) / (CONTACTS * report["stitches"])


def held(angle: float, samples: int) -> tuple[float, float]:
    """Largest force along the slide over the mean force across it, and the change of the energy [erg]."""
    segment = segment_length()
    slides = 2.0 * segment / samples * np.arange(PLACES) / PLACES
    energy = np.array([energy_at(angle, samples, slide, 0.0) for slide in slides])
    near = 1e-3 * YARN_RADIUS
    pressed = (energy_at(angle, samples, 0.0, -near) - energy_at(angle, samples, 0.0, near)) / (2.0 * near)
    along = np.gradient(energy, slides)
    return float(np.abs(along).max() / pressed), float(np.ptp(energy))


def segment_length() -> float:
    """Length of a segment of a plain loop at ``draft`` [cm]."""
    quality = PRESETS["draft"]
    points = round(quality.control_points_per_stitch * quality.refinement)
    return 2.0 * COMPACT_LOOP * YARN_RADIUS / points


def energy_at(angle: float, samples: int, slide: float, lift: float) -> float:
    """Energy of contact of two yarns, of which one has slid along itself and was lifted [cm]."""
    turn, places = np.radians(angle), segment_length() * np.arange(-12.0, 13.0)
    one = places[:, None] * np.array([1.0, 0.0, 0.0])
    direction = np.array([np.cos(turn), np.sin(turn), 0.0])
    height = (1.0 - OVERLAP) * 2.0 * YARN_RADIUS + lift
    other = (places + slide)[:, None] * direction + np.array([0.0, 0.0, height])
    yarns = YarnSet.from_curves([one, other], closed=[False, False], radius=YARN_RADIUS)
    material = YarnMaterial.named().of_radius(YARN_RADIUS)
    return yarn_energies(yarns, material, contact_samples=samples, device="cpu")["contact"]
