# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""V3: four patterns of one yarn, and rib beside stockinette along the courses.

Singal et al. 2024 (Nat. Commun. 15:2622): rib extends by 180 % along the courses under the stress that extends
stockinette by 21 %. The published orders of stiffness are stockinette > garter > seed > rib along the courses, and
stockinette > rib > garter > seed along the wales. Our orders are those of the tension at a strain. The yarn is theirs,
with its published bending energy, in their loops of 17.4 core diameters, and in tighter loops.
"""

from __future__ import annotations

from benchmarks.published.comparison import Claim, Curve, Figure, Items, Section
from benchmarks.published.samples import (
    PATTERNS,
    newtons,
    rest_text,
    strain_under,
    strains,
    stretched,
    tension_at,
    yarn_with,
)
from benchmarks.published.stretch import PUBLISHED
from stitchmesh.periodic.stretch import StretchCurve

PLAIN, RIB = 0.21, 1.8
"""Strains of stockinette and of rib under one stress."""
LOOPS = (14.0, 15.0, 17.35)
"""Loop lengths [core diameters]; the last one is theirs."""
FRICTIONS = (None, 0.3)
AT = 0.4
"""Strain at which stiffnesses are ordered."""


def run() -> Items:
    """Compare the ratio of the extensions, and the orders."""
    yarn = yarn_with("acrylic-worsted")
    table: list[list[object]] = []
    drawn: list[StretchCurve] = []
    for loop in LOOPS:
        for friction in FRICTIONS:
            length = loop * 2.0 * yarn.core_radius
            plain = stretched("stockinette", yarn, "course", 0.4, loop=length, friction=friction)
            rib = stretched("rib1x1", yarn, "course", 2.6, loop=length, step=0.2, friction=friction)
            drawn += [plain, rib]
            load = tension_at(plain, PLAIN)
            found = strain_under(rib, load)
            rubbing = "no friction" if friction is None else f"friction {friction:g}"
            if friction is not None:
                yield Figure(
                    quantity=f"extension of rib over that of stockinette, loops of {loop:g} d, {rubbing}",
                    published=(6.0, 11.0), ours=found / PLAIN, sure="2nd",
                )  # fmt: skip
            table.append([loop, rubbing, f"{load:.2f}", f"{100 * found:.0f} %", f"{found / PLAIN:.1f}"])
            if friction is not None and loop == LOOPS[0]:
                yield from (_curve("stockinette", plain), _curve("rib", rib))
    for direction, published in PUBLISHED.items():
        for loop in LOOPS:
            length = loop * 2.0 * yarn.core_radius
            made = {name: stretched(name, yarn, direction, 0.4, loop=length, friction=0.3) for name in PATTERNS}
            drawn += made.values()
            order = sorted(made, key=lambda name: -tension_at(made[name], AT))
            ours = " > ".join(name.removesuffix("1x1") for name in order)
            yield Claim(
                quantity=f"order along the {direction}s at {100 * AT:g} %, loops of {loop:g} d, friction 0.3",
                published=published, ours=ours, passes=ours == published, sure="2nd",
            )  # fmt: skip
    yield ""
    yield ["loop length / d", "friction", "stockinette at 21 % [N/m]", "rib under it", "ratio (published 8.6)"]
    yield from table
    yield from ("", rest_text(drawn))


def _curve(label: str, curve: StretchCurve) -> Curve:
    return Curve(panel="along the courses", label=label, x=tuple(100 * strains(curve)), y=tuple(newtons(curve)))


TABLE = Section(
    name="V3", title="Rib beside stockinette, and four patterns", run=run, accepted="ratio 6 to 11 (proposal)",
    verdict="loops of 14 and 15 d have the ratio, and their own loops (17.4 core diameters) half of it; no published "
    "order",
    picture="validation-v3.png", axes=("strain [%]", "tension [N/m]"),
)  # fmt: skip
