# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labels that the user gives to single edges, and the rows that follow from them.

A face belongs to a row if all its edges are labeled and exactly two of them are wale edges; the two may be neighbours.
A row is a set of faces that are joined by wale edges. A new label can therefore complete a face, take a face out of its
row, divide a row and join two rows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import LabelError
from stitchmesh.labeling.growth import COURSE, UNKNOWN, UNLABELED, WALE, EdgeLabels
from stitchmesh.labeling.seeds import edge_name
from stitchmesh.mesh import BORDER, IntArray, Mesh, ranges
from stitchmesh.mesh.connectivity import ParityForest, linked_groups

LABEL_NAMES = {COURSE: "course", WALE: "wale", UNKNOWN: "unknown"}
"""Names of the labels in messages."""


def with_edge_label(mesh: Mesh, labels: EdgeLabels, side: int, label: int) -> EdgeLabels:
    """Return labels in which the user has labeled one edge; ``UNKNOWN`` clears the label.

    The rows of the result must be found again with ``find_rows``, because rows may be divided or joined.

    Raises:
        LabelError: the label contradicts other labels that the user has set.
    """
    edge = mesh.side_edge[side]
    faces = [int(mesh.side_face[s]) for s in (side, int(mesh.twin[side])) if s != BORDER]
    edge_label, by_hand = np.array(labels.edge_label), np.array(labels.by_hand)
    edge_label[edge], by_hand[edge] = label, label != UNKNOWN
    changed = replace(labels, edge_label=edge_label, by_hand=by_hand)
    for face in faces:
        _check_hand_labels(mesh, changed, face, side)
    return _with_faces_examined(mesh, changed, np.array(faces))


def _check_hand_labels(mesh: Mesh, labels: EdgeLabels, face: int, side: int) -> None:
    """Raise an error if a face cannot have two wale edges with the labels that the user has set."""
    edges = mesh.side_edge[mesh.face_start[face] : mesh.face_start[face + 1]]
    wales = np.count_nonzero(labels.by_hand[edges] & (labels.edge_label[edges] == WALE))
    courses = np.count_nonzero(labels.by_hand[edges] & (labels.edge_label[edges] == COURSE))
    name = LABEL_NAMES[int(labels.edge_label[mesh.side_edge[side]])]
    ends = edge_name(mesh, side)
    if wales > 2:
        raise LabelError(
            f"edge {ends}: cannot be {name}, because two other edges of face {face} have been set to wale by hand; "
            "clear one of them first"
        )
    if len(edges) - courses < 2:
        raise LabelError(
            f"edge {ends}: cannot be {name}, because face {face} would have {len(edges) - courses} wale edges left and "
            "needs 2; clear another of its edges first"
        )


def _with_faces_examined(mesh: Mesh, labels: EdgeLabels, faces: IntArray) -> EdgeLabels:
    """Return labels in which these faces have rows if their edges permit it, and wait for a row otherwise."""
    row, left, right = np.array(labels.row), np.array(labels.left_wale), np.array(labels.right_wale)
    fault = np.array(labels.fault_side)
    fault[faces] = UNLABELED
    for face in faces.tolist():
        sides = np.arange(mesh.face_start[face], mesh.face_start[face + 1])
        known = labels.edge_label[mesh.side_edge[sides]]
        wales = sides[known == WALE]
        if (known == UNKNOWN).any() or len(wales) != 2:
            row[face] = left[face] = right[face] = UNLABELED
        elif row[face] == UNLABELED:
            row[face] = row.max() + 1  # The face gets its own row, which `find_rows` joins with the rows beside it.
            left[face], right[face] = wales
    around = ranges(mesh.face_start, faces)
    around = np.concatenate([around, mesh.twin[around]])
    around = around[around != BORDER]
    across = mesh.twin[around]
    known_neighbour = (across != BORDER) & (row[mesh.side_face[across]] >= 0)
    around = around[(row[mesh.side_face[around]] == UNLABELED) & known_neighbour]
    return replace(
        labels, row=row, left_wale=left, right_wale=right, fault_side=fault,
        waiting=np.concatenate([labels.waiting[row[mesh.side_face[labels.waiting]] < 0], around]),
    )  # fmt: skip


def find_rows(mesh: Mesh, labels: EdgeLabels) -> tuple[EdgeLabels, IntArray]:
    """Find the rows again: faces joined by wale edges get one row, and rows are numbered without gaps.

    A row gets the direction and the rank of the first row that it contains.

    Returns:
        The labels, and for each row of the result the row of ``labels`` whose direction it has, shape (rows,).
    """
    if labels.row_count == 0:
        return labels, np.zeros(0, dtype=np.int64)
    labeled = np.flatnonzero(labels.row >= 0)
    pairs = np.concatenate([_wale_neighbours(mesh, labels, wale)[:2] for wale in _wales(labels)], axis=1)
    component = linked_groups(mesh.face_count, *pairs)
    _, component = np.unique(component[labeled], return_inverse=True)
    first_row = np.full(component.max() + 1, mesh.face_count)
    np.minimum.at(first_row, component, labels.row[labeled])
    first_face = np.full(len(first_row), mesh.face_count)
    np.minimum.at(first_face, component, labeled)
    order = np.lexsort((first_face, first_row))
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    row = np.full(mesh.face_count, UNLABELED)
    row[labeled] = number[component]
    turned = np.zeros(mesh.face_count, dtype=bool)
    row_turned = _turned_to_agree(mesh, labels)
    turned[labeled] = row_turned[labels.row[labeled]] ^ row_turned[first_row[component]]
    left, right = np.where(turned, _wales(labels)[::-1], _wales(labels))
    return replace(labels, row=row, left_wale=left, right_wale=right), first_row[order]


def _wales(labels: EdgeLabels) -> tuple[IntArray, IntArray]:
    return labels.left_wale, labels.right_wale


def _wale_neighbours(mesh: Mesh, labels: EdgeLabels, wale: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return labeled faces, the labeled faces across their wale sides ``wale`` (F,), and the sides of the latter."""
    faces = np.flatnonzero(labels.row >= 0)
    across = mesh.twin[wale[faces]]
    joined = (across != BORDER) & (labels.row[mesh.side_face[across]] >= 0)
    return faces[joined], mesh.side_face[across[joined]], across[joined]


def _turned_to_agree(mesh: Mesh, labels: EdgeLabels) -> NDArray[np.bool_]:
    """Whether each row must be turned to have the direction of the first row that it is joined with, shape (rows,)."""
    forest = ParityForest(labels.row_count)
    for wale in _wales(labels):
        first, second, across = _wale_neighbours(mesh, labels, wale)
        same = (wale is labels.left_wale) == (labels.left_wale[second] == across)
        rows = np.stack([labels.row[first], labels.row[second], same], axis=1)
        for one, other, differ in np.unique(rows[rows[:, 0] != rows[:, 1]], axis=0).tolist():
            forest.join(min(one, other), max(one, other), differ)
    found = [forest.find(row) for row in range(labels.row_count)]
    leading: dict[int, int] = {}
    return np.array([parity ^ leading.setdefault(root, parity) for root, parity in found], dtype=bool)
