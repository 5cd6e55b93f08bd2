# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Garments: meshes of ``assets/meshes``, of files and of formulas, divided into stitches of some width."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import stitchmesh as sm
from benchmarks.places import MESHES
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.quality import Quality
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True)
class Garment:
    """A mesh that is modelled in rows, and the width of its stitches."""

    mesh_name: str
    """Name of a mesh of ``assets/meshes`` or of ``FORMULAS``, or a path."""
    width: float
    """Width of a stitch [cm]."""
    unit: str = "cm"
    """Unit of a file."""

    @classmethod
    def of(cls, word: str) -> Garment:
        """Return the garment of a word MESH:WIDTH."""
        name, _, width = word.rpartition(":")
        return cls(name, float(width))

    @property
    def name(self) -> str:
        """The name of the mesh."""
        return Path(self.mesh_name).stem

    def mesh(self) -> Mesh:
        """Read or make the mesh."""
        if self.mesh_name in FORMULAS:
            return FORMULAS[self.mesh_name]()
        path = Path(self.mesh_name)
        return sm.read_mesh(path if path.exists() else MESHES / f"{self.name}.obj", unit=self.unit)

    def divided(self) -> StitchMesh:
        """Return the stitches as divided, not relaxed."""
        return sm.tessellate(sm.label(self.mesh()), stitch_width=self.width)

    def evened(self, device: str | None = None) -> StitchMesh:
        """Return the stitches, relaxed on the surface of the mesh."""
        return sm.relax_mesh(self.divided(), surface=self.mesh(), device=device, run=QUIET).fabric

    def yarns(self, quality: str | Quality, device: str | None = None) -> tuple[YarnSet, StitchMesh]:
        """Return yarns as a quality samples them, and the stitches whose shape they keep."""
        fabric = self.evened(device)
        return sm.generate_yarns(fabric, quality=quality), fabric


def uneven_tube() -> Mesh:
    """A straight tube whose coarse quads are unevenly wide and high."""
    angle, height = _uneven_turn(24), 80.0 * _uneven_climb(16)
    return _rings(np.full((17, 24), 20.0), np.broadcast_to(angle, (17, 24)), height)


def flared_skirt() -> Mesh:
    """A skirt from a waist of 12 cm radius to a waved hem of about 30 cm."""
    angle, climb = _uneven_turn(40), _uneven_climb(16)
    radius = 12.0 + 18.0 * climb[:, None] ** 1.5 * (1.0 + 0.15 * np.cos(5.0 * angle))
    return _rings(radius, np.broadcast_to(angle, radius.shape), 60.0 * climb)


def _uneven_turn(count: int) -> FloatArray:
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return angle + 0.05 * np.sin(3.0 * angle)


def _uneven_climb(count: int) -> FloatArray:
    climb = np.linspace(0.0, 1.0, count + 1)
    return climb + 0.05 * np.sin(2.0 * np.pi * climb)


def _rings(radius: FloatArray, angle: FloatArray, height: FloatArray) -> Mesh:
    rows, around = radius.shape
    levels = np.broadcast_to(height[:, None], radius.shape)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), levels], axis=2)
    row, column = (index.ravel() for index in np.indices((rows - 1, around)))
    following = (column + 1) % around
    first, second = row * around, (row + 1) * around
    faces = np.stack([first + column, first + following, second + following, second + column], axis=1)
    return Mesh.from_polygons(points.reshape(-1, 3), faces.tolist())


FORMULAS: dict[str, Callable[[], Mesh]] = {"uneven_tube": uneven_tube, "flared_skirt": flared_skirt}
"""Meshes that a formula makes, by their names."""
