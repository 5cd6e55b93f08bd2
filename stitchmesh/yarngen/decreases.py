# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Decreases: one loop pulled through several (Yuksel et al. 2012, section 4.2).

The heads below lean to the middle and lie in layers, one wholly in front of the other, so that they are not linked
with each other. The new loop's feet pass behind all their legs, its legs in front of all their tops.
"""

from __future__ import annotations

from stitchmesh.yarngen.template import Template, bottom, drawn, left_wale, mirrored, right_wale, top


def decrease_left() -> Template:
    """d12 k: two loops together, the left one in front."""
    n = (2, 1)
    front = drawn(
        *n, bottom(0, 0), bottom(0, 1),
        [(0.26, 0.22, 1.0), (0.34, 0.50, 0.7), (0.62, 0.77, 0.3), (1.0, 0.89, 0.5), (1.30, 0.76, 1.0),
         (1.36, 0.52, 1.5), (1.10, 0.24, 1.9)], is_head=True,
    )  # fmt: skip
    back = drawn(
        *n, bottom(1, 0), bottom(1, 1),
        [(0.90, 0.24, -0.1), (0.64, 0.52, -0.5), (0.70, 0.76, -1.1), (1.0, 0.89, -1.6), (1.38, 0.77, -1.0),
         (1.66, 0.50, 0.0), (1.74, 0.22, 0.8)], is_head=True,
    )  # fmt: skip
    left = drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.22, 0.16, -1.0), (0.55, 0.27, -1.7), (0.80, 0.38, -1.9), (0.88, 0.56, 0.2), (0.83, 0.82, 2.3)],
    )  # fmt: skip
    right = drawn(
        *n, top(*n, 0, 1), right_wale(2),
        [(1.17, 0.82, 2.3), (1.12, 0.56, 0.2), (1.20, 0.38, -1.4), (1.45, 0.27, -1.4), (1.78, 0.16, -1.0)],
    )  # fmt: skip
    return Template(*n, (front, back, left, right))


def decrease_right() -> Template:
    """d21 k: two loops together, the right one in front."""
    return mirrored(decrease_left())


def decrease_centre() -> Template:
    """d213 k: three loops together, the centre one in front, the left one behind it, the right one last."""
    n = (3, 1)
    left_head = drawn(
        *n, bottom(0, 0), bottom(0, 1),
        [(0.30, 0.25, 0.9), (0.50, 0.52, 0.3), (0.95, 0.78, -0.5), (1.5, 0.92, -1.0), (1.85, 0.80, -0.3),
         (1.95, 0.60, 0.1), (1.75, 0.38, 0.1), (1.20, 0.18, 0.1)], is_head=True,
    )  # fmt: skip
    right_head = drawn(
        *n, bottom(2, 0), bottom(2, 1),
        [(1.80, 0.18, -1.7), (1.25, 0.38, -1.7), (1.05, 0.60, -1.7), (1.15, 0.80, -2.2), (1.5, 0.92, -2.8),
         (2.05, 0.78, -1.6), (2.50, 0.52, -0.2), (2.70, 0.25, 0.8)], is_head=True,
    )  # fmt: skip
    centre_head = drawn(
        *n, bottom(1, 0), bottom(1, 1),
        [(1.17, 0.22, 1.9), (1.08, 0.50, 1.8), (1.20, 0.76, 1.0), (1.5, 0.86, 0.8), (1.80, 0.76, 1.0),
         (1.92, 0.50, 1.8), (1.83, 0.22, 1.9)], is_head=True,
    )  # fmt: skip
    left_foot = drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.30, 0.17, -1.0), (0.75, 0.27, -2.4), (1.10, 0.40, -3.4), (1.36, 0.52, -1.0), (1.37, 0.80, 2.6)],
    )  # fmt: skip
    right_foot = drawn(
        *n, top(*n, 0, 1), right_wale(3),
        [(1.63, 0.80, 2.6), (1.64, 0.52, -1.0), (1.90, 0.40, -2.4), (2.25, 0.27, -1.9), (2.70, 0.17, -1.0)],
    )  # fmt: skip
    return Template(*n, (left_head, right_head, centre_head, left_foot, right_foot))
