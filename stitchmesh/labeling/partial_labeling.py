# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling step by step: a partly labeled mesh is a value, and each step returns a new value.

Steps never change the value that they start from, so that the old value is an exact undo.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import LabelError, ParameterError, check_kind
from stitchmesh.io.library_meshes import MeshLike, as_mesh
from stitchmesh.labeling.direction import in_knitting_frame, is_top, seam_sides, turned_rows
from stitchmesh.labeling.faults import LabelingFault, error_message, find_faults
from stitchmesh.labeling.growth import COURSE, UNKNOWN, UNLABELED, WALE, EdgeLabels, RowGrowth, no_labels
from stitchmesh.labeling.hand_labels import find_rows, with_edge_label
from stitchmesh.labeling.seeds import EdgeName, candidate_seeds, edge_name, seed_chain, side_of, whole_border
from stitchmesh.mesh import IntArray, Mesh, StitchMesh, frozen_array
from stitchmesh.mesh.courses import renumbered_rows
from stitchmesh.mesh.polygon_mesh import connected_faces
from stitchmesh.mesh.stitch import Stitch

NOT_HELD = -1
"""Direction of a row that the user has not flipped."""
EdgeLabel = Literal["course", "wale"]
"""Label that a user gives to an edge."""
LABELS: dict[str | None, int] = {"course": COURSE, "wale": WALE, None: UNKNOWN}
"""Numbers of the labels that a user gives."""


def start_labeling(mesh: MeshLike) -> PartialLabeling:
    """Return a labeling of a mesh on which no edge and no face is labeled.

    ``start_labeling(mesh).label_all().finish()`` is the result of ``label(mesh)``.

    Args:
        mesh: any oriented polygon mesh, as for ``label``.
    """
    mesh = as_mesh(mesh, place="start_labeling")
    rows = {"seeded": np.zeros(0, dtype=bool), "held_direction": np.zeros(0, dtype=np.int64)}
    return PartialLabeling(mesh=mesh, **vars(no_labels(mesh)), **rows)


