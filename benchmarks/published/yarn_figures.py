# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""V8: yarns of the library beside published figures, and hand-knitting yarns at their gauge.

Sources: Xiong et al. 2026 (Materials 19:560) for ring-spun cotton; Spencer for d = 0.037 sqrt(tex) mm; Peirce for the
packing of spun yarn; the Craft Yarn Council for the gauge of hand-knitting yarns, with Munden's 1.3 rows to a stitch.
"""

from __future__ import annotations

import math

from benchmarks.published.comparison import Figure, Items, Section
from stitchmesh.periodic.swatch import swatch
from stitchmesh.yarn.yarn_presets import Yarn, yarn_names
from stitchmesh.yarnrelax import YarnMaterial

COTTON = {14.8: (0.112, 1120.0), 18.5: (0.146, 1065.0), 28.1: (0.169, 815.0), 36.9: (0.208, 605.0)}
"""Diameter [mm] and tensile modulus [MPa] of ring-spun cotton by linear density [tex]."""
WITHIN = 0.05


def run() -> Items:
    """Compare cotton, and the gauge of each hand-knitting yarn in the wet state, as knitters wash a swatch."""
    cotton = Yarn.named("cotton-28-tex")
    diameter = 20.0 * cotton.core_radius
    assert cotton.mechanics is not None
    modulus = cotton.mechanics.axial_stiffness / (math.pi * cotton.core_radius**2) * 1e-7
    known, stiff = COTTON[28.1]
    yield Figure(quantity="diameter of cotton of 28 tex", published=(known, known), ours=diameter, sure="2nd",
                 within=WITHIN, unit="mm", counts=False)  # fmt: skip
    yield Figure(quantity="tensile modulus of cotton of 28 tex", published=(stiff, stiff), ours=modulus, sure="2nd",
                 within=WITHIN, unit="MPa", counts=False)  # fmt: skip
    spencer = 0.037 * math.sqrt(28.1)
    yield Figure(quantity="diameter of cotton of 28 tex, 0.037 sqrt(tex)", published=(spencer, spencer), ours=diameter,
                 sure="page", within=0.2, unit="mm", counts=False)  # fmt: skip
    for name in yarn_names():
        yarn = Yarn.named(name)
        for relaxation in ("wet", "dry", "frictionless") if name == "dk" else ("wet",):
            found = swatch(
                "stockinette", material=YarnMaterial.of_yarn(yarn), quality="standard", device="cpu", progress=False,
                relax_cell=True, relaxation=relaxation, yarn_radius=yarn.core_radius, loop_length=yarn.loop_length,
            ).report  # fmt: skip
            gauge = {"stitches": 10.0 / found["wale_spacing"], "rows": 10.0 / found["course_spacing"]}
            for what, ours in gauge.items():
                value = getattr(yarn.gauge, what)
                state = "without friction" if relaxation == "frictionless" else relaxation
                yield Figure(quantity=f"{name}, {what} in 10 cm, {state}", published=(value, value), ours=ours,
                             sure="code" if what == "stitches" else "derived", within=WITHIN,
                             counts=relaxation == "wet")  # fmt: skip


TABLE = Section(
    name="V8", title="Yarns, and hand-knitting yarns at their gauge", run=run,
    accepted="5 % in stitches and rows (to reach)",
    verdict="",
)  # fmt: skip
