# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sewing patterns as OBJ texts: a bag, a skirt of gores, a panel with a dart, T-shirts and dresses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.panels.read_panels import read_panels

BAG_WIDTH, BAG_HEIGHT, BAG_FOOT, BAG_ANGLE = 24.0, 30.0, 9.0, np.radians(50.0)
DART_PANEL_WIDTH, DART_PANEL_HEIGHT, DART_WIDTH, DART_DEPTH = 24.0, 20.0, 6.0, 12.0
GORES, WAIST, HEM, SKIRT_LENGTH = 4, 16.0, 28.0, 36.0
SHIRT_WIDTH, ARMPIT, SHOULDER, NECK_HEIGHT, NECK_WIDTH = 40.0, 27.0, 45.0, 48.0, 16.0
SLEEVE_LENGTH, FRONT_NECK, BACK_NECK = 18.0, 8.0, 2.0
BODY_DEPTH, DRESS_LENGTH = 8.0, 30.0
BODY_HEIGHTS = np.concatenate([np.linspace(0.0, ARMPIT, 10), np.linspace(ARMPIT, SHOULDER, 7)[1:]])
BODY_PLACES = np.concatenate(
    [np.linspace(0.0, 12.0, 5), np.linspace(12.0, 28.0, 9)[1:], np.linspace(28.0, SHIRT_WIDTH, 5)[1:]]
)


@dataclass
class PatternText:
    """An OBJ text that panels are added to; points at equal places become one vertex."""

    lines: list[str] = field(default_factory=list)
    vertices: dict[tuple[float, ...], int] = field(default_factory=dict)
    texture_vertices: dict[tuple[float, ...], int] = field(default_factory=dict)
    texture_count: int = 0

    def add_panel(self, texture: FloatArray, points: FloatArray, *, joined: bool = False) -> None:
        """Add a panel of quads; texture coordinates and positions at the nodes have shapes (m, n, 2) and (m, n, 3).

        If it is joined, it is a part of the panel before it: points at equal places in the texture are one.
        """
        rows, columns = texture.shape[:2]
        if not joined:
            self.texture_vertices.clear()
        of_node = [self._texture_vertex(point) for point in texture.reshape(-1, 2)]
        number = [self._vertex(point) for point in points.reshape(-1, 3)]
        for row in range(rows - 1):
            for column in range(columns - 1):
                first = row * columns + column
                corners = [first, first + 1, first + columns + 1, first + columns]
                self.lines.append("f " + " ".join(f"{number[c]}/{of_node[c]}" for c in corners))

    def _texture_vertex(self, point: FloatArray) -> int:
        key = tuple((np.round(point, 6) + 0.0).tolist())
        if key not in self.texture_vertices:
            self.texture_count += 1
            self.texture_vertices[key] = self.texture_count
            self.lines.append("vt " + " ".join(f"{value:.6f}" for value in key))
        return self.texture_vertices[key]

    def _vertex(self, point: FloatArray) -> int:
        key = tuple((np.round(point, 6) + 0.0).tolist())
        if key not in self.vertices:
            self.vertices[key] = len(self.vertices) + 1
            self.lines.append("v " + " ".join(f"{value:.6f}" for value in key))
        return self.vertices[key]

    def read(self, folder: Path) -> PanelMesh:
        """Write the text and read its panels."""
        path = folder / "pattern.obj"
        path.write_text("\n".join(self.lines) + "\n")
        return read_panels(path)


def nodes(u: FloatArray, v: FloatArray) -> FloatArray:
    """The points (u, v) of a grid, shape (rows, columns, 2)."""
    return np.stack(np.meshgrid(u, v), axis=2)


def placed(texture: FloatArray, place: Callable[[float, float], tuple[float, float, float]]) -> FloatArray:
    """Positions of the nodes of a grid, shape (rows, columns, 3)."""
    return np.array([[place(u, v) for u, v in row] for row in texture.tolist()])


def bag() -> PatternText:
    """A bag: a front and a back, sewn at both sides and below: a lens in cross section, flat at its foot."""
    text = PatternText()
    texture = nodes(np.linspace(0.0, BAG_WIDTH, 9), np.linspace(0.0, BAG_HEIGHT, 11))
    for side in (1.0, -1.0):

        def place(u: float, v: float, side: float = side) -> tuple[float, float, float]:
            across, radius = u - 0.5 * BAG_WIDTH, 0.5 * BAG_WIDTH / BAG_ANGLE
            share = np.sin(0.5 * np.pi * min(v / BAG_FOOT, 1.0))
            x = (1.0 - share) * across + share * radius * np.sin(across / radius)
            return side * x, v, side * share * radius * (np.cos(across / radius) - np.cos(BAG_ANGLE))

        text.add_panel(texture, placed(texture, place))
    return text


def skirt() -> PatternText:
    """A skirt of four gores, wider at the hem, on a cone."""
    text = PatternText()
    share = nodes(np.linspace(0.0, 1.0, 7), np.linspace(0.0, 1.0, 10))
    width = HEM + (WAIST - HEM) * share[:, :, 1]
    texture = np.stack([(share[:, :, 0] - 0.5) * width, SKIRT_LENGTH * share[:, :, 1]], axis=2)
    for gore in range(GORES):
        angle = 2.0 * np.pi * ((gore + share[:, :, 0]) % GORES) / GORES
        radius = GORES * width / (2.0 * np.pi)
        points = np.stack([radius * np.sin(angle), texture[:, :, 1], radius * np.cos(angle)], axis=2)
        text.add_panel(texture, points)
    return text


