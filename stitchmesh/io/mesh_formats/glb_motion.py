# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""glTF meshes that move (``.glb``, ``.gltf``): the first animation of a file, at evenly spaced times.

A channel of an animation gives the translation, the rotation or the scale of a node, or the weights of the morph
targets of its mesh, at the times of keys. Between two keys numbers are interpolated linearly, rotations along the
shorter great arc, by cubic splines, or not at all; before the first key and after the last one nothing changes (glTF
2.0 specification, appendix C). The nodes in the pose of a time then place the points, as for a mesh that does not move
(``glb``).
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from os import fspath

import msgspec
import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, check_one_mesh, check_points
from stitchmesh.io.mesh_formats.glb import Placed, placed_surfaces, placed_triangles, posed_points
from stitchmesh.io.mesh_formats.gltf_file import (
    Animation,
    Channel,
    GltfFile,
    GltfHead,
    item_of,
    numbers_of,
    read_gltf,
    refusing_damage,
)
from stitchmesh.mesh import FloatArray

logger = logging.getLogger(__name__)

KINDS = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3", "weights": "SCALAR"}
"""Kinds of the numbers of what a channel changes."""
MOST_FRAMES = 20_000
"""Largest number of frames: eleven minutes at 30 frames per second."""
LARGEST_MOTION = 2**32
"""Largest size of the positions in all frames [bytes]."""


@dataclass(frozen=True, eq=False)
class _Track:
    """What a channel makes of a node at each frame."""

    node: int
    path: str
    values: FloatArray
    """Shape (frames, columns)."""


def read_moving_glb(path: FilePath, frames_per_second: float) -> tuple[list[list[int]], FloatArray, FloatArray]:
    """Read the only mesh of a file with its first animation.

    Args:
        path: a ``.glb`` or ``.gltf`` file.
        frames_per_second: frames for each second, from the first key of the animation to the last one.

    Returns:
        The points of each triangle, the times of the frames [s], shape (K,), and the positions [m] of the points that
        belong to triangles, shape (K, P, 3).

    Raises:
        FileError: the file cannot be read or is malformed, has no animation, no mesh or several, or too many frames.
    """
    name = fspath(path)
    with refusing_damage(path):
        file = read_gltf(path)
        placed = placed_surfaces(name, file)
        _check_placed_once(path, file.head, placed)
        animation = _first_animation(name, file.head)
        times = _times(name, file, animation, frames_per_second)
        triangles = placed_triangles(file, placed)
        _check_size(name, times, len(posed_points(file, placed)))
        tracks = [track for channel in animation.channels for track in _tracks(file, animation, channel, times)]
        frames = np.array([posed_points(posed, placed) for posed in _poses(file, tracks, len(times))])
    for number, points in enumerate(frames):
        check_points(f"{name}: frame {number}, point", points)
    used, corners = np.unique(triangles, return_inverse=True)  # Meshes may share their points.
    return list(map(list, corners.reshape(-1, 3).tolist())), times, frames[:, used]


def _check_placed_once(path: FilePath, head: GltfHead, placed: list[Placed]) -> None:
    nodes = sorted({number for _, number in placed})
    check_one_mesh(path, [head.nodes[number].name or f"node {number}" for number in nodes])


def _first_animation(name: str, head: GltfHead) -> Animation:
    if not head.animations:
        raise FileError(f"{name}: has no animation; expected a mesh that moves; export the file with its animation")
    if len(head.animations) > 1:
        found = f"has {len(head.animations)} animations"
        logger.warning("%s: %s; plays the first one, %.40s", name, found, head.animations[0].name or "without a name")
    return head.animations[0]


def _times(name: str, file: GltfFile, animation: Animation, frames_per_second: float) -> FloatArray:
    """Return the times of the frames [s]: evenly spaced from the first key to the last one."""
    ends = [_keys(file, sampler.input)[[0, -1]] for sampler in animation.samplers]
    if not ends:
        raise ValueError("its animation has no keys")
    first, last = float(np.min(ends)), float(np.max(ends))
    count = np.floor((last - first) * frames_per_second * (1.0 + 1e-6) + 1e-6) + 1.0  # Keys are single precision.
    if count > MOST_FRAMES:
        found = f"its animation of {last - first:.3g} s has {count:.3g} frames"
        raise FileError(f"{name}: {found}; expected at most {MOST_FRAMES}; give fewer frames per second")
    return first + np.arange(int(count)) / frames_per_second


def _check_size(name: str, times: FloatArray, points: int) -> None:
    size = 24 * len(times) * points
    if size > LARGEST_MOTION:
        found = f"{len(times)} frames of {points} points take {size / 2**30:.3g} GiB"
        expected = f"expected at most {LARGEST_MOTION / 2**30:g} GiB"
        raise FileError(f"{name}: {found}; {expected}; give fewer frames per second")


