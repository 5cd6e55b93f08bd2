# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stage on which pictures are taken: off-screen window, light, shadow in the hollows, and the file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.mesh import FloatArray
from stitchmesh.viewer.camera import VIEW_ANGLE, Camera
from stitchmesh.viewer.gl_probe import check_display
from stitchmesh.viewer.tubes import Tubes

if TYPE_CHECKING:
    import pyvista

PAPER = "#efece6"
SHADE = "#d9d4ca"
INK = "#3a3632"

LIGHTS = (((-0.55, 0.75, 0.9), 0.78), ((0.9, 0.1, 0.6), 0.3), ((0.1, -0.6, 0.7), 0.12))
"""Key from the upper left, fill from the right, a little from below: direction to the right, up and to the camera,
and intensity."""


@contextmanager
def picture(path: FilePath, size: tuple[int, int], *, panels: tuple[float, ...] = (1.0,)) -> Iterator[pyvista.Plotter]:
    """An off-screen plotter of one or more panels side by side whose picture is written when the block ends well.

    Args:
        path: a ``.png`` file; missing folders are made.
        size: width and height [pixels].
        panels: relative width of each panel.

    Raises:
        DisplayError: this machine cannot draw.
        FileError: the suffix is not ``.png``, or the file cannot be written.
    """
    suffix_of(path, (".png",))
    check_display()
    import pyvista

    with atomic_path(path) as temporary:
        plotter = pyvista.Plotter(off_screen=True, window_size=list(size), shape=(1, len(panels)), border=False)
        bounds = np.concatenate([[0.0], np.cumsum(panels)]) / sum(panels)
        for panel, (left, right) in enumerate(pairwise(bounds.tolist())):
            plotter.renderers[panel].viewport = (left, 0.0, right, 1.0)
        try:
            plotter.set_background(SHADE, top=PAPER)
            yield plotter
            plotter.screenshot(str(temporary))
        finally:
            plotter.close()


def add_tubes(plotter: pyvista.Plotter, tubes: Tubes, colours: NDArray[np.uint8]) -> None:
    """Add tubes with one sRGB colour for each of their vertices, shape (V, 3)."""
    import pyvista

    surface = pyvista.PolyData.from_regular_faces(tubes.vertices.astype(np.float32), tubes.triangles)
    surface.point_data["Normals"] = tubes.normals.astype(np.float32)
    surface.point_data.active_normals_name = "Normals"
    plotter.add_mesh(
        surface, scalars=colours, rgb=True, smooth_shading=True, culling="back", ambient=0.18, diffuse=0.95,
        specular=0.08, specular_power=6,
    )  # fmt: skip


def look(plotter: pyvista.Plotter, camera: Camera) -> None:
    """Point the active panel's camera and hang the lights around it."""
    import pyvista

    plotter.camera.position = camera.position
    plotter.camera.focal_point = camera.focus
    plotter.camera.up = camera.up
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.reset_camera_clipping_range()
    plotter.renderer.remove_all_lights()
    depth = camera.position - camera.focus
    axes = np.stack([camera.side, camera.up, depth / np.linalg.norm(depth)])
    for direction, intensity in LIGHTS:
        place = camera.focus + np.array(direction) @ axes
        plotter.add_light(
            pyvista.Light(position=place, focal_point=camera.focus, intensity=intensity, light_type="scene light")
        )


def shade_hollows(plotter: pyvista.Plotter, reach: float) -> None:
    """Darken places that are hemmed in within a distance [cm]: what makes loops stand out from each other."""
    plotter.enable_ssao(radius=reach, bias=0.05 * reach, kernel_size=96, blur=True)


def bounding_corners(points: FloatArray) -> FloatArray:
    """The eight corners of the box around points, shape (8, 3)."""
    low, high = points.min(axis=0), points.max(axis=0)
    choice = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
    return np.where(choice == 1, high, low)
