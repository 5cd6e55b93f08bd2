# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures of a labeled mesh, and the mesh scaled to other measures.

A girth is the length of a ring of course sides, and a length is counted along the wales of a tube or along an axis of
the garment. Which measures a garment has follows from its borders and its tubes (``stitchmesh.selection.parts``):

    girth                       the widest ring of the tube above the hem, or of a mitten from its cuff
    head, hand                  the girth of a hat, of a mitten
    waist                       its narrowest ring, if the tube is wider on both sides
    chest, bust                 the widest ring above the waist; without a waist the girth, if it is not the hem
    hem, neck, cuff, wrist      the borders
    upper arm, sleeve length    the widest ring of the sleeves, and their length from the cuff to the body
    length                      the height of the garment without its sleeves
    foot, leg                   of a tube that turns forward, as a sock: the median ring of the foot, the cuff
    foot length, leg length     from heel to toe, and from the sole to the cuff

The mesh is scaled by a smooth field. Each row of panels has a factor g around it and a factor h along it. The factors g
are given at the rings of the measures; between them they are harmonic on the graph of the rows. The side e of a face in
a row with the unit axis a should become

    S e,    S = g (I - a a^T) + h a a^T,

and the new vertices are those whose sides are nearest to these vectors, in the sense of least squares. A cylinder is
scaled exactly. The factors are corrected until the mesh has the measures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import splu

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.selection.borders import Border, named_borders
from stitchmesh.selection.parts import Parts

LARGEST_FACTOR = 4.0
"""Largest quotient of a measure and the measure of the mesh, and of its inverse."""
ROUNDS = 60
"""Largest number of corrections of the factors."""
NEAR, CLOSE = 1e-4, 0.02
"""Relative error at which the corrections end, and the largest one that is accepted."""


@dataclass(frozen=True, eq=False)
class Girth:
    """The length of a ring of course sides, the mean of several rings if there are, such as both cuffs."""

    rings: tuple[IntArray, ...]
    """The sides of each ring."""
    rows: tuple[int, ...]
    """Indices of the rows at the rings."""

    def of(self, mesh: StitchMesh) -> float:
        """Return the measure of a mesh with the same sides [cm]."""
        return float(np.mean([mesh.side_length[ring].sum() for ring in self.rings]))


@dataclass(frozen=True, eq=False)
class Length:
    """A length along tubes, the mean of several tubes, or the extent of rows along an axis."""

    tubes: tuple[tuple[int, ...], ...]
    """Indices of the rows of each tube; the rows together decide how many courses the length has."""
    axis: int | None = None
    """Axis of an extent; None for a length along the wales of the tubes."""
    part: FloatArray | None = None
    """How far the length counts in each row, 0 to 1, shape (R,); 1 in the rows of the tubes if it is None."""

    def of(self, mesh: StitchMesh, row_index: IntArray) -> float:
        """Return the measure of a mesh with the same rows [cm]."""
        if self.axis is None:
            heights = row_heights(mesh, row_index)
            return float(np.mean([heights[list(tube)].sum() for tube in self.tubes]))
        faces = np.flatnonzero(np.isin(row_index, self.tubes[0]))
        corners = mesh.face_vertex[mesh.sides_of(faces)]
        return float(np.ptp(mesh.vertices[corners, self.axis]))


def row_heights(mesh: StitchMesh, row_index: IntArray) -> FloatArray:
    """Return the mean height of the faces of each row along their wales [cm], shape (R,)."""
    heights = (mesh.side_length[mesh.left_wale] + mesh.side_length[mesh.right_wale]) / 2
    count = int(row_index.max()) + 1
    return np.bincount(row_index, heights, count) / np.bincount(row_index, minlength=count)


