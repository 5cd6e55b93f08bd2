# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A picture of whatever a file holds."""

from __future__ import annotations

from collections.abc import Callable
from os import fspath

from stitchmesh.errors import ParameterError
from stitchmesh.io.any_file import read_any
from stitchmesh.io.contents import FilePath
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.fabric_pictures import (
    PICTURE_SIZE,
    Size,
    render_mesh,
    render_rows,
    render_stitches,
    render_stretch,
)
from stitchmesh.render.picture import render_yarns
from stitchmesh.yarn import YarnSet

FABRIC_PICTURES: dict[str, Callable[..., None]] = {
    "rows": render_rows,
    "stitches": render_stitches,
    "stretch": render_stretch,
}
"""Pictures that can be drawn of a stitch mesh."""


def render_file(
    source: FilePath,
    path: FilePath,
    *,
    what: str | None = None,
    unit: str = DEFAULT_UNIT,
    radius: float | None = None,
    size: Size = PICTURE_SIZE,
) -> None:
    """Draw a polygon mesh, a stitch mesh or yarns.

    Args:
        source: any file that ``read_mesh``, ``read_stitches`` or ``read_yarns`` reads; what it holds decides.
        path: a ``.png`` file; missing folders are made.
        what: for a stitch mesh ``rows``, ``stitches`` or ``stretch``; where None, rows if it is labeled only, else
            stitches.
        unit: unit of the source's coordinates, unless it is HDF5 or USD.
        radius: radius of all yarns [cm]; where None, as ``read_yarns`` finds it.
        size: width and height [pixels].

    Raises:
        ParameterError: the unit is unknown, the file holds nothing of which such a picture can be drawn, or its yarns'
            radius is neither given nor can be estimated.
        FileError: the source cannot be read or the picture cannot be written.
        MeshError: the polygons do not form an oriented manifold surface.
        DisplayError: this machine cannot draw.
    """
    noun = read_any(source, unit=unit, radius=radius)
    if isinstance(noun, StitchMesh):
        _render_fabric(noun, path, what, size)
    elif what is not None:
        raise ParameterError(f"what: {fspath(source)} holds no stitch mesh; a picture of its {what} cannot be drawn")
    elif isinstance(noun, YarnSet):
        render_yarns(noun, path, size=size)
    else:
        render_mesh(noun, path, size=size)


def _render_fabric(fabric: StitchMesh, path: FilePath, what: str | None, size: Size) -> None:
    if what is None:
        what = "rows" if (fabric.stitch == Stitch.PANEL).all() else "stitches"
    if what not in FABRIC_PICTURES:
        raise ParameterError(f"what: got {what!r}; expected one of {', '.join(FABRIC_PICTURES)} for a stitch mesh")
    FABRIC_PICTURES[what](fabric, path, size=size)