@dataclass(frozen=True, eq=False, kw_only=True)
class PartialLabeling(EdgeLabels):
    """A partly labeled mesh (Yuksel et al. 2012, section 5.1).

    A face is labeled if it belongs to a row. A face that cannot be labeled is listed in ``faults`` with the reason, and
    the other faces keep their labels.

    Raises:
        LabelError: the arrays contradict each other.
    """

    mesh: Mesh
    """The mesh."""
    seeded: NDArray[np.bool_]
    """Whether each row keeps the direction in which it grew, as the row at a start does, shape (rows,)."""
    held_direction: IntArray
    """Direction of each row that the user has flipped: 0 as it grew, 1 reversed, -1 not flipped, shape (rows,)."""

    def __post_init__(self) -> None:
        for name in ("by_hand", "seeded"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.bool_))
        for name in ("edge_label", "row", "left_wale", "right_wale", "fault_side", "waiting", "held_direction"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        _check(self)

    @classmethod
    def of_rows(cls, labeled: StitchMesh) -> PartialLabeling:
        """Return the labeling of a labeled mesh, so that its rows can be flipped and its edges changed.

        ``finish`` returns the same mesh again. All rows keep their directions.

        Args:
            labeled: a mesh of panels, as ``label`` returns.

        Raises:
            ParameterError: the mesh is tessellated already.
        """
        stitches = np.flatnonzero(check_kind("of_rows", labeled, StitchMesh).stitch != Stitch.PANEL)
        if len(stitches):
            raise ParameterError(f"face {stitches[0]}: is a stitch already; reverse its row by the edit flip_row")
        row = np.unique(labeled.row, return_inverse=True)[1]
        labels = replace(
            no_labels(labeled), edge_label=np.where(labeled.is_wale[labeled.edge_side], WALE, COURSE), row=row,
            left_wale=labeled.left_wale, right_wale=labeled.right_wale,
        )  # fmt: skip
        seeded = np.ones(labels.row_count, dtype=bool)
        return cls(mesh=labeled, **vars(labels), seeded=seeded, held_direction=np.full(len(seeded), NOT_HELD))

    def __repr__(self) -> str:
        """The size of the labeling in one line."""
        labeled = f"{np.count_nonzero(self.labeled)} of {self.mesh.face_count} faces labeled"
        return f"PartialLabeling({self.row_count} rows, {labeled})"

    @property
    def labeled(self) -> NDArray[np.bool_]:
        """Whether each face is labeled, shape (F,)."""
        return self.row != UNLABELED

    @property
    def faults(self) -> tuple[LabelingFault, ...]:
        """The faces that cannot be labeled, with the reasons; faces that no row has reached yet are not listed."""
        return find_faults(self.mesh, self)

    @property
    def row_is_reversed(self) -> NDArray[np.bool_]:
        """Whether the wale direction of each row is opposite to the direction in which it grew, shape (rows,)."""
        turned = turned_rows(self.mesh, self, np.flatnonzero(self.seeded).tolist())
        return np.where(self.held_direction == NOT_HELD, turned, self.held_direction == 1)

    def start_at_border(self, edge: EdgeName) -> PartialLabeling:
        """Label all edges of a border as course edges, and grow the first row along it.

        Args:
            edge: any edge of the border.

        Raises:
            ParameterError: there is no such edge, or it does not lie on a border.
            LabelError: an edge of the border is a wale edge already.
        """
        return self._started(whole_border(self.mesh, edge))

    def start_at_edge(self, edge: EdgeName) -> PartialLabeling:
        """Label a chain of edges as course edges, and grow a row from it.

        Args:
            edge: an edge on a border stands for its border up to the next corners, an inner edge for the edge loop
                through it. The row grows on the left of the side or of the directed edge.

        Raises:
            ParameterError: there is no such edge.
            LabelError: an edge of the chain is a wale edge already.
        """
        return self._started(seed_chain(self.mesh, side_of(self.mesh, edge)))

    def label_rows(self, count: int = 1) -> PartialLabeling:
        """Label more rows, next to the rows that are labeled already; fewer if nothing else can be labeled.

        If nothing is labeled yet, or all faces that are joined with labeled faces have rows, the first row starts at
        the longest border without corners, else at the lowest border between two corners.

        Args:
            count: number of rows.

        Raises:
            ParameterError: the count is not positive, or nothing can be labeled.
        """
        if count < 1:
            raise ParameterError(f"rows: got {count}; expected at least 1")
        growth = RowGrowth(self.mesh, self)
        seeded: list[int] = []
        grown = growth.grow_rows(count)
        for chains in _untouched_parts(self.mesh, growth) if grown < count else ():
            row = growth.start(chains[0])
            if row is not None:
                seeded.append(row)
                grown += 1 + growth.grow_rows(count - grown - 1)
            if grown == count:
                break
        if not grown:
            raise ParameterError(_nothing_left(self))
        return self._after(growth, seeded)

    def label_row_at(self, edge: EdgeName) -> PartialLabeling:
        """Label one more row, with a labeled course edge at its bottom.

        Args:
            edge: a course edge between a labeled and an unlabeled face.

        Raises:
            ParameterError: there is no such edge, it is no course edge, or no face beside it can be labeled.
        """
        side = side_of(self.mesh, edge)
        sides = [s for s in (side, int(self.mesh.twin[side])) if s >= 0 and not self.labeled[self.mesh.side_face[s]]]
        if self.edge_label[self.mesh.side_edge[side]] != COURSE:
            name = edge_name(self.mesh, side)
            raise ParameterError(f"edge {name}: is not a labeled course edge, from which a row can start")
        growth = RowGrowth(self.mesh, self)
        if not any(growth.grow(s) for s in sides):
            name = edge_name(self.mesh, side)
            raise ParameterError(f"edge {name}: no row can be labeled here; {_nothing_left(self)}")
        return self._after(growth, [])

    def label_all(self) -> PartialLabeling:
        """Label all rows that can be labeled.

        Parts of the mesh without a labeled face are started as in ``label_rows``. If the rows from the first border of
        such a part contradict each other, the other borders are tried in turn.
        """
        growth = RowGrowth(self.mesh, self)
        growth.grow_rows()
        done = self._after(growth, [])
        if done.labeled.all():
            return done
        for chains in _untouched_parts(self.mesh, done):
            done = done._with_part(chains)
        return done

    def set_edge(self, edge: EdgeName, label: EdgeLabel | None) -> PartialLabeling:
        """Label one edge by hand; the rules of growth respect this label.

        A face becomes part of a row if all its edges are labeled and exactly two of them are wale edges, even if these
        are neighbours in a quad. A face that no longer has two wale edges loses its row, and ``faults`` lists it.

        Args:
            edge: the edge.
            label: ``"course"``, ``"wale"``, or None to clear the label.

        Raises:
            ParameterError: there is no such edge, or the label is unknown.
            LabelError: the edge cannot have this label because of other labels that were set by hand.
        """
        if label not in LABELS:
            raise ParameterError(f"label of edge {edge}: got {label!r}; expected course, wale, or none to clear it")
        labels = EdgeLabels(**{part.name: getattr(self, part.name) for part in fields(EdgeLabels)})
        changed = with_edge_label(self.mesh, labels, side_of(self.mesh, edge), LABELS[label])
        return self._regrouped(changed, self.seeded, self.held_direction)

    def flip_row(self, face: int) -> PartialLabeling:
        """Reverse the wale direction of a row; the directions of the other rows stay as they are.

        Args:
            face: any face of the row.

        Raises:
            ParameterError: the face does not exist or has no row.
        """
        if not 0 <= face < self.mesh.face_count:
            known = f"the mesh has faces 0 to {self.mesh.face_count - 1}"
            raise ParameterError(f"flip: face {face} does not exist; {known}")
        row = self.row[face]
        if row == UNLABELED:
            raise ParameterError(f"flip: face {face} has no row yet; label its row first")
        turned = turned_rows(self.mesh, self, np.flatnonzero(self.seeded).tolist())
        held = np.array(self.held_direction)
        reversed_now = turned[row] if held[row] == NOT_HELD else held[row] == 1
        held[row] = NOT_HELD if turned[row] != reversed_now else not reversed_now
        return self._replaced(self, self.seeded, held)

    def finish(self) -> StitchMesh:
        """Return the labeled mesh as a stitch mesh of ``Stitch.PANEL`` faces.

        Rows have the order of their growth. After flips, they are numbered again (``renumbered_rows``).

        Raises:
            LabelError: a face has no row; the message names faces and the reason.
        """
        if not self.labeled.all():
            raise LabelError(error_message(self.mesh, self, self.faults), labeling=self)
        left, right = self.directed_wales()
        return in_knitting_frame(self.mesh, left, right, self.row_number()[self.row])

    def directed_wales(self) -> tuple[IntArray, IntArray]:
        """Return the left and the right wale side of each face in its present wale direction, -1 without a row."""
        reversed_face = self.row_is_reversed[self.row] if self.row_count else np.zeros(self.mesh.face_count, dtype=bool)
        left = np.where(reversed_face, self.right_wale, self.left_wale)
        return left, np.where(reversed_face, self.left_wale, self.right_wale)

    def row_number(self) -> IntArray:
        """Return the number of each row in the finished mesh, shape (rows,)."""
        if (self.held_direction == NOT_HELD).all():
            return np.arange(self.row_count)
        below, above = self._matched_seams()
        flipped = self.row_is_reversed != turned_rows(self.mesh, self, np.flatnonzero(self.seeded).tolist())
        return renumbered_rows(below, above, flipped)

    def faces_of_row(self, number: int) -> IntArray:
        """Return the faces of a row by its number in the finished mesh, in ascending order, shape (n,).

        Raises:
            ParameterError: there is no such row.
        """
        if not 0 <= number < self.row_count:
            raise ParameterError(f"row {number}: does not exist; the mesh has {self.row_count} rows, counted from 0")
        return np.flatnonzero(self.labeled & (self.row_number()[self.row] == number))

    def _matched_seams(self) -> tuple[IntArray, IntArray]:
        """The rows below and above each seam edge at which the wale directions match, shape (n,) each."""
        left, right = self.directed_wales()
        sides = seam_sides(self.mesh, self)
        across = self.mesh.twin[sides]
        faces, others = self.mesh.side_face[sides], self.mesh.side_face[across]
        top, other_top = (is_top(self.mesh, some, left, right) for some in (sides, across))
        matched = top != other_top
        lower = np.where(top, self.row[faces], self.row[others])[matched]
        upper = np.where(top, self.row[others], self.row[faces])[matched]
        return lower, upper

    def mismatched_sides(self) -> IntArray:
        """Return one side of each edge at which the wale directions of two rows do not match."""
        left, right = self.directed_wales()
        sides = seam_sides(self.mesh, self)
        across = self.mesh.twin[sides]
        return sides[is_top(self.mesh, sides, left, right) == is_top(self.mesh, across, left, right)]

    def _started(self, chain: list[int]) -> PartialLabeling:
        """Start at a chain of sides.

        Raises:
            LabelError: an edge of the chain is a wale edge already.
        """
        wales = [side for side in chain if self.edge_label[self.mesh.side_edge[side]] == WALE]
        if wales:
            faces = " and ".join(str(self.mesh.side_face[s]) for s in (wales[0], self.mesh.twin[wales[0]]) if s >= 0)
            raise LabelError(
                f"face {faces}: edge {edge_name(self.mesh, wales[0])} would be both course and wale, because it is a "
                "wale edge already; start at another edge, or set this edge by hand first"
            )
        growth = RowGrowth(self.mesh, self)
        row = growth.start(chain)
        return self._after(growth, [] if row is None else [row])

    def _with_part(self, chains: list[list[int]]) -> PartialLabeling:
        """Label a part of the mesh from the first of these chains whose rows label the whole part, else from the first.

        All chains lie in one part of the mesh that has no labeled face.
        """
        first: PartialLabeling | None = None
        for chain in chains:
            growth = RowGrowth(self.mesh, self)
            row = growth.start(chain)
            growth.grow_rows()
            found = self._after(growth, [] if row is None else [row])
            if (found.fault_side == self.fault_side).all():
                return found
            first = first or found
        assert first is not None
        return first

    def _after(self, growth: RowGrowth, seeded: Iterable[int]) -> PartialLabeling:
        """The labeling with the labels of a growth, in which some new rows keep their direction."""
        more = growth.row_count - self.row_count
        kept = np.concatenate([self.seeded, np.zeros(more, dtype=bool)])
        kept[list(seeded)] = True
        held = np.concatenate([self.held_direction, np.full(more, NOT_HELD)])
        if growth.rows_met:
            return self._regrouped(growth.labels(), kept, held)
        return self._replaced(growth.labels(), kept, held)

    def _regrouped(self, labels: EdgeLabels, seeded: NDArray[np.bool_], held: IntArray) -> PartialLabeling:
        """The labeling after ``find_rows``; additional rows of ``labels`` are neither seeded nor held."""
        more = labels.row_count - len(seeded)
        labels, former = find_rows(self.mesh, labels)
        seeded = np.concatenate([seeded, np.zeros(max(more, 0), dtype=bool)])
        held = np.concatenate([held, np.full(max(more, 0), NOT_HELD)])
        return self._replaced(labels, seeded[former], held[former])

    def _replaced(self, labels: EdgeLabels, seeded: NDArray[np.bool_], held: IntArray) -> PartialLabeling:
        arrays = {part.name: getattr(labels, part.name) for part in fields(EdgeLabels)}
        for array in (*arrays.values(), seeded, held):
            array.setflags(write=False)  # The arrays are new, so that the constructor need not copy them.
        return PartialLabeling(mesh=self.mesh, **arrays, seeded=seeded, held_direction=held)


def _untouched_parts(mesh: Mesh, labels: EdgeLabels | RowGrowth) -> list[list[list[int]]]:
    """The chains of border sides, best first, of each part of the mesh without a labeled face and without a fault.

    Chains with an edge that the user has set to wale are left out.
    """
    part = connected_faces(mesh)
    touched = np.zeros(part.max() + 1, dtype=bool)
    touched[part[(labels.row >= 0) | (labels.fault_side >= 0)]] = True
    parts: dict[int, list[list[int]]] = {}
    for chain in () if touched.all() else candidate_seeds(mesh):
        number = int(part[mesh.side_face[chain[0]]])
        if not touched[number] and (labels.edge_label[mesh.side_edge[chain]] != WALE).all():
            parts.setdefault(number, []).append(chain)
    return list(parts.values())


def _nothing_left(labeling: PartialLabeling) -> str:
    """The message of a step that finds nothing to label."""
    rest = np.count_nonzero(~labeling.labeled)
    if rest == 0:
        return f"nothing is left to label: all {labeling.mesh.face_count} faces have rows"
    return f"nothing can be labeled: {error_message(labeling.mesh, labeling, labeling.faults)}"


def _check(labeling: PartialLabeling) -> None:
    """Check that the arrays of a labeling fit the mesh and each other.

    Raises:
        LabelError: the arrays do not fit.
    """
    mesh, rows = labeling.mesh, labeling.row_count
    counts = {"edge_label": len(mesh.edge_side), "by_hand": len(mesh.edge_side), "seeded": rows, "held_direction": rows}
    counts |= dict.fromkeys(("row", "left_wale", "right_wale", "fault_side"), mesh.face_count)
    for name, count in counts.items():
        if getattr(labeling, name).shape != (count,):
            raise LabelError(f"{name}: got shape {getattr(labeling, name).shape}; expected ({count},)")
    limits = {
        "edge_label": (UNKNOWN, WALE), "row": (UNLABELED, mesh.face_count - 1), "held_direction": (NOT_HELD, 1),
        "waiting": (0, mesh.side_count - 1), "fault_side": (UNLABELED, mesh.side_count - 1),
        "left_wale": (UNLABELED, mesh.side_count - 1), "right_wale": (UNLABELED, mesh.side_count - 1),
    }  # fmt: skip
    for name, (least, most) in limits.items():
        values = getattr(labeling, name)
        if values.size and (values.min() < least or values.max() > most):
            raise LabelError(f"{name}: got {values.min()} to {values.max()}; expected {least} to {most}")
    if rows and (np.bincount(labeling.row[labeling.labeled], minlength=rows) == 0).any():
        raise LabelError("row: got numbers with gaps; expected every row to have a face")
    _check_wales(labeling)


def _check_wales(labeling: PartialLabeling) -> None:
    """Check that the wale edges of each labeled face are its two wale sides.

    Raises:
        LabelError: a face is at fault.
    """
    mesh, faces = labeling.mesh, np.flatnonzero(labeling.labeled)
    is_wale = labeling.edge_label[mesh.side_edge] == WALE
    count = np.add.reduceat(is_wale, mesh.face_start[:-1], dtype=np.int64)[faces]
    unknown = np.add.reduceat(labeling.edge_label[mesh.side_edge] == UNKNOWN, mesh.face_start[:-1])[faces]
    left, right = labeling.left_wale[faces], labeling.right_wale[faces]
    own = (mesh.side_face[left] == faces) & (mesh.side_face[right] == faces) & (left != right)
    bad = faces[~own | ~is_wale[left] | ~is_wale[right] | (count != 2) | (unknown > 0)]
    if len(bad):
        raise LabelError(f"face {bad[0]}: its row does not fit the labels of its edges; label the mesh again")
