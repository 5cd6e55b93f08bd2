# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Takes the picture of a scene: its colours, the directions and the heights of its surfaces, and the light on them.

The renderer draws the scene twice. The first time it draws the colours without any light. The second time it draws
white surfaces under three lights of the pure colours red, green and blue, so that the channels of each pixel say how
its surface faces the three lights of ``light.py``; lines and arrows are left out, because they lie on a surface.

Fibres are thinner than a pixel, so they are no surfaces that hide light: they are drawn once more over the surfaces,
half transparent. On a surface they have its light, and light of their own where they stand off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.palette import linear_colour, srgb_colour
from stitchmesh.render.camera import VIEW_ANGLE, Camera
from stitchmesh.render.ground import Rays, ground_of, ground_shadow
from stitchmesh.render.light import FILL, KEY, TO_CAMERA, Image, Relief, ground_light, key_seen, sky_seen, surface_light

if TYPE_CHECKING:
    import pyvista

OVERSIZE = 2
"""Width and height of the window over those of the picture; a pixel is the mean of a block of pixels of the window."""
CONTACT = 0.03
"""Distance up to which surfaces hide light from each other if the caller names none, over the height of the panel."""
NEAR_FIELD = (3, 60)
"""Bounds of the distance up to which surfaces hide light from each other [pixels]."""
LEVELS = linear_colour(np.arange(256) / 255.0).astype(np.float32)
"""Linear light of each level of sRGB."""
STEPS_OF_LIGHT = 4096
"""Number of levels of linear light that are told apart when they become sRGB; the darkest step is below one level."""
FIBRE_OPACITY, FIBRE_LIGHT, STANDS_OFF = 0.6, 0.95, 4.0
"""Part of a pixel of the window that a fibre covers, the light on a fibre that stands off, and the distance from the
surface behind it from which on it has this light [pixels of the picture]."""
DEVELOPED = np.round(255.0 * srgb_colour((np.arange(STEPS_OF_LIGHT) / (STEPS_OF_LIGHT - 1.0)) ** 2)).astype(np.uint8)
"""sRGB level of the square root of linear light, in steps."""

PanelPixels = tuple[slice, slice]
"""Rows and columns of a panel in the window."""


@dataclass
class Seen:
    """What a panel shows."""

    camera: Camera
    """The camera of the panel."""
    sheen: float = 0.0
    """How much the surfaces shine, from 0 to 1."""
    reach: float | None = None
    """Distance up to which surfaces hide the sky from each other [cm]; None for ``CONTACT``."""
    shaded: bool = True
    """Whether surfaces hide light from each other."""

    def pixel(self, rows: int) -> float:
        """Return the size of a pixel at the focus [cm], for a panel of some rows of pixels."""
        return 2.0 * HALF * float(np.linalg.norm(self.camera.position - self.camera.focus)) / rows


@dataclass(frozen=True, eq=False)
class WithFibres:
    """A window in which fibres are drawn too."""

    colours: NDArray[np.uint8]
    """Colours without light (sRGB), shape (rows, columns, 3 or 4)."""
    depths: Image
    """Depths from 0 to 1."""


@dataclass(frozen=True, eq=False)
class Layer:
    """What lies over one another in the pixels of a window."""

    colours: NDArray[np.uint8]
    """Colours without light (sRGB), shape (rows, columns, 3 or 4)."""
    light: Image
    """Light, from 0 to 1."""
    part: Image
    """Part of each pixel that the layer covers."""


HALF = float(np.tan(np.radians(VIEW_ANGLE / 2)))
"""Half the height of a picture over its distance."""
seen_by: WeakKeyDictionary[pyvista.Renderer, Seen] = WeakKeyDictionary()
"""What the panels of the pictures show that are being drawn."""


