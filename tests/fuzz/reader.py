# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A reader of files as the benchmark of damaged files sees it, and undamaged files for it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import stitchmesh as sm
from stitchmesh.errors import FileError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.yarn import YarnSet
from tests.fuzz import mutations as damage
from tests.gallery import ROOT

Seeds = Callable[[Path], Sequence[bytes]]
"""Function that returns undamaged files; it may write into the folder that it gets."""


@dataclass(frozen=True)
class Reader:
    """A function that reads files, and what is needed to damage its files."""

    suffix: str
    read: Callable[[Path], Any]
    seeds: Seeds
    kinds: Sequence[damage.Mutation] = damage.TEXT
    """Changes of the files."""
    errors: tuple[type[Exception], ...] = (FileError,)
    """Errors that the reader may raise for a damaged file."""
    has_own_process: bool = False
    """Whether the library reads in a process of its own, so that its end is a ``FileError``; ``read`` does not."""


def later(name: str) -> Callable[..., Any]:
    """Return a function of the package by its full name, whose module is imported by the first call.

    So a process that damages the files of one reader loads the modules of this reader only.
    """
    module, _, function = name.rpartition(".")

    def call(*given: Any) -> Any:
        return getattr(import_module(module), function)(*given)

    return call


def written(write: Callable[..., None], *values: Any, suffix: str, **options: Any) -> Callable[[Path], list[bytes]]:
    """Return a function that writes each value to a file and returns the contents."""

    def contents(folder: Path) -> list[bytes]:
        found = []
        for value in values:
            path = folder / f"seed{suffix}"
            write(path, value() if callable(value) else value, **options)
            found.append(path.read_bytes())
            path.unlink()
        return found

    return contents


def files(*names: str) -> Callable[[Path], list[bytes]]:
    """Return a function that returns the contents of files of the repository."""
    return lambda folder: [(ROOT / name).read_bytes() for name in names]


def rebuilt(own: Seeds, change: damage.Mutation, count: int) -> Callable[[Path], list[bytes]]:
    """Return a function that returns the contents of a function, and a number of them after a change each."""

    def contents(folder: Path) -> list[bytes]:
        random, found = Random(1), list(own(folder))
        return [*found, *(change(random, random.choice(found)) for _ in range(count))]

    return contents


def joined(*parts: Callable[[Path], Sequence[bytes]]) -> Callable[[Path], list[bytes]]:
    """Return a function that returns the contents of all functions."""
    return lambda folder: [content for part in parts for content in part(folder)]


def under_name(name: str, read: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Return a reader of a folder in which the damaged file has a given name, which may lie in folders of its own."""

    def read_folder(path: Path) -> Any:
        target = path.parent / name
        target.parent.mkdir(parents=True, exist_ok=True)
        path.replace(target)
        return read(path.parent)

    return read_folder


def cube() -> Mesh:
    """Return a cube with an open side, of quads and two triangles."""
    vertices = [[x, y, z + x / 3] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    return Mesh.from_polygons(np.array(vertices), [[0, 1, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6]])


def small_yarns(periodic: bool = False) -> YarnSet:
    """Return a closed and an open yarn, or a closed yarn on a lattice."""
    angle = np.linspace(0, 2 * np.pi, 7)[:-1]
    ring = np.stack([np.cos(angle), np.sin(angle), 0.1 * np.cos(2 * angle)], axis=1)
    if periodic:
        yarns = YarnSet.from_curves([ring, ring + np.array([0, 0, 3])], closed=[True, True], radius=0.1)
        lattice = Lattice([[5.0, 0, 0], [0, 4.0, 0]])
        return dataclasses.replace(yarns, lattice=lattice, lattice_step=np.zeros((2, 2), int))
    return YarnSet.from_curves([ring, ring[:4] * 1.5], closed=[True, False], radius=[0.1, 0.2])


def small_fabric() -> StitchMesh:
    """Return a flat fabric of six stitches above a cast-on row."""
    return sm.pattern_mesh(sm.read_pattern("rib1x1"), 2, 1, stitch_width=0.8, stitch_height=0.5)
