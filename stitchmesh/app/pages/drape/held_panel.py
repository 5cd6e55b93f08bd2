# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of what is held: the parts of the cloth that stay in place, move, or are let go."""

from __future__ import annotations

from dataclasses import replace

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.app.pages.drape.entry_list import EntryList
from stitchmesh.app.pages.drape.held_parts import (
    motion_words,
    moved_part,
    with_held_triangles,
    with_part,
    without_held_triangles,
)
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.drape.typed_numbers import as_text, three_numbers
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.scene.motion_section import STILL, AttachmentSection

HOW = (
    "With A drag on “holds the cloth”, paint what is held; the brush Border takes a whole side. "
    "A new drag adds to the chosen part, or begins a new one."
)
WHAT = "what is held"
"""Beginning of messages."""
STILL_TEXT = as_text(STILL)
MOST_SECONDS = 3600.0
"""Latest time at which a part is let go [s]."""


class HeldPanel:
    """The group of what is held; a part is chosen to be changed or painted on."""

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
            self._release = controls.number(
                "Let go at", "Time from which the part is free [s]; 0 holds it to the end.", 0.0, self._set_release,
                least=0.0, most=MOST_SECONDS, step=0.05,
            )  # fmt: skip

    def paint(self, triangles: IntArray, *, holds: bool) -> None:
        """Hold triangles by the chosen part or by a new one, or let go of them."""
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
        section = self._list.show(opened.scene, part_words(opened))
        for control in (self._new, self._moved, self._turned, self._motion, self._release):
            control.visible = section is not None
        if section is not None:
            self._show_part(section)

    def _show_part(self, section: AttachmentSection) -> None:
        last = section.keyframes[-1] if section.keyframes else None
        self._moved.value = STILL_TEXT if last is None else as_text(last.displacement)
        self._turned.value = STILL_TEXT if last is None else as_text(last.rotation)
        self._release.value = section.release or 0.0

    def _move(self, which: str) -> None:
        """Let the chosen part move, or hold it."""
        opened, (part, _) = self._session.opened_for(WHAT), self._list.chosen_entry()
        moved = three_numbers("part moved by", self._moved.value) if which == "Moves" else STILL
        turned = three_numbers("part turned by", self._turned.value, "degrees") if which == "Moves" else STILL
        self._session.change(with_part(opened.scene, part, moved_part(opened, part, moved, turned)))

    def _set_release(self, seconds: float) -> None:
        number, section = self._list.chosen_entry()
        released = replace(section, release=float(seconds) or None)
        self._session.change(with_part(self._session.opened_for(WHAT).scene, number, released))


def part_words(opened: OpenedScene) -> list[str]:
    """Return what each part holds, and how it moves."""
    parts = zip(opened.scene.attachments, opened.prepared.held, strict=True)
    return [
        f"part {number}: {len(held.vertices):,} vertices, {len(held.nodes):,} yarn nodes, "
        f"{motion_words(section.keyframes, section.release)}"
        for number, (section, held) in enumerate(parts, 1)
    ]
