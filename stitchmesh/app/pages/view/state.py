# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The user's choices on the page, and the distance between two clicked places; the project keeps thing and colours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stitchmesh.app.controls.field_panel import Field, same_words
from stitchmesh.app.pages.view.opened import Thing
from stitchmesh.app.pages.view.thing_view import FACE_COLOURS, YARN_COLOURS, Place
from stitchmesh.app.scene.drawing import Labels, Lines
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mixed.drape import Draped
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.picking import length_between

DRAPED_COLOURS = {
    "Colours of the yarns": "yarn", "Alpha": "alpha", "Tension of the cloth": "cloth-tension",
    "Tension of the yarns": "yarn-tension", "One colour": "",
}  # fmt: skip
"""Colours of a run of mixed yarns and triangles in the words of the page, and the words of ``DrapedView``."""
COLOUR_FIELDS = {
    YarnSet: Field("yarn_colour", "Colour by", "What decides the colours of the yarns.",
                   same_words(tuple(YARN_COLOURS))),
    StitchMesh: Field("face_colour", "Colour faces by", "What decides the colours of the faces.",
                      same_words(tuple(FACE_COLOURS))),
    Draped: Field("run_colour", "Colour the run by", "What decides the colours of yarns and triangles.",
                  same_words(tuple(DRAPED_COLOURS))),
}  # fmt: skip
"""The field for the colours of each kind of thing."""
ONE_COLOUR = "#c9b89a"
"""The one colour at first."""
KEPT: Mapping[str, Mapping[str, str] | None] = {
    "show": None, "path": None, "yarn colour": YARN_COLOURS, "face colour": FACE_COLOURS, "run colour": DRAPED_COLOURS,
    "one colour": None,
}  # fmt: skip
"""The values that the project keeps, by their names there, with the words that each may be; None for any text."""


LINE, LABEL = "measured line", "measured length"
"""Names of the drawings."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """Two places; a third click begins again."""

    places: tuple[Place, ...] = ()
    """The clicked places, at most two."""

    def with_place(self, place: Place) -> Measurement:
        """Return the measurement after a click."""
        return Measurement((place,) if len(self.places) == 2 else (*self.places, place))

    def text(self, thing: Thing | None) -> str:
        """Return the measured distance in words, or what to do next."""
        if not self.places:
            return "Click the first place."
        if len(self.places) == 1:
            return f"{self.places[0].text}. Click the second place."
        along = self._along(thing)
        extra = "" if along is None else f"; {along:.2f} cm along the yarn"
        return f"{self.distance():.2f} cm{extra}"

    def distance(self) -> float:
        """Return the distance between the two places [cm]."""
        first, second = self.places
        return float(np.linalg.norm(second.point - first.point))

    def draw(self, scene: DrawingScene) -> None:
        """Draw the line between the places and its length; without two places, nothing."""
        if len(self.places) < 2:
            scene.remove(LINE)
            scene.remove(LABEL)
            return
        ends = np.stack([place.point for place in self.places])
        scene.show(LINE, Lines(ends[None], (224, 138, 30), 4.0))
        scene.show(LABEL, Labels(ends.mean(axis=0)[None], (f"{self.distance():.2f} cm",)))

    def _along(self, thing: Thing | None) -> float | None:
        first, second = (place.yarn for place in self.places)
        if not isinstance(thing, YarnSet) or first is None or second is None:
            return None
        return length_between(thing, first, second)


@dataclass(frozen=True, kw_only=True)
class ViewState:
    """The user's choices: what the page shows, and in which colours."""

    show: str = ""
    """Name of the visible thing in the list."""
    path: str = ""
    """Path of the last opened file or folder."""
    yarn_colour: str = "Rows"
    """What the colours of yarns show, a word of ``YARN_COLOURS``."""
    face_colour: str = "Stitch types"
    """What the colours of faces show, a word of ``FACE_COLOURS``."""
    run_colour: str = "Colours of the yarns"
    """What the colours of a run show, a word of ``DRAPED_COLOURS``."""
    one_colour: str = ONE_COLOUR
    """The one colour of everything."""
    body: Mesh | None = None
    """The body from which distances are measured."""
    shares: Mapping[str, float] = field(default_factory=dict)
    """Place of each side of the clip box that the user has moved [% of the thing]."""
    measurement: Measurement = field(default_factory=Measurement)
    """The two places of a measurement."""

    @classmethod
    def of_table(cls, table: Mapping[str, Any]) -> ViewState:
        """Return the state from a project's table; unknown words are left out."""
        known = {
            name: table[name]
            for name, words in KEPT.items()
            if isinstance(table.get(name), str) and (words is None or table[name] in words)
        }
        return cls(**{name.replace(" ", "_"): value for name, value in known.items()})

    @property
    def table(self) -> dict[str, str]:
        """The part of the state that a project keeps."""
        return {name: getattr(self, name.replace(" ", "_")) for name in KEPT}

    def colour_word(self, thing: Thing | None) -> str:
        """Return what the colours of a thing show, as a word of the library, or one colour."""
        if isinstance(thing, YarnSet):
            return YARN_COLOURS[self.yarn_colour] or self.one_colour
        if isinstance(thing, Draped):
            return DRAPED_COLOURS[self.run_colour] or self.one_colour
        if isinstance(thing, StitchMesh):
            return FACE_COLOURS[self.face_colour] or self.one_colour
        return self.one_colour
