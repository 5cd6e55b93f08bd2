# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The distance between two places that the user has clicked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.app.pages.view.thing_view import Place
from stitchmesh.app.pages.view.viewed import Thing
from stitchmesh.app.scene.drawing import Labels, Lines
from stitchmesh.app.scene.scene import Scene
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.picking import length_between

LINE, LABEL = "measured line", "measured length"
"""Names of the drawings."""
LINE_COLOUR = (224, 138, 30)


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

    def draw(self, scene: Scene) -> None:
        """Draw the line between the places and its length; without two places, nothing."""
        if len(self.places) < 2:
            scene.remove(LINE)
            scene.remove(LABEL)
            return
        ends = np.stack([place.point for place in self.places])
        scene.show(LINE, Lines(ends[None], LINE_COLOUR, 4.0))
        scene.show(LABEL, Labels(ends.mean(axis=0)[None], (f"{self.distance():.2f} cm",)))

    def _along(self, thing: Thing | None) -> float | None:
        first, second = (place.yarn for place in self.places)
        if not isinstance(thing, YarnSet) or first is None or second is None:
            return None
        return length_between(thing, first, second)
