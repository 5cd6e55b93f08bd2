# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of what acts on the cloth: parts that are held, move or are let go, and bodies, at rest or moving."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Generic, Literal, TypeVar

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import FieldPanel, Number, setting_field
from stitchmesh.app.controls.html_pieces import SMALL_BUTTON, action_button, paragraph
from stitchmesh.app.pages.drape.drape_session import FILES, DrapeSession
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.typed import BODY_SUFFIXES, as_text, file_name, three_numbers, typed_numbers
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.scene.motion_section import STILL, AttachmentSection, BodySection, Keyframe, Triple
from stitchmesh.mixed.scene.scene import ContactSection, Scene

T = TypeVar("T")


def entry_list(
    kind: str, entries: Iterable[str], *, chosen: int | None = None, choose: bool = False, rest: str = ""
) -> Markup:
    """Return the entries as a list; an empty text if there are none.

    The actions are ``drop-`` and ``choose-`` with the kind; their value is the number of the entry.

    Args:
        kind: word for an entry.
        entries: texts of the entries.
        chosen: number of the entry that is marked as the chosen one.
        choose: whether entries can be chosen.
        rest: a last line that is no entry.
    """
    items = []
    for number, text in enumerate(entries):
        is_chosen = number == chosen
        buttons = action_button(f"drop-{kind}", number, "Remove", name=f"Remove the {text}", style=SMALL_BUTTON)
        if choose:
            change = action_button(
                f"choose-{kind}", number, "Change", name=f"Change the {text}", pressed=is_chosen, style=SMALL_BUTTON
            )
            buttons = change + buttons
        items.append(
            markup(
                '<li style="display:flex;gap:4px;align-items:center;margin:.2em 0;{}">'
                '<span style="flex:1 1 auto">{}</span>{}</li>',
                "border-left:4px solid #1f5673;padding-left:.4em;" if is_chosen else "", text, buttons,
            )
        )
    if rest:
        items.append(markup("<li>{}</li>", rest))
    frame = '<ul style="list-style:none;margin:0;padding:0;font-size:.82em">{}</ul>'
    return markup(frame, joined(items)) if items else Markup()


class EntryList(Generic[T]):
    """The parts or the bodies of a scene as a list; the user can choose one to change it."""

    def __init__(
        self, session: DrapeSession, controls: Controls, kind: str, what: str,
        entries: Callable[[Scene], tuple[T, ...]], with_entries: Callable[[Scene, tuple[T, ...]], Scene],
        changed: Callable[[], object],
    ) -> None:  # fmt: skip
        """Make the list.

        Args:
            session: the scene.
            controls: the place of the list.
            kind: word for an entry.
            what: the first words of messages.
            entries: returns the entries of a scene.
            with_entries: returns a scene with other entries.
            changed: called after another entry is chosen.
        """
        self._session, self._kind, self._what = session, kind, what
        self._entries, self._with_entries, self._changed = entries, with_entries, changed
        self.chosen: int | None = None
        """Number of the chosen entry; a new entry may be missing for a while, because the worker thread makes the
        scene."""
        self._html = controls.html(Markup(), self._act)

    def show(self, scene: Scene, words: Iterable[str]) -> None:
        """Show the entries of a scene with their words."""
        entries = self._entries(scene)
        if self.chosen is not None and self.chosen >= len(entries) and not self._session.app.tasks.running:
            self.chosen = None
        self._html.content = entry_list(self._kind, words, chosen=self.chosen, choose=True)

    def entry(self) -> T | None:
        """Return the chosen entry; None if there is none."""
        opened = self._session.opened
        entries = () if opened is None else self._entries(opened.scene)
        return entries[self.chosen] if self.chosen is not None and self.chosen < len(entries) else None

    def add(self, entry: T) -> None:
        """Add an entry to the scene, and choose it."""
        scene = self._session.opened_for(self._what).scene
        entries = self._entries(scene)
        self._session.change(self._with_entries(scene, (*entries, entry)))
        self.chosen = len(entries)

    def change(self, entry: T) -> None:
        """Let another entry replace the chosen one.

        Raises:
            ParameterError: no entry is chosen, or the chosen one is gone.
        """
        self._replace(self.chosen_entry()[0], entry)

    def _replace(self, number: int, *entry: T) -> None:
        """Let another entry replace the one with a number; without another one, remove it."""
        scene = self._session.opened_for(self._what).scene
        entries = self._entries(scene)
        self._session.change(self._with_entries(scene, (*entries[:number], *entry, *entries[number + 1 :])))

    def choose(self, number: int | None) -> None:
        """Choose an entry, or none."""
        self.chosen = number
        self._changed()

    def chosen_entry(self) -> tuple[int, T]:
        """Return the number of the chosen entry, and the entry.

        Raises:
            ParameterError: no entry is chosen, or the chosen one is gone.
        """
        entries = self._entries(self._session.opened_for(self._what).scene)
        if self.chosen is None or self.chosen >= len(entries):
            raise ParameterError(f"{self._what}: no {self._kind} is chosen; choose one in the list")
        return self.chosen, entries[self.chosen]

    def _act(self, action: str, value: str) -> None:
        scene = self._session.opened_for(self._what).scene
        choose, drop = f"choose-{self._kind}", f"drop-{self._kind}"
        if action not in (choose, drop) or not value.isdecimal() or int(value) >= len(self._entries(scene)):
            raise ParameterError(f"{self._what}: the list has changed; look at it again")
        if action == choose:
            self.choose(int(value))
            return
        self.chosen = None
        self._replace(int(value))


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
HELD, BODIES = "what is held", "bodies"
"""First words of messages."""
RELEASE = (setting_field(AttachmentSection, "release", "Let go at", Number(0.0, 3600.0, 0.05, without=None)),)
"""Choices of when a part is let go."""


