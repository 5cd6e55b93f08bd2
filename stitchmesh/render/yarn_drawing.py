# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns in a picture, with the detail that their size in the picture shows.

A yarn that is fewer than ``PLIES_FROM`` pixels thick is a tube. From there on its plies are drawn, with fibres that
stand off, and from ``FIBRES_FROM`` pixels on the fibres of the plies too.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.mesh import IntArray
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.render.camera import VIEW_ANGLE, Camera
from stitchmesh.render.colouring import Coloured
from stitchmesh.render.exposure import OVERSIZE
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.stage import add_threads, add_tubes, dim_colours
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.yarn_look import YarnLook
from stitchmesh.yarn.yarn_strands import FIBRE, FIBRE_SHARE, HAIR, PLY, yarn_strands

if TYPE_CHECKING:
    import pyvista

PLIES_FROM, FIBRES_FROM = 6.0, 32.0
"""Apparent diameters of yarn from which its plies, and the fibres of its plies, are drawn [pixels]."""
MOST_FIBRE_POINTS = 3_000_000
"""Largest number of points of fibres in a picture; fewer fibres are drawn if it is exceeded."""
MOST_FIBRES = 120
"""Largest number of fibres that are drawn of a ply: those that can be seen."""
CORE, CORE_SHADE = 0.9, 0.8
"""Radius of the solid middle of a ply whose fibres are drawn, over that of the ply, and its brightness behind them."""
TUBES = YarnLook("monofilament", sheen=0.1)
"""The look of yarns whose colours show numbers."""
FINEST = 0.5
"""Width of the thinnest line [pixels]; there are fewer fibres that stand off where they are thinner than this."""


def look_of(yarns: YarnSet, options: PictureOptions, coloured: Coloured) -> YarnLook:
    """Return the look of yarns in a picture: plain tubes if their colours show numbers."""
    if coloured.scale is not None:
        return TUBES
    if options.look is not None:
        return options.look if isinstance(options.look, YarnLook) else YarnLook(options.look)
    return YarnLook() if yarns.made_of is None else yarns.made_of.look


def pixels_at(camera: Camera, height: int) -> float:
    """Return the pixels of a centimetre at the focus of a camera, in a picture of ``height`` pixels."""
    distance = float(np.linalg.norm(camera.position - camera.focus))
    return height / (2.0 * np.tan(np.radians(VIEW_ANGLE / 2.0)) * distance)


def add_yarns(
    plotter: pyvista.Plotter, yarns: YarnSet, segments: IntArray, detail: tuple[int, int], coloured: Coloured,
    look: YarnLook, pixels: float,
) -> None:  # fmt: skip
    """Add some segments of yarns.

    Args:
        plotter: the plotter.
        yarns: the yarns.
        segments: numbers of the segments, ascending.
        detail: sides of a tube and samples per segment.
        coloured: colours of the control points.
        look: how the yarns look.
        pixels: pixels of a centimetre.
    """
    thick = 2.0 * float(np.median(yarns.drawn_radius)) * pixels
    shown = replace(look, plies=1, body=1.0) if thick < PLIES_FROM else look
    fibres, hair = drawn_fibres(shown, thick, len(segments) * detail[1])
    strands = yarn_strands(
        yarns, shown, segments=segments, samples=detail[1], fibres=fibres, hair=hair, colours=coloured.points
    )
    curves = np.split(strands.points, strands.start[1:-1])
    solid = [curve for curve, kind in zip(curves, strands.kind.tolist(), strict=True) if kind == PLY]
    count = sum(len(curve) for curve in solid)
    core, shade = (CORE, CORE_SHADE) if fibres else (1.0, 1.0)
    tubes = tubes_around(solid, strands.closed[strands.kind == PLY], core * strands.radius[:count], sides=detail[0])
    colours = dim_colours(strands.colour)
    add_tubes(plotter, tubes, dim_colours(strands.colour[:count], shade)[tubes.ring])
    for kind in (FIBRE, HAIR):
        chosen = np.flatnonzero(strands.kind == kind)
        if len(chosen):
            own = slice(int(strands.start[chosen[0]]), int(strands.start[chosen[-1] + 1]))
            starts = strands.start[chosen[0] : chosen[-1] + 2] - own.start
            width = 2.0 * OVERSIZE * pixels * float(np.median(strands.radius[own]))
            add_threads(plotter, strands.points[own], starts, colours[own], max(width, OVERSIZE * FINEST))


def drawn_fibres(look: YarnLook, thick: float, points: int) -> tuple[int, float]:
    """Return the number of fibres that are drawn of each ply, and the part of the fibres that stand off.

    Args:
        look: how the yarn looks.
        thick: apparent diameter of the yarn [pixels].
        points: number of points of a ply.
    """
    if thick < PLIES_FROM:
        return 0, 0.0
    width = thick * look.body * np.sqrt(FIBRE_SHARE / max(look.fibres, 1))
    hair = min(1.0, np.sqrt(width / FINEST))
    if thick < FIBRES_FROM or not look.fibres:
        return 0, hair
    most = MOST_FIBRE_POINTS // max(points * look.plies, 1)
    return int(min(look.fibres // look.plies, MOST_FIBRES, most)), hair
