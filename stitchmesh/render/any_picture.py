# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of meshes, fabrics, yarns and swatches, with all options that a user can choose."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

from stitchmesh.errors import ParameterError
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.periodic.swatch import Swatch
from stitchmesh.render.close_up import KINDS
from stitchmesh.render.colouring import COLOUR_BY, one_colour
from stitchmesh.render.fabric_pictures import render_faces, render_mesh, render_rows, render_stitches, render_stretch
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.picture import render_yarns
from stitchmesh.render.shaping_picture import render_irregular
from stitchmesh.render.swatch_picture import DEFAULT_TILES, render_swatch
from stitchmesh.selection import select
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns
from stitchmesh.yarngen.face_yarns.generate import face_yarns

FABRIC_PICTURES: dict[str, Callable[..., None]] = {
    "yarn": render_faces,
    "row": render_rows,
    "stitch": render_stitches,
    "strain": render_stretch,
    "stretch": render_stretch,
    "irregular": render_irregular,
}
"""The functions that draw a stitch mesh, by the word that chooses the colours."""


def render(
    thing: Mesh | YarnSet | Swatch | FaceMesh, path: FilePath, *, tiles: tuple[int, int] | None = None, **options: Any
) -> None:
    """Draw a picture of a polygon mesh, a stitch mesh, yarns, a swatch, or the yarns of a face mesh.

    Yarns are drawn with their look and their apparent radius (``YarnSet.drawn_radius``), in their own colours. Yarns
    that repeat fill the picture, seen from their right side, unless a view or a close-up is given.

    Args:
        thing: a mesh, yarns, the result of ``swatch``, or a face mesh.
        path: a ``.png`` file; missing folders are created.
        tiles: numbers of periods of yarns that repeat, along the courses and along the wales; 5 by 5 by default.
        options: fields of ``PictureOptions``: ``view``, ``close_up``, ``extent``, ``size``, ``colour``, ``blend``,
            ``background``, ``body``, ``fabric``, ``look``, ``inset``, ``occlusion``, ``scale_bar``, ``framed`` and
            ``colours``.

    Raises:
        ParameterError: an option is unknown or not possible, or does not fit the object.
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
        YarnError: tiles are given for yarns that do not repeat.
    """
    chosen = _options(options)
    if isinstance(thing, Swatch):
        chosen = _options({"fabric": thing.fabric, **options})
        thing = thing.yarns
    if isinstance(thing, FaceMesh):
        thing = face_yarns(thing).yarns
    if isinstance(thing, YarnSet):
        _render_yarns(thing, path, tiles, _with_selection(chosen, chosen.fabric))
        return
    if not isinstance(thing, Mesh):
        raise ParameterError(f"render: got a {type(thing).__name__}; expected a mesh, yarns or a swatch")
    if tiles is not None:
        raise ParameterError("tiles: got tiles of a mesh; only yarns that repeat have them")
    if chosen.look is not None:
        raise ParameterError("look: got a look for a mesh; only yarns have one")
    _render_mesh(thing, path, _with_selection(chosen, thing if isinstance(thing, StitchMesh) else None))


def _options(options: dict[str, Any]) -> PictureOptions:
    known = [field.name for field in fields(PictureOptions)]
    unknown = [name for name in options if name not in known]
    if unknown:
        near = difflib.get_close_matches(unknown[0], known, n=1) or [", ".join(known)]
        raise ParameterError(f"render: got {unknown[0]!r}; expected {near[0]}")
    return PictureOptions(**options)


def _with_selection(options: PictureOptions, fabric: StitchMesh | None) -> PictureOptions:
    """Return the options; where the close-up is the text of a selection, the faces of the selection take its place."""
    text = options.close_up
    if fabric is None or not isinstance(text, str) or text.split(" ")[0].lower() in KINDS:
        return options
    return replace(options, close_up=select(fabric, text))


def _render_yarns(yarns: YarnSet, path: FilePath, tiles: tuple[int, int] | None, options: PictureOptions) -> None:
    if yarns.lattice is None and tiles is None:
        render_yarns(yarns, path, options)
    elif options.view is None and options.close_up is None and options.body is None:
        render_swatch(yarns, path, tiles or DEFAULT_TILES, options)
    else:
        render_yarns(tile_yarns(yarns, *(tiles or DEFAULT_TILES)), path, options)


def _render_mesh(mesh: Mesh, path: FilePath, options: PictureOptions) -> None:
    colour = options.colour
    if not isinstance(mesh, StitchMesh):
        if colour in COLOUR_BY:
            raise ParameterError(f"colour: got {colour!r} for a polygon mesh, which has no {colour}s; give one colour")
        (render_mesh if colour is None else render_faces)(mesh, path, options)
        return
    if colour is None:
        colour = "row" if (mesh.stitch == Stitch.PANEL).all() else "stitch"
    if colour in COLOUR_BY and colour not in FABRIC_PICTURES:
        raise ParameterError(f"colour: got {colour!r} for a stitch mesh; only yarns have it")
    if colour not in FABRIC_PICTURES:
        one_colour(colour)
    FABRIC_PICTURES.get(colour, render_faces)(mesh, path, options)
