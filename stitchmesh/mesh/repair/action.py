# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The changes that a repair may make, and the changes that it made, in numbers and in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stitchmesh.errors import ParameterError, described, first_few

SENTENCES = {
    "isolated vertices": ("vertex", "1 vertex without a face was removed", "{} vertices without a face were removed"),
    "repeated corners": ("face", "1 face that visits a vertex twice was corrected",
                         "{} faces that visit a vertex twice were corrected"),
    "faces without area": ("face", "1 face without area was removed", "{} faces without area were removed"),
    "folded faces": ("face", "1 face that crosses itself was divided into triangles",
                     "{} faces that cross themselves were divided into triangles"),
    "duplicate faces": ("face", "1 face with the same vertices as another face was removed",
                        "{} faces with the same vertices as other faces were removed"),
    "welded vertices": ("vertex", "1 vertex at the position of another vertex was welded to it",
                        "{} vertices at equal positions were welded"),
    "T-junctions": ("vertex", "1 vertex on a border edge of another face was joined to this edge",
                    "{} vertices on border edges of other faces were joined to these edges"),
    "crowded edges": ("edge", "1 edge with more than two faces was split",
                      "{} edges with more than two faces were split"),
    "shared vertices": ("vertex", "1 vertex in which separate parts of the surface met was split",
                        "{} vertices in which separate parts of the surface met were split"),
    "reversed faces": ("face", "1 face was reversed, so that it agrees with its neighbours",
                       "{} faces were reversed, so that they agree with their neighbours"),
    "small components": ("face", "1 very small separate component was removed",
                         "{} very small separate components were removed"),
    "filled holes": ("vertex", "1 hole was filled", "{} holes were filled"),
    "turned components": ("face", "1 component was turned, so that its faces point outwards",
                          "{} components were turned, so that their faces point outwards"),
}  # fmt: skip
"""Kind of the places of each action, its sentence for one place, and its sentence for several, in the order of
reports."""

Place = int | tuple[int, int]


@dataclass(frozen=True)
class RepairOptions:
    """What a repair may change.

    Raises:
        ParameterError: a length is negative or not a number, or the weld distance is not finite.
    """

    weld_distance: float | None = None
    """Border vertices up to this distance become one [cm]; 0 joins only vertices at equal positions. None stands for
    1e-6 of the diagonal of the bounding box, but at most 0.01 of the median length of an edge."""
    largest_hole: float = 0.0
    """Every hole with a smaller perimeter is filled [cm]; openings of a garment must be longer. At 0, the repair fills
    only holes of three sides whose perimeter is below 4 times the median length of an edge."""

    def __post_init__(self) -> None:
        for name in ("weld_distance", "largest_hole"):
            value = getattr(self, name)
            if value is None and name == "weld_distance":
                continue
            if not isinstance(value, int | float) or not value >= 0.0:
                raise ParameterError(f"{name}: got {described(value)}; expected a length of at least 0 cm")
        if self.weld_distance == math.inf:
            raise ParameterError("weld_distance: got inf; expected a finite length, below half the length of an edge")


@dataclass(frozen=True)
class RepairAction:
    """One kind of change."""

    name: str
    """A key of ``SENTENCES``."""
    count: int
    """Number of the vertices, faces, edges, components or holes that were changed."""
    where: tuple[Place, ...]
    """First of these places in the numbers of the input: vertices, faces, or the two vertices of edges. A hole has its
    first border vertex, a component its first face."""

    @property
    def text(self) -> str:
        """The change in one sentence: ``12 vertices at equal positions were welded``."""
        _, one, several = SENTENCES[self.name]
        return one if self.count == 1 else several.format(self.count)

    @property
    def places(self) -> str:
        """The places in words, for messages: ``vertex 4, 7, 9 (+12 more)``."""
        names = [f"{place[0]}-{place[1]}" if isinstance(place, tuple) else str(place) for place in self.where]
        listed = names + [""] * (self.count - len(names))  # Only the number of the others is shown.
        return f"{SENTENCES[self.name][0]} {first_few(listed, min(3, len(names)))}"


class ActionLog:
    """The changes so far; the same change in several passes is one action."""

    def __init__(self) -> None:
        """Start without a change."""
        self._places: dict[str, list[Place]] = {}

    def add(self, name: str, places: list[Place] | list[int] | list[tuple[int, int]]) -> None:
        """Note the places of a change; without a place there is no change."""
        if places:
            self._places.setdefault(name, []).extend(places)

    def actions(self) -> tuple[RepairAction, ...]:
        """Return the changes in the order of ``SENTENCES``, each with its places in ascending order."""
        found = [(name, sorted(self._places[name], key=_as_pair)) for name in SENTENCES if name in self._places]
        return tuple(RepairAction(name, len(places), tuple(places[:8])) for name, places in found)


def _as_pair(place: Place) -> tuple[int, int]:
    return place if isinstance(place, tuple) else (place, 0)
