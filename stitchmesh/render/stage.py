# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The scene of all pictures: off-screen window, lights, ambient occlusion, and the picture file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.memory_need import check_memory, picture_memory
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.palette import colour_text, linear_colour, parse_colour, srgb_colour
from stitchmesh.mesh.tube_mesh import TubeMesh
from stitchmesh.render.camera import VIEW_ANGLE, Camera
from stitchmesh.render.exposure import OVERSIZE, Seen, exposed, seen_by
from stitchmesh.render.gl_probe import check_display
from stitchmesh.render.lettering import Colour, draw_key, draw_scale_bar, write_caption
from stitchmesh.render.options import TRANSPARENT, PictureOptions
from stitchmesh.render.plots.plot_file import import_matplotlib
from stitchmesh.render.surface import add_faces

if TYPE_CHECKING:
    import pyvista
    from PIL.Image import Image as Picture

PAPER = "#efece6"
"""Background colour at the top of a picture."""

Viewport = tuple[float, float, float, float]
"""Left, lower, right and upper border of a panel, as parts of the picture."""

WHOLE: Viewport = (0.0, 0.0, 1.0, 1.0)
"""The panel that covers the whole picture."""

DARKEST, PALEST = 0.03, 0.94
"""Reflectances of black and of white yarn, in linear light: no yarn swallows all light or returns all of it."""
KEY_LEFT = 0.8
"""Left border of a legend of colours, divided by the width of the picture."""

@contextmanager
def picture(
    path: FilePath,
    options: PictureOptions,
    *,
    panels: tuple[Viewport, ...] = (WHOLE,),
    caption: str = "",
    key: Sequence[tuple[str, Colour]] = (),
) -> Iterator[pyvista.Plotter]:
    """Open an off-screen plotter of one or more panels; the picture is written when the block ends without an error.

    Args:
        path: a ``.png`` file; missing folders are created.
        options: size and background of the picture.
        panels: borders of each panel; a panel covers the panels before it.
        caption: line of text in the lower left corner.
        key: names and colours of a legend, which is drawn to the right of ``KEY_LEFT``.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
        ParameterError: the picture needs more memory than there is (``check_memory``).
    """
    suffix_of(path, (".png",))
    width, height = options.size
    check_memory(f"a picture of {width} x {height} pixels", picture_memory(0.0, width * height), "fewer pixels")
    check_display()
    import_matplotlib()
    import pyvista
    from PIL import Image

    window = [OVERSIZE * options.size[0], OVERSIZE * options.size[1]]
    transparent = options.background == TRANSPARENT
    with atomic_path(path) as temporary:
        plotter = pyvista.Plotter(
            off_screen=True, window_size=window, shape=(1, len(panels)), border=False, lighting="none"
        )
        plotter.render_window.SetMultiSamples(0)  # Four pixels of the window are one of the picture.
        for renderer, viewport in zip(plotter.renderers, panels, strict=True):
            renderer.viewport = viewport
        try:
            _set_background(plotter, options.background)
            yield plotter
            image = Image.fromarray(exposed(plotter, transparent=transparent))
            if options.scale_bar:
                _draw_scale_bars(image, plotter, panels, bool(caption))
            write_caption(image, caption)
            draw_key(image, key, KEY_LEFT)
            (image if options.colours is None else image.quantize(options.colours)).save(temporary)
        finally:
            plotter.close()


def _draw_scale_bars(
    image: Picture, plotter: pyvista.Plotter, panels: tuple[Viewport, ...], has_caption: bool
) -> None:
    """Draw a scale bar into each panel whose scale differs from that of the panels before it."""
    drawn: list[float] = []
    for number, (renderer, (left, low, right, high)) in enumerate(zip(plotter.renderers, panels, strict=True)):
        if renderer not in seen_by:
            continue
        pixels = 1.0 / seen_by[renderer].pixel(round((high - low) * image.height))
        if any(np.isclose(pixels, other, rtol=0.01) for other in drawn):
            continue
        drawn.append(pixels)
        above = [top for start, bottom, _, top in panels[number + 1 :] if start <= left + 0.03 and bottom <= low + 0.03]
        bottom = max([low, *above]) * image.height
        width = (right - left) * image.width
        draw_scale_bar(image, (left * image.width, bottom), width, pixels, lifted=has_caption and low < 0.05)


def _set_background(plotter: pyvista.Plotter, background: str | None) -> None:
    if background is None:
        plotter.set_background("#d9d4ca", top=PAPER)
    elif background != TRANSPARENT:
        plotter.set_background(colour_text(parse_colour(background)))


def add_body(plotter: pyvista.Plotter, body: Mesh) -> None:
    """Add a body as a smooth pale surface."""
    add_faces(plotter, body, np.tile(np.array((198, 184, 170), dtype=np.uint8), (body.face_count, 1)))


def add_tubes(plotter: pyvista.Plotter, tubes: TubeMesh, colours: NDArray[np.uint8]) -> None:
    """Add tubes with one sRGB colour per vertex, shape (V, 3)."""
    import pyvista

    surface = pyvista.PolyData.from_regular_faces(tubes.vertices.astype(np.float32), tubes.triangles)
    surface.point_data["Normals"] = tubes.normals.astype(np.float32)
    surface.point_data.active_normals_name = "Normals"
    plotter.add_mesh(surface, scalars=colours, rgb=True, smooth_shading=True, culling="back")


def add_threads(
    plotter: pyvista.Plotter, points: FloatArray, start: IntArray, colours: NDArray[np.uint8], width: float
) -> None:  # fmt: skip
    """Add fibres as lines.

    Args:
        plotter: the plotter.
        points: points of all lines in turn [cm], shape (P, 3).
        start: first point of each line, and P at the end, shape (n + 1,).
        colours: sRGB colour of each point, shape (P, 3).
        width: width of the lines [pixels of the window].
    """
    import pyvista

    lines = np.insert(np.arange(len(points)), start[:-1], np.diff(start))
    threads = pyvista.PolyData(points.astype(np.float32), lines=lines)
    plotter.add_mesh(threads, scalars=colours, rgb=True, line_width=width)


def dim_colours(colours: NDArray[np.uint8], shade: float = 1.0) -> NDArray[np.uint8]:
    """Return sRGB colours as yarn reflects them: black yarn is not quite black, and white yarn not quite white.

    Args:
        colours: the colours of the yarn.
        shade: factor of the reflected light.
    """
    light = shade * (DARKEST + (PALEST - DARKEST) * linear_colour(colours / 255.0))
    return np.round(255.0 * srgb_colour(light)).astype(np.uint8)


def look(plotter: pyvista.Plotter, camera: Camera, sheen: float = 0.0) -> None:
    """Set the camera of the active panel, whose surfaces shine by ``sheen``; the lights stand beside the camera."""
    plotter.camera.position = camera.position
    plotter.camera.focal_point = camera.focus
    plotter.camera.up = camera.up
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.reset_camera_clipping_range()
    seen_by[plotter.renderer] = Seen(camera, sheen)


def shade_hollows(plotter: pyvista.Plotter, reach: float, options: PictureOptions) -> None:
    """Say how surfaces hide light from each other, which makes loops distinguishable, if the options ask for it.

    Args:
        plotter: the plotter; its active panel is changed.
        reach: distance up to which surfaces hide the sky from each other [cm]; shadows of the key light are longer.
        options: options of the picture.
    """
    seen_by[plotter.renderer].reach = reach
    seen_by[plotter.renderer].shaded = options.occlusion
