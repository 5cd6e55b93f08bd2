# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""V1: plain knit at the tightness of worsted knits, and Munden's constants in his three states of relaxation.

Munden 1959, as Spencer (Knitting Technology, p. 280-282) cites him. Worsted plain knit has a tightness factor
sqrt(tex) / l of 1.4 to 1.5 (l in mm), and its yarn a diameter of k sqrt(tex) mm with k = 0.037 (cotton) to 0.040
(viscose). Its loops are therefore 1 / (k TF) = 16.7 to 19.3 diameters long.
"""

from __future__ import annotations

import numpy as np

from benchmarks.published.comparison import Claim, Figure, Items, Section
from benchmarks.published.friction import let_go
from benchmarks.published.knits import MUNDEN, gauge
from stitchmesh.periodic.swatch_options import COMPACT_LOOP

LOOPS = (COMPACT_LOOP, 18.0, 19.3)
"""Loop lengths of worsted plain knit [yarn diameters]."""
MEASURES = {"k_c": "K_c", "k_w": "K_w", "k_s": "K_s", "ratio": "R"}
WITHIN = 0.05


def run() -> Items:
    """Compare the means over the range of loop lengths."""
    found = {state: [gauge(let_go("stockinette", loop, state)) for loop in LOOPS] for state in MUNDEN}
    for state, published in MUNDEN.items():
        for name, sign in MEASURES.items():
            value = getattr(published, name)
            ours = float(np.mean([getattr(each, name) for each in found[state]]))
            yield Figure(
                quantity=f"{sign}, {state}", published=(value, value), ours=ours, sure="code", within=WITHIN,
                counts=name != "k_s",
            )  # fmt: skip
    density = [np.mean([each.k_s for each in found[state]]) for state in MUNDEN]
    yield Claim(
        quantity="K_s from dry to wet to full", published="rises", sure="code",
        ours=", ".join(f"{value:.1f}" for value in density), passes=bool(np.all(np.diff(density) > 0)),
    )  # fmt: skip
    yield from ("", ["loop length / d", *(f"K_c, K_w, R {state}" for state in MUNDEN)])
    for number, loop in enumerate(LOOPS):
        rows = [found[state][number] for state in MUNDEN]
        yield [loop, *(f"{each.k_c:.2f}, {each.k_w:.2f}, {each.ratio:.2f}" for each in rows)]


TABLE = Section(
    name="V1", title="Plain knit: Munden's constants", run=run, accepted="5 % for each constant (proposal)",
    verdict="K_w falls from dry to full and beyond 17 d, where it should rise; swelling and set are not modelled",
)  # fmt: skip
