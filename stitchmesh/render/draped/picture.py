# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of runs of mixed yarns and triangles, drawn as yarns everywhere: one run alone or several side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mixed.assembly import bodies_at
from stitchmesh.mixed.drape import Draped
from stitchmesh.render.camera import camera_around
from stitchmesh.render.colour_scale import sequential_scale
from stitchmesh.render.colouring import Coloured, colour_yarns
from stitchmesh.render.draped.colouring import ALPHA_SCALE, LEAST_TENSION, DrapedValues, nodes_at_points
from stitchmesh.render.lettering import INK
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.picture import detail_for
from stitchmesh.render.stage import KEY_LEFT, Viewport, add_body, look, picture, shade_hollows
from stitchmesh.render.view import turned_view
from stitchmesh.render.yarn_drawing import TUBES, add_yarns
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    import pyvista

def render_draped(
    runs: Sequence[tuple[str, Draped]], path: FilePath, *, colour: str | None = None,
    view: tuple[float, float] | None = None, size: tuple[int, int] | None = None,
) -> None:  # fmt: skip
    """Draw the last states of runs of one scene side by side, seen by the same camera.

    Args:
        runs: name and result of each run.
        path: a ``.png`` file; missing folders are created.
        colour: ``yarn``, ``alpha`` or ``tension``; by default the choice of the first scene.
        view: azimuth (0 from the side of z, 90 from that of x) and elevation of the camera [degrees]; by default those
            of the first scene.
        size: width and height of each run in the picture [pixels]; by default those of the first scene.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    output = runs[0][1].prepared.scene.output
    width, height = size or output.size
    options = PictureOptions(size=(width * len(runs), height))
    curves = [run.yarns for _name, run in runs]
    coloured = colours_of_runs([run for _name, run in runs], curves, colour or output.colour)
    bodies = bodies_at_end(runs[0][1])
    towards, up = turned_view(np.eye(3)[2], np.eye(3)[1], *np.radians(view or output.view))
    framed = framed_points(np.concatenate([each.points for each in curves]), bodies)
    part = (KEY_LEFT if coloured[0].key and len(runs) == 1 else 1.0, 0.94)
    camera = camera_around(framed, towards, up, width / height, part=part)
    panels = [_panel(number, len(runs)) for number in range(len(runs))]
    key = coloured[0].key if len(runs) == 1 else ()
    with picture(path, options, panels=tuple(panels), key=key) as plotter:
        for number, (yarns, own) in enumerate(zip(curves, coloured, strict=True)):
            plotter.subplot(0, number)
            _draw(plotter, yarns, own.points)
            _write_name(plotter, runs[number][0], height)
            for body in bodies:
                add_body(plotter, body)
            look(plotter, camera)
            plotter.camera.SetWindowCenter(1.0 - part[0], 0.0)
            shade_hollows(plotter, 4.0 * float(np.median(yarns.drawn_radius)), options)


def framed_points(cloth: FloatArray, bodies: Sequence[Mesh]) -> FloatArray:
    """Return the points that a picture must show: the cloth, and the parts of bodies around it.

    Args:
        cloth: points of the cloth, shape (n, 3).
        bodies: the bodies.
    """
    low, high = cloth.min(axis=0), cloth.max(axis=0)
    margin = 0.1 * (high - low).max()  # A body may be much larger than a cloth.
    points = np.concatenate([np.zeros((0, 3)), *(body.vertices for body in bodies)])
    near = ((points > low - margin) & (points < high + margin)).all(axis=1)
    return np.concatenate([cloth, points[near]])


def _panel(number: int, count: int) -> Viewport:
    return number / count, 0.0, (number + 1) / count, 1.0


def _write_name(plotter: pyvista.Plotter, name: str, height: int) -> None:
    """Write the name of a run into the lower left corner of its panel."""
    if name:
        size = max(round(0.03 * height), 1)
        plotter.add_text(name, position="lower_left", font_size=size, color=INK)


def _draw(plotter: pyvista.Plotter, yarns: YarnSet, colours: NDArray[np.uint8]) -> None:
    segments = np.arange(len(yarns.segment_points))
    add_yarns(plotter, yarns, segments, detail_for(len(segments)), Coloured(colours), TUBES, 1.0)


def bodies_at_end(run: Draped) -> list[Mesh]:
    """Return the bodies of a run at their places at its end."""
    return bodies_at(run.prepared.bodies, run.end.time)


def colours_of_runs(runs: Sequence[Draped], curves: Sequence[YarnSet], colour: str) -> list[Coloured]:
    """Return the colours of the control points of each run, on a common scale.

    Args:
        runs: the runs.
        curves: their yarns.
        colour: ``yarn`` for the colours of the families, ``alpha`` or ``tension``.
    """
    if colour == "yarn":
        return [colour_yarns(each, "yarn") for each in curves]
    values = [_values_at_points(run, each, colour) for run, each in zip(runs, curves, strict=True)]
    if colour == "alpha":
        scale, text = ALPHA_SCALE, "alpha {:.2f}"
    else:
        scale, text = sequential_scale(np.concatenate(values), LEAST_TENSION, low=0.0), "{:.3g} dyn"
    key = scale.key(text.format)
    return [Coloured(scale.of(each), key, scale) for each in values]


def _values_at_points(run: Draped, curves: YarnSet, colour: str) -> FloatArray:
    """Return alpha or tension at each control point, shape (P,)."""
    values = DrapedValues(run, run.end, nodes_at_points(run, run.end, curves))
    return values.alpha()[0] if colour == "alpha" else values.yarn_tension()
