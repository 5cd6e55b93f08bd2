# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The add-on for Blender as a zip file that Blender installs.

The add-on is a program of its own under the GPL, as Blender asks. It runs ``stitchmesh`` as a process and imports
nothing of it; here its files are data.
"""

from __future__ import annotations

import io
import zipfile
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, read_bytes

_PACKAGE = Path(__file__).resolve().parents[1]
_FOLDERS = (_PACKAGE / "assets" / "blender", _PACKAGE.parent / "assets" / "blender")
"""Folders that may hold the add-on: an installed package, or the repository around it."""
NAME = "stitchmesh_blender"
"""Folder of the add-on, in the zip file too; its name is the name of the module in Blender."""
FILES = ("__init__.py", "LICENSE", "blender_manifest.toml", "curves.py", "program.py", "wool.py", "yarns.py")
"""Files of the add-on."""
FIRST_DATE = (1980, 1, 1, 0, 0, 0)
"""Date of all files in the zip file, so that the same add-on has the same bytes; the format knows no earlier one."""


def write_blender_addon(path: FilePath) -> None:
    """Write the add-on as a zip file.

    Args:
        path: the file; its name ends in ``.zip``, because Blender installs no other.

    Raises:
        FileError: the name has another ending, or the file cannot be written.
    """
    if Path(path).suffix.lower() != ".zip":
        raise FileError(f"{fspath(path)}: got the ending {Path(path).suffix!r}; expected .zip; rename it")
    folder = next((place for place in _FOLDERS if place.is_dir()), _FOLDERS[0]) / NAME
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        for name in FILES:
            entry = zipfile.ZipInfo(f"{NAME}/{name}", FIRST_DATE)
            archive.writestr(entry, read_bytes(folder / name), zipfile.ZIP_DEFLATED)
    write_bytes(path, content.getvalue())
