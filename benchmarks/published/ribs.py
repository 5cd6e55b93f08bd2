# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""V10: width of ribs, and how far jersey and rib extend.

Spencer (p. 68): a 1x1 rib comes off the needles about 30 % narrower. The texts do not say from which width. On a
machine with two beds, the wales of both sides share the width of the needles: then each has half the distance of the
needles of one bed. Hand knitters have all stitches on one needle. Jamshaid and Mishra 2024: jersey extends by 60 to 80
% along the courses, rib by up to 200 %, about twice as far under the same force. J. Text. Mach. Soc. Japan 36(3), 1990:
for cotton 1x1 rib in the dry state, U_w = l / wale spacing rises and U_c falls with the loop length.
"""

from __future__ import annotations

import numpy as np

from benchmarks.published.comparison import Claim, Figure, Items, Section
from benchmarks.published.friction import let_go
from benchmarks.published.knits import gauge
from benchmarks.published.samples import strain_under, stretched, tension_at, yarn_with
from stitchmesh.periodic.relaxation.off_needles import NEEDLES_K_W
from stitchmesh.periodic.swatch_options import COMPACT_LOOP

LOOPS = (15, 16, COMPACT_LOOP)
"""Loop lengths [yarn diameters]."""
NARROWER = (0.25, 0.35)
EXTENSIONS = (0.4, 0.7)
"""Strains of jersey along the courses under whose tension rib is measured; 60 to 80 % is published."""


def run() -> Items:
    """Compare widths in the dry state, extensions under one load, and trends with the loop length."""
    plain = {loop: gauge(let_go("stockinette", loop, "dry")) for loop in LOOPS}
    rib = {loop: gauge(let_go("rib1x1", loop, "dry")) for loop in LOOPS}
    on_one = float(np.mean([1.0 - NEEDLES_K_W / rib[loop].k_w for loop in LOOPS]))
    on_two = float(np.mean([1.0 - 2.0 * NEEDLES_K_W / rib[loop].k_w for loop in LOOPS]))
    beside = float(np.mean([1.0 - plain[loop].k_w / rib[loop].k_w for loop in LOOPS]))
    for what, ours, counts in (
        ("than on the needles of one bed", on_one, True), ("than on the needles of two beds", on_two, False),
        ("than stockinette, both dry", beside, False),
    ):  # fmt: skip
        yield Figure(
            quantity=f"1x1 rib, dry: narrower {what}", published=NARROWER, ours=ours, sure="code", counts=counts
        )
    yarn = yarn_with("cotton-28-tex")
    loop = 2.0 * COMPACT_LOOP * yarn.core_radius
    jersey = stretched("stockinette", yarn, "course", 0.8, loop=loop, friction=0.3)
    ribbed = stretched("rib1x1", yarn, "course", 3.0, loop=loop, friction=0.3)
    for extension in EXTENSIONS:
        load = tension_at(jersey, extension)
        yield Figure(
            quantity=f"rib over jersey under the {load:.0f} N/m that extend jersey by {100 * extension:g} % along the "
            "courses, cotton, friction 0.3", published=(1.5, 2.5), ours=strain_under(ribbed, load) / extension,
            sure="2nd",
        )  # fmt: skip
    for name, sign, published in (("k_w", 1.0, "rises"), ("k_c", -1.0, "falls")):
        values = [getattr(rib[loop], name) for loop in LOOPS]
        yield Claim(
            quantity=f"U_{name[-1]} of dry rib from {LOOPS[0]:g} to {LOOPS[-1]:g} d", published=published, sure="page",
            ours=", ".join(f"{value:.2f}" for value in values), passes=bool(np.all(sign * np.diff(values) > 0.0)),
        )  # fmt: skip
    yield Figure(
        quantity="U_s of dry rib, largest over smallest", published=(1.0, 1.05), sure="page", counts=False,
        ours=max(each.k_s for each in rib.values()) / min(each.k_s for each in rib.values()),
    )  # fmt: skip


TABLE = Section(
    name="V10", title="Width and extension of ribs", run=run, accepted="25 to 35 % narrower, twice jersey (proposal)",
    verdict="ribs close too far; the width that the text means is not sure; U_c and U_w hardly move",
)  # fmt: skip
