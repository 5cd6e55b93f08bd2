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
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.palette import colour_text, parse_colour
from stitchmesh.mesh.tube_mesh import TubeMesh
from stitchmesh.render.camera import VIEW_ANGLE, Camera
from stitchmesh.render.gl_probe import check_display
from stitchmesh.render.lettering import Colour, draw_key, write_caption
from stitchmesh.render.options import TRANSPARENT, PictureOptions
from stitchmesh.render.plots.plot_file import import_matplotlib
from stitchmesh.render.surface import add_faces

if TYPE_CHECKING:
    import pyvista

PAPER = "#efece6"
"""Background colour at the top of a picture."""
DUSK = "#57514b"
"""Background colour of a close-up."""

Viewport = tuple[float, float, float, float]
"""Left, lower, right and upper border of a panel, as parts of the picture."""

WHOLE: Viewport = (0.0, 0.0, 1.0, 1.0)
"""The panel that covers the whole picture."""

LIGHTS = (((-0.55, 0.75, 0.9), 1.15), ((0.9, 0.1, 0.6), 0.42), ((0.1, -0.6, 0.7), 0.2))
"""Direction (to the right, upwards and to the camera) and intensity of each light.

The key light is at the upper left, the fill light at the right, and a weak light below."""

DIMMED = 210 / 255
"""Factor of the sRGB colours of yarn; it is below 1, because the total intensity of the lights is above 1."""
KEY_LEFT = 0.8
"""Left border of a legend of colours, divided by the width of the picture."""
OVERSIZE = 2
"""Width and height of the window over those of the picture; a pixel is the mean of a block of pixels of the window."""
DEPTH_ROUNDING = 2.0**-10
"""Rounding of places over their distance from the camera: VTK keeps them in half precision for ambient occlusion. A
smaller bias would draw the steps of the rounded depth on smooth surfaces, like the contour lines of a map."""


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
        for renderer, viewport in zip(plotter.renderers, panels, strict=True):
            renderer.viewport = viewport
        try:
            _set_background(plotter, options.background)
            yield plotter
            shot = plotter.screenshot(return_img=True, transparent_background=transparent)
            image = Image.fromarray(shot).reduce(OVERSIZE)
            write_caption(image, caption)
            draw_key(image, key, KEY_LEFT)
            (image if options.colours is None else image.quantize(options.colours)).save(temporary, optimize=True)
        finally:
            plotter.close()


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
    plotter.add_mesh(
        surface, scalars=colours, rgb=True, smooth_shading=True, culling="back", ambient=0.16, diffuse=1.0,
        specular=0.08, specular_power=6,
    )  # fmt: skip


def dim_colours(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return sRGB colours that all lights of the scene together do not make brighter than the yarn."""
    return np.round(DIMMED * colours).astype(np.uint8)


def look(plotter: pyvista.Plotter, camera: Camera) -> None:
    """Set the camera of the active panel, and place the lights relative to the camera."""
    import pyvista

    plotter.camera.position = camera.position
    plotter.camera.focal_point = camera.focus
    plotter.camera.up = camera.up
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.reset_camera_clipping_range()
    depth = camera.position - camera.focus
    axes = np.stack([camera.side, camera.up, depth / np.linalg.norm(depth)])
    for direction, intensity in LIGHTS:
        place = camera.focus + np.array(direction) @ axes
        light = pyvista.Light(position=place, focal_point=camera.focus, intensity=intensity, light_type="scene light")
        plotter.add_light(light, only_active=True)


def shade_hollows(plotter: pyvista.Plotter, reach: float, options: PictureOptions) -> None:
    """Add ambient occlusion, which darkens hollows and makes loops distinguishable, if the options ask for it.

    Args:
        plotter: the plotter; its active panel is changed.
        reach: distance up to which surfaces occlude each other [cm]. It is larger where the camera is so far away that
            rounding moves the surfaces by more.
        options: options of the picture.
    """
    if options.occlusion:
        rounding = DEPTH_ROUNDING * float(plotter.camera.distance)
        reach, bias = max(reach, 4.0 * rounding), max(0.05 * reach, rounding)
        # The blur removes the noise of few samples.
        plotter.enable_ssao(radius=reach, bias=bias, kernel_size=16, blur=True)
