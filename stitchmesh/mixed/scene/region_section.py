# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a scene has yarns: nowhere, everywhere, or in boxes and faces of the cloth.

``with_triangles`` and ``without_triangles`` add triangles to the region of a scene or take them out, as a brush does.
Boxes stay boxes as long as they keep all their triangles, so that a scene stays readable. A box that loses a triangle
is replaced by the numbers of its other triangles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.layout.spline_yarns import LaidYarns
from stitchmesh.settings import POSITIVE, check_settings, setting

ROUNDING = 1e-9
"""Distance from a box within which a point still lies in it [cm]."""


@dataclass(frozen=True, kw_only=True)
class BoxSection:
    """A box, in space at the start or in the coordinates of a panel.

    Raises:
        ParameterError: the numbers of coordinates differ from 3, or from 2 in a panel, or the box is empty.
    """

    low: tuple[float, ...]
    """Smallest coordinates [cm]: x, y, z in space at the start; x, y in a panel."""
    high: tuple[float, ...]
    """Largest coordinates [cm]."""
    panel: str | None = None
    """Name of the panel in whose coordinates the box lies; by default it lies in space."""

    def __post_init__(self) -> None:
        expected = 3 if self.panel is None else 2
        if len(self.low) != expected or len(self.high) != expected:
            where = "in space" if self.panel is None else "in a panel"
            raise ParameterError(f"box: got {len(self.low)} and {len(self.high)} numbers; expected {expected} {where}")
        if any(low > high for low, high in zip(self.low, self.high, strict=True)):
            raise ParameterError(f"box: got low {list(self.low)} above high {list(self.high)}; expected low below high")

    def __str__(self) -> str:
        """Return the box in words."""
        where = "in space" if self.panel is None else f"in panel {self.panel!r}"
        return f"box from {list(self.low)} to {list(self.high)} cm {where}"

    def holds(self, space: FloatArray, panel: IntArray, flat: FloatArray, names: tuple[str, ...]) -> NDArray[np.bool_]:
        """Return whether points lie in the box, shape (n,).

        Args:
            space: points in space [cm], shape (n, 3).
            panel: panel of each point, shape (n,).
            flat: points in their panel [cm], shape (n, 2).
            names: names of the panels.

        Raises:
            ParameterError: no panel has the name.
        """
        if self.panel is None:
            return _between(space, self.low, self.high)
        if self.panel not in names:
            raise ParameterError(f"box: panel: got {self.panel!r}; expected one of {', '.join(names)}")
        return _between(flat, self.low, self.high) & (panel == names.index(self.panel))


@dataclass(frozen=True, kw_only=True)
class RegionSection:
    """The region of interest: all boxes and faces together.

    Raises:
        ParameterError: a number is not positive, or ``automatic`` does not have exactly one of ``nodes`` and
            ``seconds``.
    """

    yarns: Literal["none", "chosen", "all", "automatic"] = setting(
        "chosen", "where yarns are simulated: none (nowhere), chosen (in the boxes and faces), all (everywhere), or "
        "automatic (where a run with triangles alone has the largest errors; boxes and faces limit the region)",
    )  # fmt: skip
    nodes: int | None = setting(
        None, "for automatic: largest number of simulated yarn nodes, including the hybrid region",
        unset="none", least=1, expected="a number of yarn nodes of at least 1",
    )  # fmt: skip
    seconds: float | None = setting(
        None, "instead of nodes: time of a step, or of an equilibrium; short runs measure how many nodes fit into it",
        unit="s", unset="none", **POSITIVE,
    )  # fmt: skip
    adapt_every: int | None = setting(
        None, "for automatic: number of steps, or of equilibria, after which the region may grow, shrink or move, "
        "where this pays; the run begins with triangles alone", unset="the region stays", least=1,
        expected="at least 1",
    )  # fmt: skip
    boxes: tuple[BoxSection, ...] = setting(
        (), "boxes in space (low, high) or in the coordinates of a panel; a triangle is chosen if its middle lies in a "
        "box",
    )  # fmt: skip
    faces: tuple[int, ...] = setting((), "numbers of chosen triangles")
    rings: int = setting(
        1, "width of the hybrid region around the chosen triangles, in rings of triangles", least=1,
        expected="at least 1",
    )  # fmt: skip
    start: Literal["layout", "triangles"] = setting(
        "layout", "layout: yarns begin as they are laid out; triangles: a static scene first runs with triangles alone "
        "through all load steps, and its yarns begin on the result",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self, "region")
        if self.yarns == "automatic" and (self.nodes is None) == (self.seconds is None):
            found = "neither region.nodes nor region.seconds" if self.nodes is None else "both nodes and seconds"
            raise ParameterError(f"region: got {found}; expected one of them with yarns = 'automatic'")

    @property
    def changes_every(self) -> int | None:
        """Number of steps or equilibria after which the region may change; None if it stays."""
        return self.adapt_every if self.yarns == "automatic" else None

    @property
    def grows_from_nothing(self) -> bool:
        """Whether the region begins with triangles alone, and grows while the run goes on."""
        return self.changes_every is not None and self.start == "layout"

    @property
    def starts_on_triangles(self) -> bool:
        """Whether there are yarns that begin on the equilibrium of the triangles."""
        return self.start == "triangles" and self.yarns != "none"

    def triangles(self, cloth: Cloth) -> IntArray:
        """Return the numbers of the triangles with yarns alone, ascending; none yet for ``automatic``.

        Raises:
            ParameterError: a box holds no triangle, or a triangle does not exist.
        """
        if self.yarns != "chosen":
            return np.arange(len(cloth.triangles) if self.yarns == "all" else 0)
        return self.named_triangles(cloth)

    def named_triangles(self, cloth: Cloth) -> IntArray:
        """Return the numbers of the triangles in the boxes and of the faces, ascending.

        Raises:
            ParameterError: a box holds no triangle, or a triangle does not exist.
        """
        wrong = [face for face in self.faces if not 0 <= face < len(cloth.triangles)]
        if wrong:
            found = f"got triangle {first_few(wrong)}"
            raise ParameterError(f"region.faces: {found}; expected 0 to {len(cloth.triangles) - 1}")
        parts = [np.array(self.faces, dtype=np.int64)]
        middle, flat = cloth.vertices[cloth.triangles].mean(axis=1), cloth.rest.mean(axis=1)
        for number, box in enumerate(self.boxes):
            held = np.flatnonzero(box.holds(middle, cloth.panel, flat, cloth.panel_names))
            if not len(held):
                low, high = _extent(cloth, box, middle, flat)
                raise ParameterError(
                    f"region.boxes[{number}]: {box}: holds no triangle of the cloth, whose triangles lie from "
                    f"{low} to {high} cm; expected a box that overlaps it"
                )
            parts.append(held)
        return np.unique(np.concatenate(parts))

    def placing_errors(self, cloth: Cloth, error: FloatArray) -> FloatArray:
        """Return the errors that choose an automatic region, shape (T,).

        Errors are zero where no yarns may be: outside the boxes and faces, if there are any.

        Args:
            cloth: the cloth.
            error: indicated error of each triangle, shape (T,).

        Raises:
            ParameterError: as ``named_triangles`` raises it.
        """
        if not self.boxes and not self.faces:
            return error
        return np.where(np.isin(np.arange(len(error)), self.named_triangles(cloth)), error, 0.0)

    def region(self, cloth: Cloth, yarns: LaidYarns) -> Region:
        """Return the region.

        Raises:
            ParameterError: as ``triangles`` raises it.
        """
        chosen = self.triangles(cloth)
        layout = cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric
        return region_around(*layout, chosen, rings=self.rings)


