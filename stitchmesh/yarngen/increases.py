# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Increases: several loops made of one (Yuksel et al. 2012, section 4.2).

A knitted loop comes up in front of the head below, a yarn-over behind it; between them the yarn hooks around that
head. The head is drawn wider than the plain one, to hold all the yarn that passes through it.
"""

from __future__ import annotations

from stitchmesh.yarngen.template import Part, Template, bottom, drawn, left_wale, mirrored, right_wale, top

OVER, UNDER = 1.3, -1.3
"""Heights in front of and behind a head that lies near zero; their separation from it is what plain loops have."""


def knit_yarnover() -> Template:
    """ky: knit and yarn over in one loop; the yarn-over lies to the right."""
    n = (1, 2)
    head = drawn(
        *n, bottom(0, 0), bottom(0, 1),
        [(0.60, 0.25, 0.6), (0.52, 0.52, 0.2), (0.68, 0.80, -0.3), (1.0, 0.90, -0.1), (1.32, 0.80, 0.3),
         (1.46, 0.52, 0.6), (1.40, 0.25, 0.6)], is_head=True,
    )  # fmt: skip
    knit_left = drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.56, 0.14, -1.0), (0.75, 0.28, -0.9), (0.74, 0.50, 0.5), (0.50, 0.78, 1.4)],
    )  # fmt: skip
    hook = drawn(
        *n, top(*n, 0, 1), top(*n, 1, 0),
        [(0.86, 0.80, 1.5), (0.95, 0.50, 1.0), (1.03, 0.38, 0.0), (1.12, 0.50, -1.0), (1.18, 0.80, -1.5)],
    )  # fmt: skip
    yarnover_right = drawn(
        *n, top(*n, 1, 1), right_wale(1), [(1.72, 0.72, -0.6), (1.66, 0.40, -0.9), (1.58, 0.17, -0.7)]
    )
    return Template(*n, (head, knit_left, hook, yarnover_right))


def yarnover_knit() -> Template:
    """yk: yarn over and knit in one loop; the yarn-over lies to the left."""
    return mirrored(knit_yarnover())


def knit_yarnover_knit() -> Template:
    """kyk: knit, yarn over, knit in one loop."""
    n = (1, 3)
    head = drawn(
        *n, bottom(0, 0), bottom(0, 1),
        [(1.00, 0.22, 0.6), (0.82, 0.50, 0.2), (1.02, 0.78, -0.3), (1.5, 0.88, 0.0), (1.98, 0.78, -0.3),
         (2.18, 0.50, 0.2), (2.00, 0.22, 0.6)], is_head=True,
    )  # fmt: skip
    left = _knit_left_of_three(n)
    hook = drawn(
        *n, top(*n, 0, 1), top(*n, 1, 0),
        [(1.06, 0.80, 1.4), (1.27, 0.52, 1.0), (1.36, 0.40, 0.0), (1.42, 0.52, -1.0), (1.34, 0.82, -1.4)],
    )  # fmt: skip
    whole = Template(*n, (left, hook))
    right = mirrored(whole).parts
    return Template(*n, (head, left, hook, *right))


def _knit_left_of_three(n: tuple[int, int]) -> Part:
    return drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.98, 0.13, -1.0), (1.15, 0.26, -0.9), (1.05, 0.46, 0.5), (0.72, 0.66, 1.4), (0.38, 0.86, 0.9)],
    )  # fmt: skip