class MotionTexts:
    """The typed motion of an entry over the whole scene."""

    def __init__(self, controls: Controls, kind: str, middle: str) -> None:
        """Make the controls; ``kind`` is the word for an entry, and ``middle`` the place about which it turns."""
        self._kind = kind
        self.moved = controls.text(
            f"{kind} moved by", "x, y, z from the start to the end of the scene [cm]; y points up.", as_text(STILL)
        )
        self.turned = controls.text(
            f"{kind} turned by", f"Angles about x, y and z [degrees], around {middle}.", as_text(STILL)
        )

    def show(self, keyframes: Sequence[Keyframe]) -> None:
        """Show the place at the end of a motion."""
        last = keyframes[-1] if keyframes else Keyframe(time=0.0)
        self.moved.value, self.turned.value = as_text(last.displacement), as_text(last.rotation)

    def typed(self) -> tuple[Triple, Triple]:
        """Return the typed displacement [cm] and rotation [degrees].

        Raises:
            ParameterError: a text does not have three numbers.
        """
        moved = three_numbers(f"{self._kind.lower()} moved by", self.moved.value)
        return moved, three_numbers(f"{self._kind.lower()} turned by", self.turned.value, "degrees")


class HeldPanel:
    """The group of held parts; the user chooses a part to change it or to paint on it."""

    def __init__(self, session: DrapeSession, controls: Controls) -> None:
        """Make the controls."""
        self._session = session
        with controls.group("What is held", opened=False) as self._group:
            controls.html(paragraph(HOW))
            self._list = EntryList(
                session, controls, "part", HELD, lambda scene: scene.attachments,
                lambda scene, parts: replace(scene, attachments=parts), self.refresh,
            )  # fmt: skip
            self._new = controls.button(
                "Begin a new part", "What is painted next is a part of its own, which can move by itself.",
                lambda: self._list.choose(None),
            )  # fmt: skip
            self._texts = MotionTexts(controls, "Part", "the middle of the part")
            self._motion = controls.buttons(
                "The part", "Let it move by these numbers, or hold it where it is.", ("Moves", "Stays"), self._move
            )
            self._release = FieldPanel(
                controls, RELEASE, self._list.entry, lambda part, name: self._list.change(part)
            )  # fmt: skip

    def paint(self, triangles: IntArray, *, holds: bool) -> None:
        """Hold triangles in the chosen part or in a new one, or let go of them."""
        opened = self._session.opened_for(HELD)
        if not holds:
            self._session.change(without_held_triangles(opened, triangles))
        elif self._list.chosen is None:
            self._list.add(AttachmentSection(faces=_numbers(np.asarray(triangles, dtype=np.int64))))
        else:
            _, part = self._list.chosen_entry()
            faces = np.union1d(np.array(part.faces, dtype=np.int64), triangles)
            self._list.change(replace(part, faces=_numbers(faces)))

    def refresh(self) -> None:
        """Show the parts of the scene."""
        opened = self._session.opened
        self._group.visible = opened is not None
        if opened is None:
            return
        self._list.show(opened.scene, part_words(opened))
        self._release.show()
        section = self._list.entry()
        for control in (self._new, self._texts.moved, self._texts.turned, self._motion):
            control.visible = section is not None
        if section is not None:
            self._texts.show(section.keyframes)

    def _move(self, which: str) -> None:
        opened, (number, _) = self._session.opened_for(HELD), self._list.chosen_entry()
        moved, turned = self._texts.typed() if which == "Moves" else (STILL, STILL)
        self._list.change(moved_part(opened, number, moved, turned))


