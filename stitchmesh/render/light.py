# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The light of all pictures: how much of a key light and of a sky each pixel sees.

A picture is a relief: each pixel has a height towards the camera. A place sees the part of the sky above its tangent
plane that no higher pixel hides (Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion"), and the part of
the key light, a disc, that lies above the highest pixel on the way to it. All pixels search in the same directions and
at the same distances, so that no noise has to be blurred away and the same scene gives the same picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]
"""A value of each pixel, shape (rows, columns), the highest row first."""

KEY = np.array([-0.55, 0.6, 0.8]) / np.linalg.norm([-0.55, 0.6, 0.8])
"""Unit direction to the key light: to the right, upwards and to the camera. It is at the upper left."""
KEY_SOFTNESS = 0.45
"""Half the width of the key light, as a difference of the slopes of rays; it makes the edges of shadows soft."""
FILL = np.array([0.75, 0.25, 0.6]) / np.linalg.norm([0.75, 0.25, 0.6])
"""Unit direction to the fill light, which throws no shadow: to the right of the camera."""
TO_CAMERA = np.array([0.0, 0.0, 1.0])
"""Unit direction to the camera."""
KEY_POWER, SKY_POWER, FILL_POWER, FRONT_POWER = 0.47, 0.34, 0.07, 0.18
"""Powers of the key light, of the even sky, of the fill light and of the part of the sky around the camera. White yarn
reflects 0.94 of their sum, 1.06, so that no yarn is brighter than white paper."""
SHINE_POWER, SHINE_ROUGH, SHINE_SHARP = 0.6, 6.0, 40.0
"""Power of the shine of a surface of sheen 1 in the key light, and the exponent without sheen and what sheen 1 adds."""
SKY_DIRECTIONS = 12
"""Number of directions around a pixel in which the sky is searched."""
KEY_TURNS = (-0.3, 0.0, 0.3)
"""Angles from the direction of the key light to the directions in which it is searched [radians]."""
STEPS = 9
"""Number of distances at which a direction is searched, from one pixel to the reach; each is a constant factor longer
than the one before."""
KEY_REACH, KEY_STEPS = 4.0, 12
"""Length of the shadows of the key light over the reach, and number of distances at which they are searched."""
HIGHEST = 1.5
"""Largest height of what hides light, over the reach; another part of a garment in front would else be outlined."""
STEEPEST = 2.5
"""Largest slope of a tangent plane; between the sides of a narrow gap there are not enough pixels to tell it."""
GROUND_LEAST = 0.3
"""Light on ground that sees neither the key light nor the sky, such as below a hole of a fabric."""
HIDDEN = 0.85
"""Part of the sky that a deep hollow loses; the rest is light that yarn scatters."""


@dataclass(frozen=True, eq=False)
class Relief:
    """The heights of a picture."""

    height: Image
    """Height of the surface at each pixel towards the camera [pixels]."""
    reach: float
    """Distance up to which surfaces hide light from each other [pixels]."""


def key_seen(relief: Relief) -> Image:
    """Return the part of the key light above the tangent plane that each pixel sees, from 0 to 1."""
    ray = float(KEY[2] / np.hypot(KEY[0], KEY[1]))
    slopes = _slopes(relief.height)
    seen = np.zeros_like(relief.height)
    for azimuth in np.arctan2(KEY[1], KEY[0]) + np.array(KEY_TURNS):
        tangent = _along(slopes, np.cos(azimuth), np.sin(azimuth))
        distances = _distances(KEY_REACH * relief.reach, KEY_STEPS)
        highest = tangent + _highest(relief, slopes, azimuth, dict.fromkeys(distances, 1.0))
        whole = _part_above(tangent, ray)
        seen += np.where(whole > 0.01, _part_above(highest, ray) / np.maximum(whole, 0.01), 1.0)
    return np.asarray(seen / np.float32(len(KEY_TURNS)), dtype=np.float32)


def _part_above(horizon: Image, slope: float) -> Image:
    """Return the part of the key light above a horizon, for the slope of the ray to the middle of the light."""
    part = np.clip((slope - horizon) / np.float32(2.0 * KEY_SOFTNESS) + np.float32(0.5), 0.0, 1.0)
    return np.asarray(part * part * (3.0 - 2.0 * part), dtype=np.float32)


def sky_seen(relief: Relief) -> Image:
    """Return the part of the sky above the tangent plane that each pixel sees, from 1 - ``HIDDEN`` to 1."""
    slopes = _slopes(relief.height)
    # Far surfaces hide less.
    weights = {step: 1.0 - (step / (1.25 * relief.reach)) ** 2 for step in _distances(relief.reach, STEPS)}
    hidden = np.zeros_like(relief.height)
    for azimuth in 2.0 * np.pi * np.arange(SKY_DIRECTIONS) / SKY_DIRECTIONS:
        tangent = _along(slopes, np.cos(azimuth), np.sin(azimuth))
        hidden += _sine(tangent + _highest(relief, slopes, azimuth, weights)) - _sine(tangent)
    hidden *= np.float32(HIDDEN / SKY_DIRECTIONS)
    return np.asarray(1.0 - np.minimum(hidden, np.float32(HIDDEN)), dtype=np.float32)


