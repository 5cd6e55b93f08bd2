# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The bodies that the cloth cannot enter: meshes, balls and boxes, at rest or moving, with their controls."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import FieldPanel, Number, setting_field
from stitchmesh.app.pages.drape.drape_session import FILES, DrapeSession
from stitchmesh.app.pages.drape.entry_list import EntryList, with_entry
from stitchmesh.app.pages.drape.held_panel import keyframes_to, motion_words
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.typed import BODY_SUFFIXES, as_text, file_name, three_numbers, typed_numbers
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.mixed.scene.motion_section import STILL, BodySection
from stitchmesh.mixed.scene.scene import ContactSection, Scene

GAP = 1.2
"""Distance of the middle of a new shape from the cloth, over its radius."""
SIZE_WORDS = {"ball": "radius", "box": "sides", "arm": "radius, upper arm, forearm"}
"""The meaning of the numbers that give the size of a shape."""


def new_shape(opened: OpenedScene, shape: Literal["ball", "box"]) -> BodySection:
    """Return a ball or a box in front of the cloth, or below a cloth that lies flat."""
    low, high = opened.mesh.vertices.min(axis=0), opened.mesh.vertices.max(axis=0)
    radius = max(0.25 * float(np.sort(high - low)[1]), 0.1)
    middle, extent = (low + high) / 2.0, high - low
    if int(np.argmin(extent)) == 1:
        middle[1] = low[1] - GAP * radius
    else:
        middle[2] = high[2] + GAP * radius
    x, y, z = np.round(middle, 3).tolist()
    size = (radius,) if shape == "ball" else (2.0 * radius,) * 3
    name = f"{shape} {len(opened.scene.bodies) + 1}"
    return BodySection(name=name, shape=shape, centre=(x, y, z), size=tuple(round(side, 3) for side in size))


def with_changed_body(scene: Scene, number: int, body: BodySection | None) -> Scene:
    """Return a scene in which another body replaces one of its bodies; None removes it."""
    return replace(scene, bodies=with_entry(scene.bodies, number, body))


def body_words(scene: Scene) -> list[str]:
    """Return for each body what it is, and how it moves."""
    return [f"{body.name}: {_shape_words(body)}, {motion_words(body.keyframes)}" for body in scene.bodies]


def _shape_words(body: BodySection) -> str:
    if body.shape is None:
        return f"mesh {Path(body.file or '').name} in {body.unit}"
    return f"{body.shape} of {as_text(body.size)} cm at {as_text(body.centre)}"


WHAT = "bodies"
"""First words of messages."""
CONTACT = (
    setting_field(ContactSection, "start_outside", "Put the cloth around", at="contact.start_outside",
                  shown=lambda scene: bool(scene.bodies)),
    setting_field(ContactSection, "self_collision", "Cloth touches itself", at="contact.self_collision"),
)  # fmt: skip
"""How the cloth of a scene touches."""
SURFACE = (
    setting_field(BodySection, "friction", "Friction", Number(0.0, 10.0, 0.05)),
    setting_field(BodySection, "thickness", "Distance", Number(0.0, 100.0, 0.01)),
)
"""The surface of a body."""


class BodiesPanel:
    """The group of the bodies; the user chooses a body to change it."""

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
            controls.upload("Add a mesh", "A closed mesh that the cloth cannot enter.", BODY_SUFFIXES, self._receive)
            self._path = controls.text("Path of a body", "A mesh on the computer of StitchMesh.", "")
            controls.buttons("Add a body", "The mesh of the path, or a shape in front of or below the cloth.",
                             ("Mesh", "Ball", "Box"), self._add)  # fmt: skip
            self._contact = FieldPanel(
                controls, CONTACT, lambda: session.scene, lambda scene, name: session.change(scene)
            )
            self._surface = FieldPanel(controls, SURFACE, self._list.entry, lambda body, name: self._change(body))
            self._make_fields(controls)

    def refresh(self) -> None:
        """Show the bodies of the scene."""
        opened = self._session.opened
        self._group.visible = opened is not None
        if opened is None:
            return
        self._list.show(opened.scene, body_words(opened.scene))
        self._contact.show()
        self._surface.show()
        body = self._list.entry()
        for control in (self._moved, self._turned, self._apply):
            control.visible = body is not None
        self._centre.visible = self._size.visible = body is not None and body.shape is not None
        if body is not None:
            self._show_body(body)

    def _make_fields(self, controls: Controls) -> None:
        self._centre = controls.text("Centre", "x, y, z of its middle [cm].", "")
        self._size = controls.text("Size", "Radius of a ball; the sides of a box [cm].", "")
        self._moved = controls.text("Body moved by", "x, y, z from the start to the end of the scene [cm].", "")
        self._turned = controls.text("Body turned by", "Angles about x, y and z [degrees], around its centre.", "")
        self._apply = controls.buttons("The body", "Take the numbers above, or let the body rest.",
                                       ("Take numbers", "Rests"), self._take)  # fmt: skip

    def _show_body(self, body: BodySection) -> None:
        last = body.keyframes[-1] if body.keyframes else None
        self._centre.value, self._size.value = as_text(body.centre), as_text(body.size)
        self._moved.value = as_text(STILL if last is None else last.displacement)
        self._turned.value = as_text(STILL if last is None else last.rotation)

    def _receive(self, name: str, content: bytes) -> None:
        path = self._session.folder / FILES / file_name(name)
        self._session.opened_for(WHAT)
        write_bytes(path, content)
        self._add_mesh(path)

    def _add(self, which: str) -> None:
        if which == "Mesh":
            text = str(self._path.value).strip()
            if not text:
                raise ParameterError("path of a body: got nothing; expected a closed mesh")
            self._add_mesh(Path(text).expanduser())
            return
        opened = self._session.opened_for(WHAT)
        self._add_body(new_shape(opened, "ball" if which == "Ball" else "box"))

    def _add_mesh(self, path: Path) -> None:
        self._add_body(BodySection(name=path.stem, file=str(path.absolute()), unit=str(self._unit.value)))

    def _add_body(self, body: BodySection) -> None:
        scene = self._session.opened_for(WHAT).scene
        self._session.change(replace(scene, bodies=(*scene.bodies, body)))
        self._list.chosen = len(scene.bodies)

    def _take(self, which: str) -> None:
        """Take the typed numbers for the chosen body, or put the body at rest."""
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

    def _change(self, body: BodySection) -> None:
        number, _ = self._list.chosen_entry()
        self._session.change(with_changed_body(self._session.opened_for(WHAT).scene, number, body))