def part_words(opened: OpenedScene) -> list[str]:
    """Return for each part what it holds, and how it moves."""
    parts = zip(opened.scene.attachments, opened.prepared.held, strict=True)
    return [
        f"part {number}: {len(held.vertices):,} vertices, {len(held.nodes):,} yarn nodes, "
        f"{motion_words(section.keyframes, section.release)}"
        for number, (section, held) in enumerate(parts, 1)
    ]


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


def body_words(scene: Scene) -> list[str]:
    """Return for each body what it is, and how it moves."""
    return [f"{body.name}: {_shape_words(body)}, {motion_words(body.keyframes)}" for body in scene.bodies]


def _shape_words(body: BodySection) -> str:
    if body.shape is None:
        return f"mesh {Path(body.file or '').name} in {body.unit}"
    return f"{body.shape} of {as_text(body.size)} cm at {as_text(body.centre)}"


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
                session, controls, "body", BODIES, lambda scene: scene.bodies,
                lambda scene, bodies: replace(scene, bodies=bodies), self.refresh,
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
            self._surface = FieldPanel(controls, SURFACE, self._list.entry, lambda body, name: self._list.change(body))
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
        for control in (self._texts.moved, self._texts.turned, self._apply):
            control.visible = body is not None
        self._centre.visible = self._size.visible = body is not None and body.shape is not None
        if body is not None:
            self._centre.value, self._size.value = as_text(body.centre), as_text(body.size)
            self._texts.show(body.keyframes)

    def _make_fields(self, controls: Controls) -> None:
        self._centre = controls.text("Centre", "x, y, z of its middle [cm].", "")
        self._size = controls.text("Size", "Radius of a ball; the sides of a box [cm].", "")
        self._texts = MotionTexts(controls, "Body", "its centre")
        self._apply = controls.buttons("The body", "Take the numbers above, or let the body rest.",
                                       ("Take numbers", "Rests"), self._take)  # fmt: skip

    def _receive(self, name: str, content: bytes) -> None:
        path = self._session.folder / FILES / file_name(name)
        self._session.opened_for(BODIES)
        write_bytes(path, content)
        self._add_mesh(path)

    def _add(self, which: str) -> None:
        if which == "Mesh":
            text = str(self._path.value).strip()
            if not text:
                raise ParameterError("path of a body: got nothing; expected a closed mesh")
            self._add_mesh(Path(text).expanduser())
            return
        opened = self._session.opened_for(BODIES)
        self._list.add(new_shape(opened, "ball" if which == "Ball" else "box"))

    def _add_mesh(self, path: Path) -> None:
        self._list.add(BodySection(name=path.stem, file=str(path.absolute()), unit=str(self._unit.value)))

    def _take(self, which: str) -> None:
        """Take the typed numbers for the chosen body, or put the body at rest."""
        scene, (_, body) = self._session.opened_for(BODIES).scene, self._list.chosen_entry()
        if which == "Rests":
            self._list.change(replace(body, keyframes=()))
            return
        if body.shape is not None:
            size = typed_numbers(self._size.value)
            if not size:
                expected = f"expected numbers of cm ({SIZE_WORDS[body.shape]})"
                raise ParameterError(f"size: got {str(self._size.value)[:40]!r}; {expected}")
            body = replace(body, centre=three_numbers("centre", self._centre.value), size=size)
        moved, turned = self._texts.typed()
        same = body.keyframes and (body.keyframes[-1].displacement, body.keyframes[-1].rotation) == (moved, turned)
        self._list.change(body if same else replace(body, keyframes=keyframes_to(scene, moved, turned)))
