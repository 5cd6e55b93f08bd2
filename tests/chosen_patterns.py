# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Eight patterns that stand for the library: each has something that the other ones lack.

Three facts are tested for every pattern: it repeats and equals the pattern that is read from its text
(``patterns/test_library.py``), its yarns are linked as its stitches require (``patterns/test_pattern_mesh.py``), and on
its lattice they start apart from all their images (``periodic/repeat/test_torus.py``). Other facts take these eight.
"""

CHOSEN_PATTERNS = (
    "stockinette",        # one stitch wide: each stitch is beside images of itself
    "twisted-rib",        # knit and purl in one row, and twisted loops
    "rope-cable",         # loops that cross
    "half-cardigan",      # tucks: a loop and a yarn-over that are worked together
    "lice",               # two yarns in one row, with floats
    "jacquard3",          # loops slipped in front and behind, over several rows
    "feather-and-fan",    # yarn-overs and decreases that lie apart, so that wales wander
    "openwork-trellis",   # rows of unequal numbers of stitches: increases and decreases of both directions
)  # fmt: skip