def exposed(plotter: pyvista.Plotter, *, transparent: bool) -> NDArray[np.uint8]:
    """Return the picture of a scene (sRGB), shape (rows, columns, 3), or 4 with a transparent background."""
    over = _fibres(plotter, transparent=transparent)
    colours = _colours(plotter, transparent=transparent)
    facing, depths = _facing(plotter)
    light, off = np.ones(colours.shape[:2], dtype=np.float32), np.zeros(colours.shape[:2], dtype=np.float32)
    covered = np.zeros(light.shape, dtype=np.bool_)
    for renderer in reversed(plotter.renderers):
        panel = panel_pixels(renderer, len(colours))
        if renderer in seen_by:
            own = _light_on(renderer, seen_by[renderer], facing[panel], depths[panel])
            np.copyto(light[panel], own, where=~covered[panel])
            if over is not None:
                height = distances(renderer, depths[panel]) - distances(renderer, over.depths[panel])
                pixel = OVERSIZE * seen_by[renderer].pixel(len(height))
                np.copyto(off[panel], height / np.float32(pixel), where=~covered[panel])
        depths[panel], covered[panel] = 1.0, True  # The panels before this one see nothing there.
    if over is None:
        return _developed([Layer(colours, light, np.ones_like(light))])
    part = np.float32(FIBRE_OPACITY) * (off > 0.0)
    stands = np.clip(off / np.float32(STANDS_OFF), 0.0, 1.0)
    around = light + stands * np.maximum(np.float32(FIBRE_LIGHT) - light, 0.0)
    return _developed([Layer(colours, light, np.float32(1.0) - part), Layer(over.colours, around, part)])


def panel_pixels(renderer: pyvista.Renderer, rows: int) -> PanelPixels:
    """Return the pixels of a panel in a window of some rows."""
    left, low = renderer.GetOrigin()
    width, height = renderer.GetSize()
    return slice(rows - low - height, rows - low), slice(left, left + width)


def _fibres(plotter: pyvista.Plotter, *, transparent: bool) -> WithFibres | None:
    """Draw the scene with its fibres, and hide them; None without fibres."""
    fibres = [actor for renderer in plotter.renderers for actor in _surfaces(renderer) if actor.mapper.dataset.n_lines]
    if not fibres:
        return None
    drawn = WithFibres(_colours(plotter, transparent=transparent), _depths(plotter))
    for actor in fibres:
        actor.SetVisibility(False)
    return drawn


def _colours(plotter: pyvista.Plotter, *, transparent: bool) -> NDArray[np.uint8]:
    """Draw the scene without light."""
    for renderer in plotter.renderers:
        for actor in _surfaces(renderer):
            actor.prop.ambient, actor.prop.diffuse, actor.prop.specular = 1.0, 0.0, 0.0
    plotter.image_transparent_background = transparent
    return np.asarray(plotter.screenshot(return_img=True, transparent_background=transparent))


def _facing(plotter: pyvista.Plotter) -> tuple[NDArray[np.uint8], Image]:
    """Draw white surfaces under the three lights, and return the picture, and the depths of the window from 0 to 1."""
    import pyvista

    for renderer in plotter.renderers:
        for actor in renderer.GetActors():
            actor.SetVisibility(actor.GetVisibility() and actor.prop.lighting)
        for actor in _surfaces(renderer):
            actor.mapper.scalar_visibility = False
            actor.prop.color, actor.prop.ambient, actor.prop.diffuse = "white", 0.0, 1.0
        if renderer in seen_by:
            camera = seen_by[renderer].camera
            for direction, colour in zip((KEY, TO_CAMERA, FILL), np.eye(3).tolist(), strict=True):
                place = camera.focus + direction @ camera.axes
                renderer.add_light(
                    pyvista.Light(position=place, focal_point=camera.focus, color=colour, light_type="scene light")
                )
    depths = _depths(plotter)
    return np.asarray(plotter.screenshot(return_img=True))[..., :3], depths


