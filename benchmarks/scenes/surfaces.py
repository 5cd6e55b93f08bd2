# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces of triangles whose rows are found: files, shapes of formulas, and triangulated garments of the project."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import stitchmesh as sm
from benchmarks.places import MESHES
from stitchmesh.io.meshes import read_repaired_mesh
from stitchmesh.mesh import Mesh

SMALL = {"hat", "sock", "tea_cozy", "swatch"}
"""Garments that are knitted in stitches of 0.8 cm; the glove in stitches of 0.5 cm, larger ones of 1.6 cm."""


@dataclass(frozen=True)
class Surface:
    """A surface, and the width of its stitches."""

    name: str
    width: float
    """Width of a stitch [cm]."""
    make: Callable[[], Mesh]


def surfaces(files: Sequence[Path] = (), unit: str = "cm", width: float = 0.8) -> Iterator[Surface]:
    """Yield the surfaces of some files, or all shapes and garments of the project."""
    for path in files:
        yield Surface(path.stem, width, lambda path=path: read_repaired_mesh(path, unit=unit).mesh)  # type: ignore[misc]
    if files:
        return
    from benchmarks.scenes.surface_shapes import SHAPES  # needs pyvista

    for name, make in SHAPES.items():
        yield Surface(name, 0.8, make)
    yield from map(garment, sorted(MESHES.glob("*.obj")))


def garment(path: Path) -> Surface:
    """Return a garment of the project in triangles, which follow no rows."""
    from benchmarks.scenes.surface_shapes import triangulated  # needs pyvista

    width = 0.5 if path.stem == "glove" else 0.8 if path.stem in SMALL else 1.6
    return Surface(path.name, width, partial(_triangulated, triangulated, path))


def _triangulated(triangulate: Callable[[Mesh], Mesh], path: Path) -> Mesh:
    return triangulate(sm.read_mesh(path))
