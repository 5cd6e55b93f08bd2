# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Parts of the cloth that a scene holds or moves, as a brush and a panel change them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.app.pages.drape.entry_list import with_entry
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.scene.motion_section import STILL, AttachmentSection, Keyframe, Triple
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.scene import Scene


def with_held_triangles(scene: Scene, part: int | None, triangles: IntArray) -> Scene:
    """Return a scene that holds more triangles: by one of its parts, or by a new one, which is the last."""
    added = np.asarray(triangles, dtype=np.int64)
    if part is None:
        return replace(scene, attachments=(*scene.attachments, AttachmentSection(faces=_numbers(added))))
    before = scene.attachments[part]
    faces = np.union1d(np.array(before.faces, dtype=np.int64), added)
    return with_part(scene, part, replace(before, faces=_numbers(faces)))


def with_held_box(scene: Scene, box: BoxSection) -> Scene:
    """Return a scene with a new part: what lies in a box."""
    return replace(scene, attachments=(*scene.attachments, AttachmentSection(boxes=(box,))))


def without_held_triangles(opened: OpenedScene, triangles: IntArray) -> Scene:
    """Return a scene that does not hold some triangles.

    A part that loses something becomes the numbers of its other triangles, and a part that loses all is removed.
    """
    kept: list[AttachmentSection] = []
    for section, held in zip(opened.scene.attachments, opened.prepared.held, strict=True):
        before = _triangles_of(opened, section, held.vertices)
        left = np.setdiff1d(before, triangles)
        if len(left) == len(before):
            kept.append(section)
        elif len(left):
            kept.append(replace(section, boxes=(), vertices=(), faces=_numbers(left)))
    return replace(opened.scene, attachments=tuple(kept))


def with_part(scene: Scene, part: int, section: AttachmentSection | None) -> Scene:
    """Return a scene with another part in the place of one; None removes it."""
    return replace(scene, attachments=with_entry(scene.attachments, part, section))


def moved_part(opened: OpenedScene, part: int, displacement: Triple, rotation: Triple) -> AttachmentSection:
    """Return a part that moves evenly to a place at the end of the scene, and turns around its own middle.

    Args:
        opened: the scene.
        part: number of the part.
        displacement: from the start to the end [cm].
        rotation: axis times angle [degrees].
    """
    held = opened.prepared.held[part].vertices
    middle = opened.prepared.vertices[held].mean(axis=0) if len(held) else np.zeros(3)
    x, y, z = np.round(middle, 4).tolist()
    keys = keyframes_to(opened.scene, displacement, rotation)
    return replace(opened.scene.attachments[part], keyframes=keys, centre=(x, y, z) if rotation != STILL else STILL)


def keyframes_to(scene: Scene, displacement: Triple, rotation: Triple) -> tuple[Keyframe, ...]:
    """Return the keyframes of an even motion from the start to a place at the end of a scene; none for no motion."""
    if displacement == STILL and rotation == STILL:
        return ()
    return Keyframe(time=0.0), Keyframe(time=scene.duration, displacement=displacement, rotation=rotation)


def motion_words(keyframes: tuple[Keyframe, ...], release: float | None = None) -> str:
    """Return how something moves, in words."""
    last = keyframes[-1] if keyframes else Keyframe(time=0.0)
    moved = [f"{part:g}" for part in last.displacement]
    words = [f"moves by {', '.join(moved)} cm"] if last.displacement != STILL else []
    if last.rotation != STILL:
        words.append(f"turns by {np.linalg.norm(last.rotation):g}°")
    if len(keyframes) > 2:
        words.append(f"{len(keyframes)} keyframes")
    if release is not None:
        words.append(f"free after {release:g} s")
    return ", ".join(words) or "stays where it is"


def _triangles_of(opened: OpenedScene, section: AttachmentSection, vertices: IntArray) -> IntArray:
    """The triangles that stand for a part: its own, and for boxes those whose vertices are all held."""
    if not section.boxes and not section.vertices:
        return np.array(section.faces, dtype=np.int64)
    inside = np.isin(opened.cloth.triangles, vertices)
    whole = np.flatnonzero(inside.all(axis=1))
    return whole if len(whole) else np.flatnonzero(inside.any(axis=1))


def _numbers(triangles: IntArray) -> tuple[int, ...]:
    return tuple(triangles.tolist())