def _depths(plotter: pyvista.Plotter) -> Image:
    """Draw the scene, and return the depths of the window from 0 to 1."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkFloatArray

    plotter.render_window.Render()
    columns, rows = plotter.window_size
    depths = vtkFloatArray()
    plotter.render_window.GetZbufferData(0, 0, columns - 1, rows - 1, depths)
    heights: Image = vtk_to_numpy(depths).reshape(rows, columns)[::-1].copy()
    return heights


def _surfaces(renderer: pyvista.Renderer) -> list[pyvista.Actor]:
    """Return the objects on which light falls; lines and arrows have their colours without it."""
    return [actor for actor in renderer.GetActors() if actor.prop.lighting]


def _light_on(renderer: pyvista.Renderer, seen: Seen, facing: NDArray[np.uint8], depths: Image) -> Image:
    """Return the light on each pixel of a panel of the window, from 0 to 1."""
    is_object = depths < 1.0
    distance = distances(renderer, depths)
    if not seen.shaded:
        unhidden = np.ones_like(distance)
        return np.where(is_object, surface_light(facing, unhidden, unhidden, seen.sheen), unhidden)
    rays = _rays(renderer, seen.camera, *distance.shape)
    farthest = float(np.max(distance, where=is_object, initial=renderer.GetActiveCamera().GetClippingRange()[0]))
    ground = ground_of(seen.camera, farthest)
    shadow = ground_shadow(ground, rays, distance, is_object)
    np.copyto(distance, ground.distance(rays), where=~is_object)
    # What a pixel sees changes little within it, so that one search serves its block of pixels of the window.
    pixel = seen.pixel(len(depths))
    height = distance[::OVERSIZE, ::OVERSIZE] / np.float32(-OVERSIZE * pixel)
    reach = CONTACT * len(height) if seen.reach is None else seen.reach / (OVERSIZE * pixel)
    relief = Relief(height, _bounded(reach, height))
    key, sky = _enlarged((key_seen(relief), sky_seen(relief)), distance)
    # Far behind an object the floor is no relief, but a wall touches it.
    on_ground = shadow if seen.camera.floor is not None else np.minimum(ground_light(key, sky), shadow)
    return np.where(is_object, surface_light(facing, key, sky, seen.sheen), on_ground)


def distances(renderer: pyvista.Renderer, depths: Image) -> Image:
    """Return the distances of pixels from the camera of a panel, along its axis [cm], for their depths from 0 to 1."""
    near, far = renderer.GetActiveCamera().GetClippingRange()
    return np.asarray(near * far / (far - depths * (far - near)), dtype=np.float32)


def _bounded(reach: float, surface: Image) -> float:
    """Return a reach [pixels] that is neither shorter than a few pixels nor longer than the picture allows."""
    return max(1.0, min(float(np.clip(reach, *NEAR_FIELD)), min(surface.shape) / 8.0))


def _rays(renderer: pyvista.Renderer, camera: Camera, rows: int, columns: int) -> Rays:
    """Return the rays through the pixels of a panel of the window."""
    right, up = renderer.GetActiveCamera().GetWindowCenter()
    across = ((2.0 * np.arange(columns) + 1.0) / columns - 1.0 + right) * HALF * columns / rows
    upwards = (1.0 - (2.0 * np.arange(rows) + 1.0) / rows + up) * HALF
    return Rays(camera, across, upwards)


def _enlarged(seen: Sequence[Image], distance: Image) -> list[Image]:
    """Return what blocks of pixels of the window see at each pixel, of which the first one of a block has been asked.

    A pixel near the border of a surface takes the value of the neighbouring block if that lies on its own surface.
    """
    whole = [np.empty_like(distance) for _ in seen]
    first = np.pad(distance[::OVERSIZE, ::OVERSIZE], ((0, 1), (0, 1)), "edge")
    padded = [np.pad(each, ((0, 1), (0, 1)), "edge") for each in seen]
    for down, right in np.ndindex(OVERSIZE, OVERSIZE):
        own = distance[down::OVERSIZE, right::OVERSIZE]
        at = [each[: own.shape[0], : own.shape[1]] for each in (first, *padded)]
        beside = [each[down:, right:][: own.shape[0], : own.shape[1]] for each in (first, *padded)]
        nearer = np.abs(beside[0] - own) < np.abs(at[0] - own)
        for target, here, there in zip(whole, at[1:], beside[1:], strict=True):
            target[down::OVERSIZE, right::OVERSIZE] = np.where(nearer, there, here)
    return whole


def _developed(layers: Sequence[Layer]) -> NDArray[np.uint8]:
    """Return the mean light of each block of pixels of the window as sRGB."""
    rows, columns, channels = layers[0].colours.shape
    shape = (rows // OVERSIZE, OVERSIZE, columns // OVERSIZE, OVERSIZE)
    picture = np.empty((rows // OVERSIZE, columns // OVERSIZE, channels), dtype=np.uint8)
    parts = [layer.part * (layer.colours[..., 3] if channels == 4 else np.float32(255.0)) for layer in layers]
    total = sum(part.reshape(shape).mean(axis=(1, 3)) for part in parts)
    lights = [part * layer.light for part, layer in zip(parts, layers, strict=True)]
    for channel in range(3):
        shown = sum(LEVELS[layer.colours[..., channel]] * light for layer, light in zip(layers, lights, strict=True))
        mean = np.asarray(shown).reshape(shape).mean(axis=(1, 3)) / np.maximum(total, 1.0)
        steps = np.sqrt(np.clip(mean, 0.0, 1.0)) * np.float32(STEPS_OF_LIGHT - 1.0)
        picture[..., channel] = DEVELOPED[np.rint(steps).astype(np.int32)]
    if channels == 4:
        picture[..., 3] = np.rint(total)
    return picture
