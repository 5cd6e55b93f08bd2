# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of what is held: the parts of the cloth that stay in place, move, or are let go."""

from __future__ import annotations

from dataclasses import replace

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.app.pages.drape.entry_list import entry_list
from stitchmesh.app.pages.drape.held_parts import (
    motion_words,
    moved_part,
    with_held_triangles,
    with_part,
    without_held_triangles,
)
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.drape.typed_numbers import as_text, three_numbers
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.scene.motion_section import STILL, AttachmentSection

HOW = (
    "With A drag on “holds the cloth”, paint what is held; the brush Border takes a whole side. "
    "A new drag adds to the chosen part, or begins a new one."
)
STILL_TEXT = as_text(STILL)
MOST_SECONDS = 3600.0
"""Latest time at which a part is let go [s]."""


class HeldPanel:
    """The group of what is held; a part is chosen to be changed or painted on."""

    def __init__(self, session: DrapeSession, controls: Controls) -> None:
        """Make the controls."""
        self._session = session
        self._chosen: int | None = None
        with controls.group("What is held", opened=False) as self._group:
            controls.html(paragraph(HOW))
            self._list = controls.html(Markup(), self._act)
            self._new = controls.button(
                "Begin a new part", "What is painted next is a part of its own, which can move by itself.",
                lambda: self._choose(None),
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
        opened = self._opened()
        if holds:
            part = self._chosen
            self._session.change(with_held_triangles(opened.scene, part, triangles))
            self._chosen = len(opened.scene.attachments) if part is None else part
        else:
            self._session.change(without_held_triangles(opened, triangles))

    def refresh(self) -> None:
        """Show the parts of the scene."""
        opened = self._session.opened
        self._group.visible = opened is not None
        if opened is None:
            return
        parts = opened.scene.attachments
        # A part that was just painted is not there yet: the scene is made in the worker thread.
        if self._chosen is not None and self._chosen >= len(parts) and not self._session.app.tasks.running:
            self._chosen = None
        self._list.content = entry_list("part", part_words(opened), chosen=self._chosen, choose=True)
        section = parts[self._chosen] if self._chosen is not None and self._chosen < len(parts) else None
        for control in (self._new, self._moved, self._turned, self._motion, self._release):
            control.visible = section is not None
        if section is not None:
            self._show_part(section)

    def _show_part(self, section: AttachmentSection) -> None:
        last = section.keyframes[-1] if section.keyframes else None
        self._moved.value = STILL_TEXT if last is None else as_text(last.displacement)
        self._turned.value = STILL_TEXT if last is None else as_text(last.rotation)
        self._release.value = section.release or 0.0

    def _opened(self) -> OpenedScene:
        opened = self._session.opened
        if opened is None:
            raise ParameterError("what is held: there is no cloth yet; open a scene first")
        return opened

    def _act(self, action: str, value: str) -> None:
        """Choose or remove a part of the list."""
        scene = self._opened().scene
        if action not in ("choose-part", "drop-part") or not value.isdecimal() or int(value) >= len(scene.attachments):
            raise ParameterError("what is held: the list has changed; look at it again")
        if action == "choose-part":
            self._choose(int(value))
            return
        self._chosen = None
        self._session.change(with_part(scene, int(value), None))

    def _choose(self, part: int | None) -> None:
        self._chosen = part
        self.refresh()

    def _move(self, which: str) -> None:
        """Let the chosen part move, or hold it."""
        opened, part = self._opened(), self._part()
        moved = three_numbers("part moved by", self._moved.value) if which == "Moves" else STILL
        turned = three_numbers("part turned by", self._turned.value, "degrees") if which == "Moves" else STILL
        self._session.change(with_part(opened.scene, part, moved_part(opened, part, moved, turned)))

    def _set_release(self, seconds: float) -> None:
        scene, part = self._opened().scene, self._part()
        section = replace(scene.attachments[part], release=float(seconds) or None)
        self._session.change(with_part(scene, part, section))

    def _part(self) -> int:
        """Number of the chosen part.

        Raises:
            ParameterError: it is not there any more.
        """
        if self._chosen is None or self._chosen >= len(self._opened().scene.attachments):
            raise ParameterError("what is held: no part is chosen; choose one in the list")
        return self._chosen


def part_words(opened: OpenedScene) -> list[str]:
    """Return what each part holds, and how it moves."""
    parts = zip(opened.scene.attachments, opened.prepared.held, strict=True)
    return [
        f"part {number}: {len(held.vertices):,} vertices, {len(held.nodes):,} yarn nodes, "
        f"{motion_words(section.keyframes, section.release)}"
        for number, (section, held) in enumerate(parts, 1)
    ]
