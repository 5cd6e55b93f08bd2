# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The garments, recipes and scenes that come with the program, so that nobody needs a mesh of their own to begin."""

from __future__ import annotations

import difflib
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.contents import check_path, read_bytes
from stitchmesh.io.path_kind import FilePath, is_there

_PACKAGE = Path(__file__).resolve().parents[1]
_PLACES = (_PACKAGE, _PACKAGE.parent)
"""Folders that may hold the examples: an installed package, or the repository around it."""
MESHES, OTHERS = Path("assets") / "meshes", Path("examples")
"""Folders of the meshes, and of the recipes and scenes that use them."""
DATA = (".obj", ".toml", ".knit", ".png", ".smobj", ".json")
"""Suffixes of the files of examples; other files, such as programs, do not come with the package."""


def example_names() -> tuple[str, ...]:
    """Return the names of the garments, sorted."""
    return tuple(sorted(path.stem.replace("_", " ") for path in (_place() / MESHES).glob("*.obj")))


def read_example(name: str) -> tuple[str, bytes]:
    """Return the name and the bytes of the file of a garment.

    Raises:
        ParameterError: there is no garment of that name.
    """
    if name not in example_names():
        near = difflib.get_close_matches(name, example_names(), n=1) or [", ".join(example_names())]
        raise ParameterError(f"example {name!r}: does not come with the program; expected {near[0]}")
    path = _file_of(name)
    return path.name, read_bytes(path)


def mesh_file(path: FilePath) -> FilePath:
    """Return the file of a garment for its name. Any other path stays as it is, even a file that has such a name.

    Raises:
        ParameterError: the path is neither a text nor a ``Path``.
        FileError: the path is a word without a folder and a suffix, and neither a file nor a garment has this name.
    """
    check_path(path)
    word = fspath(path)
    if not word or Path(word).name != word or Path(word).suffix or is_there(path):
        return path
    name = word.replace("_", " ").replace("-", " ").lower()
    if name in example_names():
        return _file_of(name)
    known = ", ".join(example_names())
    raise FileError(f"{word}: there is no such file, and no example of this name; the examples are {known}")


def example_files() -> dict[Path, Path]:
    """Return all files of examples, by their places beside each other: ``assets/meshes/hat.obj``."""
    place = _place()
    found = [path for folder in (MESHES, OTHERS) for path in (place / folder).rglob("*") if path.suffix in DATA]
    return {path.relative_to(place): path for path in sorted(found)}


def _place() -> Path:
    return next((place for place in _PLACES if (place / MESHES).is_dir()), _PACKAGE)


def _file_of(name: str) -> Path:
    return _place() / MESHES / f"{name.replace(' ', '_')}.obj"
