# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Increases: several loops made of one (Yuksel et al. 2012, section 4.2).

A knitted loop comes up in front of the head below, a yarn-over behind it; between them the yarn hooks around that
head. The head is drawn wider than the plain one, to hold all the yarn that passes through it.

The waypoints were drawn by hand and then moved in small steps, none of which lets yarn pass through yarn, until the
smallest distance in a knitted surrounding was above one radius (tests/yarngen).
"""

from __future__ import annotations

from stitchmesh.yarngen.template import Template, bottom, drawn, left_wale, mirrored, right_wale, top


def knit_yarnover() -> Template:
    """ky: knit and yarn over in one loop; the yarn-over lies to the right."""
    n = (1, 2)
    head = drawn(
        *n, bottom(0, 0), bottom(0, 1),
        [(0.54, 0.33, 1.04), (0.49, 0.56, 0.34), (0.71, 0.84, -0.38), (0.99, 0.83, -0.18), (1.33, 0.73, 0.5),
         (1.47, 0.53, 0.3), (1.46, 0.33, 0.41)], is_head=True,
    )  # fmt: skip
    knit_left = drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.54, 0.14, -0.82), (0.74, 0.28, -1.02), (0.73, 0.48, 0.38), (0.48, 0.76, 1.51)],
    )  # fmt: skip
    hook = drawn(
        *n, top(*n, 0, 1), top(*n, 1, 0),
        [(0.8, 0.95, 0.87), (0.94, 0.41, 1.09), (1.2, 0.24, 0.38), (1.23, 0.59, -1.83), (1.31, 0.8, -1.02)],
    )  # fmt: skip
    yarnover_right = drawn(
        *n, top(*n, 1, 1), right_wale(1), [(1.64, 0.74, -0.68), (1.63, 0.4, -0.86), (1.59, 0.2, -0.48)]
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
        [(1.01, 0.19, 0.86), (0.79, 0.53, 0.1), (1.03, 0.76, -0.46), (1.6, 0.79, 0.26), (1.98, 0.78, -0.3),
         (2.18, 0.5, 0.2), (2.04, 0.24, 0.54)], is_head=True,
    )  # fmt: skip
    knit_left = drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.98, 0.13, -0.96), (1.15, 0.27, -0.95), (1.07, 0.45, 0.41), (0.72, 0.66, 1.38), (0.26, 0.87, 0.24)],
    )  # fmt: skip
    hook = drawn(
        *n, top(*n, 0, 1), top(*n, 1, 0),
        [(1.04, 0.77, 1.14), (1.25, 0.59, 1.29), (1.36, 0.41, 0.26), (1.41, 0.58, -1.23), (1.26, 0.78, -1.7)],
    )  # fmt: skip
    left = Template(*n, (knit_left, hook))
    return Template(*n, (head, *left.parts, *mirrored(left).parts))
