# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files: polygon meshes, stitch meshes and yarns; one format per module, all writes atomic.

Names are loaded when first used, so that the command line knows the units without any format.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.io.meshes import read_mesh, write_mesh
    from stitchmesh.io.stitches import read_stitches, write_stitches
    from stitchmesh.io.yarns import read_yarns, write_yarns

_HOME = {
    "read_mesh": "meshes",
    "write_mesh": "meshes",
    "read_stitches": "stitches",
    "write_stitches": "stitches",
    "read_yarns": "yarns",
    "write_yarns": "yarns",
}
"""Module of each public name."""

__all__ = ["read_mesh", "read_stitches", "read_yarns", "write_mesh", "write_stitches", "write_yarns"]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