def _distances(reach: float, steps: int) -> list[int]:
    """Return different whole distances from 1 to about ``reach`` [pixels]."""
    return sorted({max(1, round(distance)) for distance in np.geomspace(1.0, max(reach, 1.0), steps).tolist()})


def _highest(relief: Relief, slopes: tuple[Image, Image], azimuth: float, weights: dict[int, float]) -> Image:
    """Return how much steeper than the tangent plane the way to the highest pixel in a direction is, at least 0.

    What is far in front hides no more than what is ``HIGHEST`` reaches higher.

    Args:
        relief: the heights.
        slopes: slopes of the tangent plane to the right and upwards.
        azimuth: the direction [radians].
        weights: the distances at which pixels are searched, each with a factor of what they hide.
    """
    rows, columns = relief.height.shape
    highest = np.zeros_like(relief.height)
    for distance, weight in weights.items():
        # The rounding error of a cosine of one half must not decide between two pixels.
        right, up = (round(round(distance * float(part), 9)) for part in (np.cos(azimuth), np.sin(azimuth)))
        if abs(up) >= rows or abs(right) >= columns:
            continue
        place = (slice(max(up, 0), rows + min(up, 0)), slice(max(-right, 0), columns - max(right, 0)))
        there = (slice(max(-up, 0), rows - max(up, 0)), slice(max(right, 0), columns + min(right, 0)))
        rise = relief.height[there] - relief.height[place]
        np.minimum(rise, np.float32(HIGHEST * relief.reach), out=rise)
        rise -= _along((slopes[0][place], slopes[1][place]), right, up)
        rise *= np.float32(weight / np.hypot(right, up))
        np.maximum(highest[place], rise, out=highest[place])
    return highest


def _along(slopes: tuple[Image, Image], right: float, up: float) -> Image:
    """Return how much a tangent plane rises on a way."""
    return np.asarray(np.float32(right) * slopes[0] + np.float32(up) * slopes[1])


def _sine(slope: Image) -> Image:
    """Return the sine of the angle of a slope."""
    return slope / np.sqrt(1.0 + slope * slope)


def _slopes(height: Image) -> tuple[Image, Image]:
    """Return the slopes of the surface to the right and upwards: of the flatter side, which is the same surface."""
    # Beyond the border of the picture the surface goes on straight.
    padded = np.pad(height, 1, "reflect", reflect_type="odd")
    across, down = np.diff(padded[1:-1], axis=1), np.diff(padded[:, 1:-1], axis=0)
    left, right, above, below = across[:, :-1], across[:, 1:], down[:-1], down[1:]
    across = np.where(np.abs(right) < np.abs(left), right, left)
    up = -np.where(np.abs(below) < np.abs(above), below, above)
    return np.clip(across, -STEEPEST, STEEPEST), np.clip(up, -STEEPEST, STEEPEST)


def surface_light(facing: NDArray[np.uint8], key: Image, sky: Image, sheen: float = 0.0) -> Image:
    """Return the light on surfaces, from 0 to 1, and more where they shine.

    The shine is that of Blinn (1977), a power of the cosine of the angle to the direction midway between the key light
    and the camera. Its colour is that of the surface, as of light that comes out of fibres.

    Args:
        facing: cosines of the angles to ``KEY``, to the camera and to ``FILL``, 0 to 255, shape (rows, columns, 3).
        key: the part of the key light that each pixel sees.
        sky: the part of the sky that each pixel sees.
        sheen: how much the surfaces shine, from 0 to 1.
    """
    to_key, to_camera, to_fill = np.moveaxis(facing.astype(np.float32) / np.float32(255.0), 2, 0)
    from_sky = SKY_POWER + FRONT_POWER * to_camera + FILL_POWER * to_fill
    midway = np.minimum((to_key + to_camera) / np.float32(np.linalg.norm(KEY + TO_CAMERA)), np.float32(1.0))
    shine = np.float32(SHINE_POWER * sheen) * midway ** np.float32(SHINE_ROUGH + SHINE_SHARP * sheen)
    return np.asarray((KEY_POWER * to_key + shine) * key + from_sky * sky, dtype=np.float32)


def ground_light(key: Image, sky: Image) -> Image:
    """Return the light on the ground over that of ground which sees all lights; the ground is never black."""
    seen = KEY_POWER * key + (1.0 - KEY_POWER) * sky
    return np.asarray(GROUND_LEAST + (1.0 - GROUND_LEAST) * seen, dtype=np.float32)
