# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The garments that come with the program, so that nobody needs a mesh of their own to begin."""

from __future__ import annotations

import difflib
from pathlib import Path

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import read_bytes

_PACKAGE = Path(__file__).resolve().parents[2]
_FOLDERS = (_PACKAGE / "assets" / "meshes", _PACKAGE.parent / "assets" / "meshes")
"""Folders that may hold the garments: inside an installed package, or beside the package in the repository."""


def example_names() -> tuple[str, ...]:
    """Return the names of the garments, sorted."""
    return tuple(sorted(path.stem.replace("_", " ") for path in _folder().glob("*.obj")))


def read_example(name: str) -> tuple[str, bytes]:
    """Return the name and the bytes of the file of a garment.

    Raises:
        ParameterError: there is no garment of that name.
    """
    if name not in example_names():
        near = difflib.get_close_matches(name, example_names(), n=1) or [", ".join(example_names())]
        raise ParameterError(f"example {name!r}: does not come with the program; expected {near[0]}")
    path = _folder() / f"{name.replace(' ', '_')}.obj"
    return path.name, read_bytes(path)


def _folder() -> Path:
    return next((folder for folder in _FOLDERS if folder.is_dir()), _FOLDERS[0])