def _keys(file: GltfFile, number: int) -> FloatArray:
    """Return the times of keys [s], ascending."""
    times = numbers_of(file, number, "SCALAR")[:, 0]
    if not len(times) or not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise ValueError("the times of the keys of an animation do not increase")
    return times


def _tracks(file: GltfFile, animation: Animation, channel: Channel, times: FloatArray) -> Iterator[_Track]:
    """Yield what a channel makes of its node; nothing for what only an extension knows."""
    target, sampler = channel.target, item_of(animation.samplers, channel.sampler, "sampler")
    if target.node is None or target.path not in KINDS:
        return
    item_of(file.head.nodes, target.node, "node")
    keys, values = _keys(file, sampler.input), numbers_of(file, sampler.output, KINDS[target.path])
    by_key = 3 if sampler.interpolation == "CUBICSPLINE" else 1
    columns = values.shape[1]
    if target.path == "weights":
        columns = len(values) // (by_key * len(keys))
    if values.size != len(keys) * by_key * columns or not values.size:
        raise ValueError(f"the {target.path} of an animation have {values.size} numbers for {len(keys)} keys")
    shaped = values.reshape(len(keys), by_key, columns)
    yield _Track(target.node, target.path, _sampled(keys, shaped, times, sampler.interpolation, target.path))


def _sampled(keys: FloatArray, values: FloatArray, times: FloatArray, interpolation: str, path: str) -> FloatArray:
    """Return the numbers of a channel at some times.

    Args:
        keys: times of the keys [s], shape (n,).
        values: numbers at the keys; for splines the tangents before and behind them, shape (n, 1 or 3, columns).
        times: times [s], shape (K,).
        interpolation: ``LINEAR``, ``STEP`` or ``CUBICSPLINE``.
        path: what the channel changes.
    """
    when = np.clip(times, keys[0], keys[-1])
    before = np.clip(np.searchsorted(keys, when, side="right") - 1, 0, len(keys) - 1)
    after = np.minimum(before + 1, len(keys) - 1)
    span = (keys[after] - keys[before])[:, None]
    part = np.divide(when[:, None] - keys[before][:, None], span, out=np.zeros_like(span), where=span > 0.0)
    middle = values[:, values.shape[1] // 2]
    start, end = middle[before], middle[after]
    if interpolation == "STEP":
        found = start
    elif interpolation == "CUBICSPLINE":
        leaving, arriving = span * values[before, 2], span * values[after, 0]
        found = (
            (2.0 * part**3 - 3.0 * part**2 + 1.0) * start + (part**3 - 2.0 * part**2 + part) * leaving
            + (3.0 * part**2 - 2.0 * part**3) * end + (part**3 - part**2) * arriving
        )  # fmt: skip
    elif interpolation == "LINEAR":
        found = _on_great_arc(start, end, part) if path == "rotation" else start + part * (end - start)
    else:
        known = "LINEAR, STEP or CUBICSPLINE"
        raise ValueError(f"an animation is interpolated by {interpolation[:20]!r}, expected {known}")
    if path == "rotation":
        size = np.linalg.norm(found, axis=1, keepdims=True)
        return np.divide(found, size, out=np.tile([0.0, 0.0, 0.0, 1.0], (len(found), 1)), where=size > 0.0)
    return found


def _on_great_arc(start: FloatArray, end: FloatArray, part: FloatArray) -> FloatArray:
    """Return quaternions on the shorter great arcs between unit quaternions, shape (K, 4)."""
    cosine = np.einsum("nd,nd->n", start, end)[:, None]
    nearer = np.where(cosine < 0.0, -end, end)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    straight = np.sin(angle) < 1e-6  # A straight line differs from the arc by less than single precision.
    sine = np.where(straight, 1.0, np.sin(angle))
    first = np.where(straight, 1.0 - part, np.sin((1.0 - part) * angle) / sine)
    second = np.where(straight, part, np.sin(part * angle) / sine)
    found: FloatArray = first * start + second * nearer
    return found


def _poses(file: GltfFile, tracks: list[_Track], frames: int) -> Iterator[GltfFile]:
    """Yield the file with its nodes in the pose of each frame."""
    for frame in range(frames):
        nodes = list(file.head.nodes)
        for track in tracks:
            changed = {track.path: track.values[frame].tolist()}
            if track.path != "weights":
                changed["matrix"] = None
            nodes[track.node] = msgspec.structs.replace(nodes[track.node], **changed)
        yield replace(file, head=msgspec.structs.replace(file.head, nodes=nodes))
