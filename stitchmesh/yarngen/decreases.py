# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Decreases: one loop pulled through several (Yuksel et al. 2012, section 4.2).

The heads below lean to the middle and lie in layers, one wholly in front of the other, so that they are not linked
with each other. The new loop's feet pass behind all their legs, its legs in front of all their tops.

The waypoints were drawn by hand and then moved in small steps, none of which lets yarn pass through yarn, until the
smallest distance in a knitted surrounding was above one radius (tests/yarngen).
"""

from __future__ import annotations

from stitchmesh.yarngen.template import Template, bottom, drawn, left_wale, mirrored, right_wale, top


def decrease_left() -> Template:
    """d12 k: two loops together, the left one in front."""
    n = (2, 1)
    front = drawn(
        *n, bottom(0, 0), bottom(0, 1),
        [(0.19, 0.16, 1.15), (0.38, 0.52, 0.73), (0.62, 0.78, 0.38), (1.02, 0.8, -0.11), (1.34, 0.68, 0.51),
         (1.44, 0.52, 1.18), (1.02, 0.16, 2.44)], is_head=True,
    )  # fmt: skip
    back = drawn(
        *n, bottom(1, 0), bottom(1, 1),
        [(0.86, 0.29, 0.27), (0.64, 0.52, -0.5), (0.73, 0.8, -1.95), (0.97, 0.92, -1.65), (1.39, 0.78, -1.31),
         (1.69, 0.52, -0.13), (1.75, 0.23, 1.24)], is_head=True,
    )  # fmt: skip
    left = drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.14, 0.18, -1.2), (0.61, 0.31, -1.38), (0.88, 0.39, -1.6), (0.94, 0.6, 0.24), (0.87, 0.91, 2.59)],
    )  # fmt: skip
    right = drawn(
        *n, top(*n, 0, 1), right_wale(2),
        [(1.19, 0.77, 2.99), (1.15, 0.54, 0.85), (1.26, 0.41, -1.5), (1.49, 0.23, -0.94), (1.78, 0.13, -1.16)],
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
        [(0.36, 0.32, 1.1), (0.49, 0.47, 0.5), (0.94, 0.79, -0.82), (1.59, 0.9, -1.07), (1.91, 0.78, -0.58),
         (1.96, 0.62, -0.25), (1.7, 0.4, 0.19), (1.18, 0.21, 0.15)], is_head=True,
    )  # fmt: skip
    right_head = drawn(
        *n, bottom(2, 0), bottom(2, 1),
        [(1.88, 0.17, -1.21), (1.28, 0.22, -2.23), (1.05, 0.54, -1.76), (1.1, 0.8, -2.52), (1.5, 0.92, -2.8),
         (2.02, 0.74, -1.83), (2.43, 0.41, -0.34), (2.63, 0.2, 0.94)], is_head=True,
    )  # fmt: skip
    centre_head = drawn(
        *n, bottom(1, 0), bottom(1, 1),
        [(1.13, 0.12, 2.21), (1.07, 0.5, 1.89), (1.14, 0.73, 1.27), (1.56, 0.82, 0.36), (1.85, 0.77, 0.94),
         (1.97, 0.56, 1.6), (1.83, 0.25, 2.27)], is_head=True,
    )  # fmt: skip
    left_foot = drawn(
        *n, left_wale(*n), top(*n, 0, 0),
        [(0.25, 0.18, -1.72), (0.72, 0.24, -2.57), (1.09, 0.4, -3.31), (1.38, 0.52, -1.54), (1.39, 0.78, 3.56)],
    )  # fmt: skip
    right_foot = drawn(
        *n, top(*n, 0, 1), right_wale(3),
        [(1.69, 0.81, 3.11), (1.62, 0.54, -1.14), (1.9, 0.48, -2.58), (2.23, 0.32, -1.34), (2.73, 0.17, -1.09)],
    )  # fmt: skip
    return Template(*n, (left_head, right_head, centre_head, left_foot, right_foot))
