# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Panels that tests of the cloth and of the layout share."""

from __future__ import annotations

import numpy as np

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam, cloth_from_panels

ANGLES = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
OUTLINES = {
    "square": [[0, 0], [10, 0], [10, 10], [0, 10]],
    "corner": [[0, 0], [20, 0], [20, 5], [5, 5], [5, 20], [0, 20]],
    "shirt": [[0, 0], [50, 0], [50, 40], [44, 52], [45, 62], [34, 66], [30, 60], [20, 60], [16, 66], [5, 62], [6, 52],
              [0, 40]],
    "disc": np.stack([10 * np.cos(ANGLES), 10 * np.sin(ANGLES)], axis=1),
    "strip": [[0, 0], [30, 0], [30, 0.3], [0, 0.3]],
    "needle": [[0, 0], [10, 0], [10, 10], [5.1, 1], [5, 9.8], [4.9, 1], [0, 10]],
}  # fmt: skip
"""Outlines of panels by name [cm]: convex and not, round, and narrower than their triangles' edges are long."""


def edge_stretch(cloth: Cloth, vertices: np.ndarray) -> np.ndarray:
    """Length of the sides of all triangles over their length at rest, shape (T, 3)."""
    corners = vertices[cloth.triangles]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    return length / np.linalg.norm(np.roll(cloth.rest, -1, axis=1) - cloth.rest, axis=2)


def rectangle(width: float, height: float, name: str = "panel", **fields: object) -> Panel:
    """A rectangle with its corner 0 at (0, 0)."""
    return Panel(name=name, outline=[[0, 0], [width, 0], [width, height], [0, height]], **fields)  # type: ignore[arg-type]


def side_by_side(left: float, right: float, height: float = 8.0, edge_length: float = 1.0) -> Cloth:
    """Two rectangles of their own heights, the right side of one sewn to the left side of the other."""
    panels = [
        rectangle(10.0, left, "left"),
        rectangle(10.0, right, "right", position=PanelPosition(origin=(10.0, 0.0, 0.0))),
    ]
    left, right = PanelBorder(panel="left", start=1, end=2), PanelBorder(panel="right", start=3, end=0)
    seam = PanelSeam(first=left, second=right, angle=20.0)
    return cloth_from_panels(panels, [seam], edge_length=edge_length)


def tube(around: float, height: float, edge_length: float = 1.0) -> Cloth:
    """A rectangle whose right side is sewn to its left side, wrapped round a cylinder."""
    panel = rectangle(around, height, position=PanelPosition(radius=around / (2 * np.pi)))
    right, left = PanelBorder(panel="panel", start=1, end=2), PanelBorder(panel="panel", start=3, end=0)
    seam = PanelSeam(first=right, second=left)
    return cloth_from_panels([panel], [seam], edge_length=edge_length)