class GarmentMeasures:
    """The measures of a labeled mesh."""

    def __init__(self, labeled: StitchMesh) -> None:
        """Find the measures that the mesh has; y points up and the wearer looks along +z."""
        self.labeled = labeled
        self.parts = Parts(labeled)
        self.row_index = self.parts.row_index

    @cached_property
    def axis(self) -> FloatArray:
        """Unit axis of each row: the normal of its ring, or the mean direction of the wales of an open row."""
        mesh, parts, count = self.labeled, self.parts, len(self.parts.row_numbers)
        left = mesh.left_wale
        wale = mesh.corner_position[left] - mesh.corner_position[mesh.side_next[left]]  # the left wale side runs down
        mean = np.stack([np.bincount(self.row_index, wale[:, k], count) for k in range(3)], axis=1)
        return unit_vectors(np.where(parts.runs_around[:, None], parts.row_axis, mean))

    @cached_property
    def known(self) -> dict[str, Girth | Length]:
        """The measures by name; measures with several names occur under each of them."""
        found: dict[str, Girth | Length] = {}
        borders = self.parts.borders
        for name in ("hem", "neck", "cuff"):
            ends = named_borders(borders, name, None)
            if ends:
                found[name] = Girth(tuple(end.sides for end in ends), tuple(self._row_at(end) for end in ends))
        if "cuff" in found:
            found["wrist"] = found["cuff"]
        found |= self._sleeves()
        start = named_borders(borders, "hem", None)
        if not start and "sleeve length" not in found:
            start = named_borders(borders, "cuff", None)
        if not start:
            return found
        tube, _ = self.parts.tube_from(start[0])
        if self._turns(tube):
            return found | self._foot(tube)
        return found | self._body(tube)

    def measure(self, name: str) -> Girth | Length:
        """Return the measure of a name.

        Raises:
            ParameterError: the garment has no such measure.
        """
        if name not in self.known:
            known = ", ".join(self.known) or "none: its borders have no names"
            raise ParameterError(f"measure {name[:40]!r}: this garment does not have it; expected one of {known}")
        return self.known[name]

    def value(self, name: str, mesh: StitchMesh | None = None) -> float:
        """Return the value of a measure [cm], of the labeled mesh or of one with the same sides.

        Raises:
            ParameterError: the garment has no such measure.
        """
        measure, mesh = self.measure(name), mesh or self.labeled
        return measure.of(mesh) if isinstance(measure, Girth) else measure.of(mesh, self.row_index)

    def scaled(self, wanted: Mapping[str, float]) -> StitchMesh:
        """Return the labeled mesh scaled to measures; what no measure names keeps its size.

        Args:
            wanted: the measures [cm] by name.

        Raises:
            ParameterError: the garment has no such measure, a measure is far from that of the mesh, or they contradict
                each other.
        """
        measures = {name: self.measure(name) for name in wanted}
        factor = {}
        for name, value in wanted.items():
            factor[name] = value / self.value(name)
            if not 1.0 / LARGEST_FACTOR <= factor[name] <= LARGEST_FACTOR:
                own = self.value(name)
                low, high = own / LARGEST_FACTOR, own * LARGEST_FACTOR
                raise ParameterError(
                    f"{name}: got {value:.4g} cm, but the mesh has {own:.4g} cm; expected {low:.3g} to {high:.3g} cm"
                )
        mesh, error = self.labeled, 0.0
        for _ in range(ROUNDS):
            mesh = replace(self.labeled, vertices=self._vertices(measures, factor))
            ratio = {name: wanted[name] / self.value(name, mesh) for name in wanted}
            error = max(abs(part - 1.0) for part in ratio.values())
            if error < NEAR:
                return mesh
            factor = {name: float(np.clip(factor[name] * ratio[name], 0.05, 20.0)) for name in wanted}
        if error > CLOSE:
            worst = max(ratio, key=lambda name: abs(ratio[name] - 1.0))
            reached = wanted[worst] / ratio[worst]
            raise ParameterError(
                f"{worst}: got {wanted[worst]:.4g} cm together with the other measures, but they contradict each other "
                f"on this mesh, which comes to {reached:.4g} cm; change or leave out one of {', '.join(wanted)}"
            )
        return mesh

    def _row_at(self, border: Border) -> int:
        return int(np.bincount(self.row_index[self.labeled.side_face[border.sides]]).argmax())

    def _rings(self, row: int) -> list[IntArray]:
        """The bottom sides and the top sides of a row; those that it has."""
        role, of_row = self.labeled.side_role, self.row_index[self.labeled.side_face] == row
        rings = [np.flatnonzero(of_row & (role == part)) for part in (BOTTOM, TOP)]
        return [ring for ring in rings if len(ring)]

    def _levels(self, tube: Sequence[int]) -> list[tuple[float, IntArray, int]]:
        """The rings of a tube, each with its length and its row, without rings that also belong to rows outside."""
        inside, mesh = set(tube), self.labeled
        found = []
        for row in tube:
            for ring in self._rings(row):
                across = mesh.twin[ring]
                others = set(self.row_index[mesh.side_face[across[across != BORDER]]].tolist())
                if len(others) <= 1 and (others <= inside or not others or row == tube[-1]):
                    found.append((float(mesh.side_length[ring].sum()), ring, row))
        return found

    def _sleeves(self) -> dict[str, Girth | Length]:
        """The measures of the sleeves; none without sleeves."""
        tubes = [self.parts.tube_from(border) for border in named_borders(self.parts.borders, "cuffs", None)]
        sleeves = [tuple(rows) for rows, meets_body in tubes if meets_body]
        if not sleeves or not named_borders(self.parts.borders, "hem", None):
            return {}
        widest = [max(self._levels(rows), key=lambda level: level[0]) for rows in sleeves]
        return {
            "upper arm": Girth(tuple(ring for _, ring, _ in widest), tuple(row for _, _, row in widest)),
            "sleeve length": Length(tuple(sleeves)),
        }

    def _body(self, tube: list[int]) -> dict[str, Girth | Length]:
        levels = self._levels(tube)
        widths = [width for width, _, _ in levels]
        girths = {"girth": int(np.argmax(widths))}
        # A waist is narrower than the tube on both sides of it by at least this part.
        waists = [one for one in range(1, len(levels) - 1)
                  if widths[one] < 0.95 * min(max(widths[:one]), max(widths[one + 1 :]))]  # fmt: skip
        if "hem" not in self._border_names:
            girths["hand"] = girths["girth"]
        elif "tip" in self._border_names:
            girths["head"] = girths["girth"]
        elif waists:
            girths["waist"] = min(waists, key=lambda one: widths[one])
            girths["chest"] = max(range(girths["waist"] + 1, len(levels)), key=lambda one: widths[one])
        elif girths["girth"] > 0:
            girths["chest"] = girths["girth"]
        if "chest" in girths:
            girths["bust"] = girths["chest"]
        made = {place: Girth((levels[place][1],), (levels[place][2],)) for place in set(girths.values())}
        found: dict[str, Girth | Length] = {name: made[place] for name, place in girths.items()}
        sleeve = set(self.parts.sleeve_rows(None).tolist()) if "hem" in self._border_names else set()
        rows = tuple(row for row in range(len(self.parts.row_numbers)) if row not in sleeve)
        found["length"] = Length((rows,), axis=1)
        return found

    @cached_property
    def _border_names(self) -> set[str]:
        return {border.name for border in self.parts.borders}

    def _turns(self, tube: list[int]) -> bool:
        """Whether a tube turns forward, as a sock does at its heel, by at least half a right angle."""
        first, last = self.axis[tube[0]], self.axis[tube[-1]]
        return abs(float(first @ last)) < np.sqrt(0.5) and len(tube) == len(self.parts.row_numbers)

    def _foot(self, tube: list[int]) -> dict[str, Girth | Length]:
        levels, forward = self._levels(tube), self.axis[:, 2] ** 2
        foot = sorted((level for level in levels if forward[level[2]] > 0.5), key=lambda level: level[0])
        middle = foot[len(foot) // 2]
        cuff = named_borders(self.parts.borders, "cuff", None) + named_borders(self.parts.borders, "hem", None)
        return {
            "foot": Girth((middle[1],), (middle[2],)),
            "leg": Girth((cuff[0].sides,), (self._row_at(cuff[0]),)),
            "foot length": Length((tuple(tube),), axis=2, part=forward),
            "leg length": Length((tuple(tube),), axis=1, part=1.0 - forward),
        }

    def _vertices(self, measures: Mapping[str, Girth | Length], factor: Mapping[str, float]) -> FloatArray:
        """Return the vertices for factors of the measures [cm], shape (V, 3)."""
        count = len(self.parts.row_numbers)
        fixed: dict[int, list[float]] = {}
        along = np.ones(count)
        for name, measure in measures.items():
            if isinstance(measure, Girth):
                for row in measure.rows:
                    fixed.setdefault(row, []).append(factor[name])
                continue
            part = np.zeros(count) if measure.part is None else measure.part
            for tube in measure.tubes if measure.part is None else ():
                part[list(tube)] = 1.0
            along += part * (factor[name] - 1.0)
        around = self._harmonic({row: float(np.mean(values)) for row, values in fixed.items()})
        across = around[self.row_index]
        outer = self.axis[self.row_index][:, :, None] * self.axis[self.row_index][:, None, :]
        scale = across[:, None, None] * (np.eye(3) - outer) + along[self.row_index][:, None, None] * outer
        mesh = self.labeled
        start, end = mesh.corner_position, mesh.corner_position[mesh.side_next]
        target = np.einsum("sij,sj->si", scale[mesh.side_face], end - start)
        return self._from_sides(target)

    def _harmonic(self, fixed: Mapping[int, float]) -> FloatArray:
        """Return the factor of each row, the mean of the rows beside it where it is not given; 1 if none is given."""
        beside = self.parts.rows_beside
        values = np.ones(len(beside))
        if not fixed:
            return values
        matrix, right = np.zeros((len(beside), len(beside))), np.zeros(len(beside))
        for row, others in enumerate(beside):
            matrix[row, row] = 1.0 if row in fixed or not others else len(others)
            right[row] = fixed.get(row, 0.0 if others else 1.0)
            if row not in fixed:
                matrix[row, others] = -1.0
        # Rows that no given row reaches keep their size.
        for row in np.flatnonzero(~self._reached(fixed)).tolist():
            matrix[row], right[row] = np.eye(len(beside))[row], 1.0
        return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)

    def _reached(self, fixed: Mapping[int, float]) -> NDArray[np.bool_]:
        reached = np.zeros(len(self.parts.rows_beside), dtype=bool)
        front = list(fixed)
        reached[front] = True
        while front:
            for row in self.parts.rows_beside[front.pop()]:
                if not reached[row]:
                    reached[row] = True
                    front.append(row)
        return reached

    @cached_property
    def _solver(self) -> tuple[Callable[[FloatArray], FloatArray], csr_array]:
        """Solver of the normal equations of the sides with vertex 0 held, and the differences along the sides."""
        mesh = self.labeled
        sides = np.arange(mesh.side_count)
        rows = np.concatenate([sides, sides])
        columns = np.concatenate([mesh.face_vertex[mesh.side_next], mesh.face_vertex])
        values = np.concatenate([np.ones(mesh.side_count), -np.ones(mesh.side_count)])
        difference = coo_array((values, (rows, columns)), shape=(mesh.side_count, len(mesh.vertices))).tocsr()
        normal = (difference.T @ difference).tolil()
        from scipy.sparse.csgraph import connected_components

        _, piece = connected_components(normal.tocsr(), directed=False)
        for first in np.unique(piece, return_index=True)[1].tolist():
            normal[first, first] += 1.0  # It holds one vertex of each piece, because sides know no place.
        return splu(normal.tocsc()).solve, difference

    def _from_sides(self, target: FloatArray) -> FloatArray:
        """Return the vertices whose sides are nearest to vectors, above the same place as before."""
        solve, difference = self._solver
        found = np.asarray(solve(difference.T @ target))
        before = self.labeled.vertices
        place = before.mean(axis=0) - found.mean(axis=0)
        place[1] = before[:, 1].min() - found[:, 1].min()
        return found + place