def darted() -> PatternText:
    """A panel with a dart from its lower edge: a notch in the texture that is closed in space."""
    text = PatternText()
    heights, share = np.linspace(0.0, DART_PANEL_HEIGHT, 11), np.linspace(0.0, 1.0, 6)
    gap = 0.5 * DART_WIDTH * np.maximum(1.0 - heights / DART_DEPTH, 0.0)[:, None]
    x = (0.5 * DART_PANEL_WIDTH - gap) * share
    points = np.stack([x, np.broadcast_to(heights[:, None], x.shape), -0.02 * x**2], axis=2)
    texture = np.stack([x + gap, points[:, :, 1]], axis=2)
    text.add_panel(texture, points)
    mirror = np.array([-1.0, 1.0])
    text.add_panel(texture[:, ::-1] * mirror, points[:, ::-1] * np.array([-1.0, 1.0, 1.0]), joined=True)
    return text


def t_shirt(cap: float = 0.0, cuff: float = 0.0) -> PatternText:
    """A T-shirt of a front, a back and two sleeves, with dropped shoulders and round necks.

    Args:
        cap: height of the cap of the sleeves in the pattern [cm].
        cuff: height of the middle of the cuffs above their ends in the pattern [cm]; the lower edge is then curved.
    """
    text = PatternText()
    _add_body(text)
    _add_sleeves(text, BODY_HEIGHTS[BODY_HEIGHTS >= ARMPIT], cap, cuff)
    return text


def dress(flare: float, curve: float) -> PatternText:
    """A dress: the body of the T-shirt, and a flared skirt of a front and a back with curved hems.

    Args:
        flare: width that the hem has more than the waist at each side [cm].
        curve: depth of the middle of the hem below its ends [cm].
    """
    text = PatternText()
    _add_body(text)
    grid = nodes(BODY_PLACES / SHIRT_WIDTH, np.linspace(1.0, 0.0, 14))
    across, down = grid[:, :, 0], grid[:, :, 1]
    x = 0.5 * SHIRT_WIDTH + (across - 0.5) * (SHIRT_WIDTH + 2.0 * flare * down)
    height = -DRESS_LENGTH * down - curve * np.sin(np.pi * across) * down
    for side in (1.0, -1.0):
        z = side * (BODY_DEPTH + flare * down) * np.sin(np.pi * across)
        texture, points = np.stack([side * x, height], axis=2), np.stack([x, height, z], axis=2)
        text.add_panel(*((texture, points) if side > 0.0 else (texture[:, ::-1], points[:, ::-1])))
    return text


def _add_body(text: PatternText) -> None:
    """Add a front and a back."""
    for side, depth in ((1.0, FRONT_NECK), (-1.0, BACK_NECK)):
        grid = nodes(BODY_PLACES, BODY_HEIGHTS / SHOULDER)
        height = grid[:, :, 1] * _top(grid[:, :, 0], depth)
        bulge = np.sin(np.pi * grid[:, :, 0] / SHIRT_WIDTH)
        share = height / _top(grid[:, :, 0], 0.0)
        z = side * (BODY_DEPTH * bulge * (1.0 - share**4) + _armhole(height) * (1.0 - bulge))
        z = np.where(share == 1.0, 0.0, z)
        points = np.stack([grid[:, :, 0], height, z], axis=2)
        texture = np.stack([side * grid[:, :, 0], height], axis=2)
        text.add_panel(*((texture, points) if side > 0.0 else (texture[:, ::-1], points[:, ::-1])))


def _top(x: FloatArray, depth: float) -> FloatArray:
    """Height of the top of a body panel: sloped shoulders and a round neck of some depth."""
    across = np.abs(x - 0.5 * SHIRT_WIDTH) / (0.5 * NECK_WIDTH)
    shoulder = SHOULDER + (NECK_HEIGHT - SHOULDER) * np.minimum(x, SHIRT_WIDTH - x) / (0.5 * (SHIRT_WIDTH - NECK_WIDTH))
    return np.where(across < 1.0, NECK_HEIGHT - depth * np.sqrt(np.maximum(1.0 - across**2, 0.0)), shoulder)


def _armhole(height: FloatArray) -> FloatArray:
    """Half of the width of the armhole at some heights."""
    share = np.clip((height - ARMPIT) / (SHOULDER - ARMPIT), 0.0, 1.0)
    return 4.0 * np.sin(np.pi * share)


def _add_sleeves(text: PatternText, heights: FloatArray, cap: float, cuff: float) -> None:
    """Add two sleeves on the rings of the armholes, knitted from the cuff."""
    opening = _armhole(heights)
    ring = np.concatenate([np.stack([heights, opening], axis=1), np.stack([heights, -opening], axis=1)[-2::-1]])
    around = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    texture = nodes(around, np.linspace(0.0, SLEEVE_LENGTH, 7))
    for outward, x, z_sign in ((1.0, SHIRT_WIDTH, 1.0), (-1.0, 0.0, -1.0)):
        away = x + outward * (SLEEVE_LENGTH - texture[:, :, 1])
        yz = np.broadcast_to(ring * np.array([1.0, z_sign]), (*texture.shape[:2], 2))
        share = texture[:, :, 1] / SLEEVE_LENGTH
        raised = (cap * share + cuff * (1.0 - share)) * np.sin(np.pi * texture[:, :, 0] / around[-1])
        curved = np.stack([texture[:, :, 0], texture[:, :, 1] + raised], axis=2)
        text.add_panel(curved, np.concatenate([away[:, :, None], yz], axis=2))
