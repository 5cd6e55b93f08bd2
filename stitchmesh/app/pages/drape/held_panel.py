# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The group Held: the parts of the cloth that stay in place, move, or are let go, with their controls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import FieldPanel, Number, setting_field
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.app.pages.drape.entry_list import EntryList, with_entry
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.typed import as_text, three_numbers
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.scene.motion_section import STILL, AttachmentSection, Keyframe, Triple
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.scene import Scene


def with_held_triangles(scene: Scene, part: int | None, triangles: IntArray) -> Scene:
    """Return a scene that holds more triangles: in one of its parts, or in a new last part."""
    added = np.asarray(triangles, dtype=np.int64)
    if part is None:
        return replace(scene, attachments=(*scene.attachments, AttachmentSection(faces=_numbers(added))))
    before = scene.attachments[part]
    faces = np.union1d(np.array(before.faces, dtype=np.int64), added)
    return with_part(scene, part, replace(before, faces=_numbers(faces)))


def with_held_box(scene: Scene, box: BoxSection) -> Scene:
    """Return a scene with a new part that holds everything in a box."""
    return replace(scene, attachments=(*scene.attachments, AttachmentSection(boxes=(box,))))


def without_held_triangles(opened: OpenedScene, triangles: IntArray) -> Scene:
    """Return a scene that does not hold some triangles.

    A part that loses triangles becomes the numbers of its other triangles; a part that loses all of them is removed.
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
    """Return a scene in which another part replaces one of its parts; None removes it."""
    return replace(scene, attachments=with_entry(scene.attachments, part, section))


def moved_part(opened: OpenedScene, part: int, displacement: Triple, rotation: Triple) -> AttachmentSection:
    """Return a part that moves evenly by ``displacement`` [cm] and turns by ``rotation`` [degrees] about its middle."""
    held = opened.prepared.held[part].vertices
    middle = opened.prepared.vertices[held].mean(axis=0) if len(held) else np.zeros(3)
    x, y, z = np.round(middle, 4).tolist()
    keys = keyframes_to(opened.scene, displacement, rotation)
    return replace(opened.scene.attachments[part], keyframes=keys, centre=(x, y, z) if rotation != STILL else STILL)


def keyframes_to(scene: Scene, displacement: Triple, rotation: Triple) -> tuple[Keyframe, ...]:
    """Return the keyframes of an even motion over the whole scene to a place; none without motion."""
    if displacement == STILL and rotation == STILL:
        return ()
    return Keyframe(time=0.0), Keyframe(time=scene.duration, displacement=displacement, rotation=rotation)


def motion_words(keyframes: tuple[Keyframe, ...], release: float | None = None) -> str:
    """Return a motion in words."""
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
    """Return the triangles that show a part: its own, and for its boxes those with all vertices held."""
    if not section.boxes and not section.vertices:
        return np.array(section.faces, dtype=np.int64)
    inside = np.isin(opened.cloth.triangles, vertices)
    whole = np.flatnonzero(inside.all(axis=1))
    return whole if len(whole) else np.flatnonzero(inside.any(axis=1))


def _numbers(triangles: IntArray) -> tuple[int, ...]:
    return tuple(triangles.tolist())


HOW = (
    "With A drag on “holds the cloth”, paint what is held; the brush Border takes a whole side. "
    "A new drag adds to the chosen part, or begins a new one."
)
WHAT = "what is held"
"""Beginning of messages."""
STILL_TEXT = as_text(STILL)
RELEASE = (setting_field(AttachmentSection, "release", "Let go at", Number(0.0, 3600.0, 0.05, without=None)),)
"""Choices of when a part is let go."""


class HeldPanel:
    """The group of held parts; the user chooses a part to change it or to paint on it."""

    def __init__(self, session: DrapeSession, controls: Controls) -> None:
        """Make the controls."""
        self._session = session
        with controls.group("What is held", opened=False) as self._group:
            controls.html(paragraph(HOW))
            self._list = EntryList(
                session, controls, "part", WHAT, lambda scene: scene.attachments,
                lambda scene, number: with_part(scene, number, None), self.refresh,
            )  # fmt: skip
            self._new = controls.button(
                "Begin a new part", "What is painted next is a part of its own, which can move by itself.",
                lambda: self._list.choose(None),
            )  # fmt: skip
            self._moved = controls.text(
                "Part moved by", "x, y, z from the start to the end of the scene [cm]; y points up.", STILL_TEXT
            )
            self._turned = controls.text(
                "Part turned by", "Angles about x, y and z [degrees], around the middle of the part.", STILL_TEXT
            )
            self._motion = controls.buttons(
                "The part", "Let it move by these numbers, or hold it where it is.", ("Moves", "Stays"), self._move
            )
            self._release = FieldPanel(
                controls, RELEASE, self._list.entry, lambda part, name: self._change(part)
            )  # fmt: skip

    def paint(self, triangles: IntArray, *, holds: bool) -> None:
        """Hold triangles in the chosen part or in a new one, or let go of them."""
        opened = self._session.opened_for(WHAT)
        if holds:
            part = self._list.chosen
            self._session.change(with_held_triangles(opened.scene, part, triangles))
            self._list.chosen = len(opened.scene.attachments) if part is None else part
        else:
            self._session.change(without_held_triangles(opened, triangles))

    def refresh(self) -> None:
        """Show the parts of the scene."""
        opened = self._session.opened
        self._group.visible = opened is not None
        if opened is None:
            return
        self._list.show(opened.scene, part_words(opened))
        self._release.show()
        section = self._list.entry()
        for control in (self._new, self._moved, self._turned, self._motion):
            control.visible = section is not None
        if section is not None:
            self._show_part(section)

    def _show_part(self, section: AttachmentSection) -> None:
        last = section.keyframes[-1] if section.keyframes else None
        self._moved.value = STILL_TEXT if last is None else as_text(last.displacement)
        self._turned.value = STILL_TEXT if last is None else as_text(last.rotation)

    def _move(self, which: str) -> None:
        opened, (number, _) = self._session.opened_for(WHAT), self._list.chosen_entry()
        moved = three_numbers("part moved by", self._moved.value) if which == "Moves" else STILL
        turned = three_numbers("part turned by", self._turned.value, "degrees") if which == "Moves" else STILL
        self._change(moved_part(opened, number, moved, turned))

    def _change(self, part: AttachmentSection) -> None:
        number, _ = self._list.chosen_entry()
        self._session.change(with_part(self._session.opened_for(WHAT).scene, number, part))


def part_words(opened: OpenedScene) -> list[str]:
    """Return for each part what it holds, and how it moves."""
    parts = zip(opened.scene.attachments, opened.prepared.held, strict=True)
    return [
        f"part {number}: {len(held.vertices):,} vertices, {len(held.nodes):,} yarn nodes, "
        f"{motion_words(section.keyframes, section.release)}"
        for number, (section, held) in enumerate(parts, 1)
    ]
