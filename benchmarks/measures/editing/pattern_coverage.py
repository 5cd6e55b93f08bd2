# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How much of a shaped garment each lace and cable pattern of the library covers, and how many cables it crosses.

A stitch of a cable that does not cross counts as left out.
"""

from __future__ import annotations

from benchmarks.scenes.garments import Garment
from benchmarks.table import Rows
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.patterns import LaidPattern, Pattern, lay_pattern, parse_pattern, pattern_names, read_pattern
from stitchmesh.patterns.placement.columns import is_elastic

GARMENTS = ("hat", "sweater", "dress", "sock")
LACE = """pattern "Lace 8 x 6"
rounds 1, 3, 5: k8
round 2: k1 yo ssk k1 k2tog yo k2
round 4: k2 yo sk2p yo k3
round 6: k8"""


def pattern_coverage() -> Rows:
    """Yield the table."""
    fabrics = {name: Garment(name, width=0.8).divided() for name in GARMENTS}
    yield "pattern", "repeat", *GARMENTS
    patterns = [read_pattern(name) for name in pattern_names()]
    for pattern in [parse_pattern(LACE), *(pattern for pattern in patterns if not is_elastic(pattern))]:
        cells = [covered(lay_pattern(fabric, pattern), pattern) for fabric in fabrics.values()]
        yield pattern.name, f"{pattern.width} x {pattern.height}", *cells


def covered(laid: LaidPattern, pattern: Pattern) -> str:
    """Return the share of the stitches that are in the pattern, and the number of its crossings."""
    left_out = sum(len(part.faces) for part in laid.left_out)
    share = f"{laid.faces_laid / (laid.faces_laid + left_out):.0%}"
    crosses = any(loop.shift for row in pattern.rows for loop in row.loops)
    return f"{share}, {len(cable_groups(laid.fabric))} cables" if crosses else share