def _extent(cloth: Cloth, box: BoxSection, middle: FloatArray, flat: FloatArray) -> tuple[list[float], list[float]]:
    points = middle if box.panel is None else flat[cloth.panel == cloth.panel_names.index(box.panel)]
    return points.min(axis=0).round(3).tolist(), points.max(axis=0).round(3).tolist()


def _between(points: FloatArray, low: tuple[float, ...], high: tuple[float, ...]) -> NDArray[np.bool_]:
    between: NDArray[np.bool_] = np.logical_and(points >= np.array(low) - ROUNDING, points <= np.array(high) + ROUNDING)
    return np.logical_and.reduce(between, axis=1)


def marked_triangles(section: RegionSection, cloth: Cloth) -> IntArray:
    """Return the marked triangles, ascending: the triangles with yarns, or where an automatic region may be.

    Raises:
        ParameterError: as ``RegionSection.triangles`` raises it.
    """
    return section.named_triangles(cloth) if section.yarns == "automatic" else section.triangles(cloth)


def with_triangles(section: RegionSection, cloth: Cloth, triangles: ArrayLike) -> RegionSection:
    """Return a section that marks more triangles.

    A region of yarns nowhere or everywhere becomes a chosen region first. An automatic region stays automatic, and may
    then have yarns in the added triangles too.

    Args:
        section: the section.
        cloth: the cloth.
        triangles: numbers of triangles, shape (n,).

    Raises:
        ParameterError: a box holds no triangle.
    """
    chosen = _as_chosen(section, cloth)
    new = np.setdiff1d(np.asarray(triangles, dtype=np.int64), chosen.named_triangles(cloth))
    return replace(chosen, faces=_numbers(np.union1d(np.array(chosen.faces, dtype=np.int64), new)))


def without_triangles(section: RegionSection, cloth: Cloth, triangles: ArrayLike) -> RegionSection:
    """Return a section that does not mark some triangles, with the arguments of ``with_triangles``.

    Raises:
        ParameterError: a box holds no triangle.
    """
    chosen = _as_chosen(section, cloth)
    removed = np.asarray(triangles, dtype=np.int64)
    kept, faces = [], np.array(chosen.faces, dtype=np.int64)
    for box in chosen.boxes:
        held = RegionSection(boxes=(box,)).named_triangles(cloth)
        if np.isin(held, removed).any():
            faces = np.union1d(faces, held)
        else:
            kept.append(box)
    return replace(chosen, boxes=tuple(kept), faces=_numbers(np.setdiff1d(faces, removed)))


def _as_chosen(section: RegionSection, cloth: Cloth) -> RegionSection:
    """Return the section as one whose boxes and faces count."""
    if section.yarns == "none":
        return replace(section, yarns="chosen", boxes=(), faces=())
    if section.yarns == "all":
        return replace(section, yarns="chosen", boxes=(), faces=_numbers(section.triangles(cloth)))
    return section


def _numbers(triangles: IntArray) -> tuple[int, ...]:
    return tuple(triangles.tolist())
