# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of the bodies that the cloth cannot enter: meshes, balls and boxes, at rest or moving."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.drape.drape_session import FILES, DrapeSession
from stitchmesh.app.pages.drape.entry_list import EntryList
from stitchmesh.app.pages.drape.held_parts import keyframes_to
from stitchmesh.app.pages.drape.scene_bodies import (
    SIZE_WORDS,
    body_of_file,
    body_words,
    new_shape,
    with_body,
    with_changed_body,
)
from stitchmesh.app.pages.drape.typed_numbers import as_text, three_numbers, typed_numbers
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.mixed.scene.motion_section import STILL, BodySection

SUFFIXES = (".obj", ".ply", ".off", ".stl")
"""Suffixes of the meshes of bodies."""
WHAT = "bodies"
"""Beginning of messages."""
MOST_FRICTION, MOST_DISTANCE = 10.0, 100.0
"""Largest coefficient of friction, and largest distance from a body [cm]."""


class BodiesPanel:
    """The group of the bodies; a body is chosen to be changed."""

    def __init__(self, session: DrapeSession, controls: Controls) -> None:
        """Make the controls."""
        self._session = session
        with controls.group("Bodies", opened=False) as self._group:
            self._list = EntryList(
                session, controls, "body", WHAT, lambda scene: scene.bodies,
                lambda scene, number: with_changed_body(scene, number, None), self.refresh,
            )  # fmt: skip
            self._unit = controls.choice("Unit of meshes", "Unit of the mesh that is added next.", tuple(CENTIMETRES),
                                         DEFAULT_UNIT)  # fmt: skip
            controls.upload("Add a mesh", "A closed mesh that the cloth cannot enter.", SUFFIXES, self._receive)
            self._path = controls.text("Path of a body", "A mesh on the computer of StitchMesh.", "")
            controls.buttons("Add a body", "The mesh of the path, or a shape in front of or below the cloth.",
                             ("Mesh", "Ball", "Box"), self._add)  # fmt: skip
            self._around = controls.toggle(
                "Put the cloth around", "A cloth that cuts a body at the start is moved out of it.", False,
                lambda around: self._set_contact(start_outside=around),
            )
            self._touches = controls.toggle(
                "Cloth touches itself", "Whether layers of the cloth keep apart.", False,
                lambda touches: self._set_contact(self_collision=touches),
            )  # fmt: skip
            self._make_fields(controls)

    def refresh(self) -> None:
        """Show the bodies of the scene."""
        opened = self._session.opened
        self._group.visible = opened is not None
        if opened is None:
            return
        body, contact = self._list.show(opened.scene, body_words(opened.scene)), opened.scene.contact
        self._around.value, self._touches.value = contact.start_outside, contact.self_collision
        self._around.visible = bool(opened.scene.bodies)
        for control in (self._friction, self._distance, self._moved, self._turned, self._apply):
            control.visible = body is not None
        self._centre.visible = self._size.visible = body is not None and body.shape is not None
        if body is not None:
            self._show_body(body)

    def _make_fields(self, controls: Controls) -> None:
        """Make the controls of the chosen body."""
        self._friction = controls.number("Friction", "Coefficient of friction with the cloth.", 0.3,
                                         lambda friction: self._set(friction=float(friction)), least=0.0,
                                         most=MOST_FRICTION, step=0.05)  # fmt: skip
        self._distance = controls.number("Distance", "Layer on the body that the cloth stays out of [cm].", 0.0,
                                         lambda distance: self._set(thickness=float(distance)), least=0.0,
                                         most=MOST_DISTANCE, step=0.01)  # fmt: skip
        self._centre = controls.text("Centre", "x, y, z of its middle [cm].", "")
        self._size = controls.text("Size", "Radius of a ball; the sides of a box [cm].", "")
        self._moved = controls.text("Body moved by", "x, y, z from the start to the end of the scene [cm].", "")
        self._turned = controls.text("Body turned by", "Angles about x, y and z [degrees], around its centre.", "")
        self._apply = controls.buttons("The body", "Take the numbers above, or let the body rest.",
                                       ("Take numbers", "Rests"), self._take)  # fmt: skip

    def _show_body(self, body: BodySection) -> None:
        last = body.keyframes[-1] if body.keyframes else None
        self._friction.value, self._distance.value = body.friction, body.thickness
        self._centre.value, self._size.value = as_text(body.centre), as_text(body.size)
        self._moved.value = as_text(STILL if last is None else last.displacement)
        self._turned.value = as_text(STILL if last is None else last.rotation)

    def _receive(self, name: str, content: bytes) -> None:
        path = self._session.folder / FILES / Path(name.replace("\\", "/")).name
        self._session.opened_for(WHAT)
        write_bytes(path, content)
        self._add_mesh(path)

    def _add(self, which: str) -> None:
        """Add the mesh of the path, or a shape."""
        if which == "Mesh":
            text = str(self._path.value).strip()
            if not text:
                raise ParameterError("path of a body: got nothing; expected a closed mesh")
            self._add_mesh(Path(text).expanduser())
            return
        opened = self._session.opened_for(WHAT)
        self._add_body(new_shape(opened, "ball" if which == "Ball" else "box"))

    def _add_mesh(self, path: Path) -> None:
        self._add_body(body_of_file(path, str(self._unit.value)))

    def _add_body(self, body: BodySection) -> None:
        scene = self._session.opened_for(WHAT).scene
        self._session.change(with_body(scene, body))
        self._list.chosen = len(scene.bodies)

    def _take(self, which: str) -> None:
        """Take the typed numbers of the chosen body, or let it rest."""
        scene, (_, body) = self._session.opened_for(WHAT).scene, self._list.chosen_entry()
        if which == "Rests":
            self._change(replace(body, keyframes=()))
            return
        if body.shape is not None:
            size = typed_numbers(self._size.value)
            if not size:
                expected = f"expected numbers of cm ({SIZE_WORDS[body.shape]})"
                raise ParameterError(f"size: got {str(self._size.value)[:40]!r}; {expected}")
            body = replace(body, centre=three_numbers("centre", self._centre.value), size=size)
        moved = three_numbers("body moved by", self._moved.value)
        turned = three_numbers("body turned by", self._turned.value, "degrees")
        same = body.keyframes and (body.keyframes[-1].displacement, body.keyframes[-1].rotation) == (moved, turned)
        self._change(body if same else replace(body, keyframes=keyframes_to(scene, moved, turned)))

    def _set(self, **values: Any) -> None:
        """Change values of the chosen body."""
        self._change(replace(self._list.chosen_entry()[1], **values))

    def _set_contact(self, **values: Any) -> None:
        """Change how the cloth touches."""
        scene = self._session.opened_for(WHAT).scene
        self._session.change(replace(scene, contact=replace(scene.contact, **values)))

    def _change(self, body: BodySection) -> None:
        number, _ = self._list.chosen_entry()
        self._session.change(with_changed_body(self._session.opened_for(WHAT).scene, number, body))
