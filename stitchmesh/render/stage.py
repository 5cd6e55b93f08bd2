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
from stitchmesh.mesh.tube_mesh import TubeMesh
from stitchmesh.render.camera import VIEW_ANGLE, Camera
from stitchmesh.render.gl_probe import check_display
from stitchmesh.render.lettering import Colour, draw_key, write_caption

if TYPE_CHECKING:
    import pyvista

PAPER = "#efece6"
"""Background colour at the top of a picture."""
SHADE = "#d9d4ca"
"""Background colour at the bottom of a picture."""
DUSK = "#57514b"
"""Background colour of a close-up."""

Viewport = tuple[float, float, float, float]
"""Left, lower, right and upper border of a panel, as parts of the picture."""

WHOLE: Viewport = (0.0, 0.0, 1.0, 1.0)
"""The panel that covers the whole picture."""

LIGHTS = (((-0.55, 0.75, 0.9), 1.15), ((0.9, 0.1, 0.6), 0.42), ((0.1, -0.6, 0.7), 0.2))
"""Direction (to the right, upwards and to the camera) and intensity of each light.

The key light is at the upper left, the fill light at the right, and a weak light below."""

KEY_LEFT = 0.8
"""Left border of a legend of colours, divided by the width of the picture."""
OVERSIZE = 2
"""Width and height of the window divided by those of the picture; a pixel is the mean of a block of the window."""
HOLLOW_SAMPLES = 16
"""Samples around each pixel for ambient occlusion; a blur removes the noise of the small number of samples."""


@contextmanager
def picture(
    path: FilePath,
    size: tuple[int, int],
    *,
    panels: tuple[Viewport, ...] = (WHOLE,),
    caption: str = "",
    key: Sequence[tuple[str, Colour]] = (),
) -> Iterator[pyvista.Plotter]:
    """Open an off-screen plotter of one or more panels; the picture is written when the block ends without an error.

    Args:
        path: a ``.png`` file; missing folders are created.
        size: width and height [pixels].
        panels: borders of each panel; a panel covers the panels before it.
        caption: line of text in the lower left corner.
        key: names and colours of a legend, which is drawn to the right of ``KEY_LEFT``.

    Raises:
        DisplayError: this machine cannot draw pictures.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    suffix_of(path, (".png",))
    check_display()
    import pyvista
    from PIL import Image

    window = [OVERSIZE * size[0], OVERSIZE * size[1]]
    with atomic_path(path) as temporary:
        plotter = pyvista.Plotter(
            off_screen=True, window_size=window, shape=(1, len(panels)), border=False, lighting="none"
        )
        for renderer, viewport in zip(plotter.renderers, panels, strict=True):
            renderer.viewport = viewport
        try:
            plotter.set_background(SHADE, top=PAPER)
            yield plotter
            image = Image.fromarray(plotter.screenshot(return_img=True)).reduce(OVERSIZE)
            write_caption(image, caption)
            draw_key(image, key, KEY_LEFT)
            image.save(temporary)
        finally:
            plotter.close()


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


def shade_hollows(plotter: pyvista.Plotter, reach: float) -> None:
    """Add ambient occlusion, which darkens hollows and makes loops distinguishable.

    Args:
        plotter: the plotter; its active panel is changed.
        reach: distance up to which surfaces occlude each other [cm].
    """
    plotter.enable_ssao(radius=reach, bias=0.05 * reach, kernel_size=HOLLOW_SAMPLES, blur=True)
