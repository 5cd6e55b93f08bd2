# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling steps as data: a name, and arguments that JSON can hold, so that a labeling can be saved and repeated.

A user also makes a step by pointing at a face: at a border to start the first row, and at further faces to make the
next rows (Yuksel et al. 2012, figure 11).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError, StitchMeshError, check_kind
from stitchmesh.io.contents import FilePath
from stitchmesh.io.named_steps import check_step_name, checked_arguments_of, plain_arguments
from stitchmesh.io.step_log import read_step_log, write_step_log
from stitchmesh.labeling.growth import COURSE, UNKNOWN
from stitchmesh.labeling.partial_labeling import PartialLabeling, start_labeling
from stitchmesh.mesh import BORDER, IntArray, Mesh
from stitchmesh.mesh.orientation import turn_inside_out


@dataclass(frozen=True)
class LabelStep:
    """One step of the labeling of a mesh.

    Raises:
        ParameterError: the arguments are not given by name.
    """

    name: str
    """A key of ``LABEL_STEPS``."""
    arguments: Mapping[str, object] = field(default_factory=dict)
    """Arguments of the step by name: numbers, texts and lists of numbers. NumPy numbers and tuples become numbers and
    lists when the step is made."""

    def __post_init__(self) -> None:
        arguments = plain_arguments(f"step {self.name!r}", self.arguments, '{"edge": [3, 4]}')
        object.__setattr__(self, "arguments", arguments)


def clear_labels(labeling: PartialLabeling) -> PartialLabeling:
    """Remove all labels."""
    return start_labeling(labeling.mesh)


def turned_inside_out(labeling: PartialLabeling) -> PartialLabeling:
    """Remove all labels, and reverse all faces of the mesh, so that its other side is outside."""
    return start_labeling(turn_inside_out(labeling.mesh))


LABEL_STEPS: dict[str, Callable[..., PartialLabeling]] = {
    "start_at_border": PartialLabeling.start_at_border,
    "start_at_edge": PartialLabeling.start_at_edge,
    "label_rows": PartialLabeling.label_rows,
    "label_row_at": PartialLabeling.label_row_at,
    "label_all": PartialLabeling.label_all,
    "set_edge": PartialLabeling.set_edge,
    "flip_row": PartialLabeling.flip_row,
    "clear_labels": clear_labels,
    "turn_inside_out": turned_inside_out,
}
"""Function of each step, by name. It takes a labeling and the arguments, and returns the new labeling."""


def apply_label_step(labeling: PartialLabeling, step: LabelStep) -> PartialLabeling:
    """Take a step of the labeling of a mesh, and return the new labeling; the given labeling stays unchanged.

    Args:
        labeling: a partly labeled mesh.
        step: the step.

    Raises:
        ParameterError: the step is unknown; an argument is missing, unknown or of another type; an argument names an
            edge or a face that does not exist or at which the step is not possible.
        LabelError: the step contradicts the labels of the mesh.
    """
    check_kind("apply_label_step", labeling, PartialLabeling, "sm.start_labeling(mesh)")
    check_kind("apply_label_step, step", step, LabelStep, "sm.LabelStep(name, arguments)")
    arguments = _checked_arguments(step)
    return LABEL_STEPS[step.name](labeling, **arguments)


def replay_label_steps(mesh: Mesh, steps: Iterable[LabelStep]) -> PartialLabeling:
    """Take steps one after another on a mesh without labels.

    Args:
        mesh: the mesh.
        steps: the steps, such as those that ``read_label_steps`` returns.

    Raises:
        StitchMeshError: as for ``apply_label_step``; the message begins with the number of the step and its name.
    """
    labeling = start_labeling(mesh)
    for number, step in enumerate(steps, start=1):
        try:
            labeling = apply_label_step(labeling, step)
        except StitchMeshError as error:
            raise type(error)(f"step {number}: {step.name}: {error}") from error
    return labeling


def write_label_steps(path: FilePath, steps: Iterable[LabelStep]) -> None:
    """Write steps as a text file with one JSON object in each line, ``{"step": NAME, "arguments": {...}}``.

    Raises:
        FileError: the file cannot be written.
    """
    write_step_log(path, "step", [(step.name, step.arguments) for step in steps])


def read_label_steps(path: FilePath) -> list[LabelStep]:
    """Read steps that ``write_label_steps`` has written; the names and the types of the arguments are checked.

    Raises:
        FileError: the file cannot be read, or a line is not a valid step; the message names the line.
    """
    return read_step_log(path, "step", _step)


def _step(name: str, arguments: dict[str, Any]) -> LabelStep:
    step = LabelStep(name, arguments)
    _checked_arguments(step)
    return step


def _checked_arguments(step: LabelStep) -> dict[str, Any]:
    """Return all arguments of a step.

    Raises:
        ParameterError: the step is unknown, or an argument is missing, unknown or of another type.
    """
    check_step_name("step", step.name, LABEL_STEPS)
    try:
        return checked_arguments_of(LABEL_STEPS[step.name], step.arguments)
    except ParameterError as error:
        raise ParameterError(f"step {step.name}: {error}") from error


def pointed_step(labeling: PartialLabeling, side: int) -> LabelStep:
    """Return the step that grows a row where a user points.

    - A face without a row that touches a labeled course edge gets its row from this edge.
    - Else, a face without a row at a border starts a row there: along the whole border, or up to the next corners.
    - Else, any face without a row stands for the next row, if there are rows already.
    - A face with a row stands for the next row beside its row.

    Args:
        labeling: the partly labeled mesh.
        side: the side of the face that is nearest to the place.

    Raises:
        ParameterError: no row can grow there; the message says where to point instead.
    """
    face = int(labeling.mesh.side_face[side])
    if labeling.labeled[face]:
        return LabelStep("label_row_at", {"edge": _side_beside_row(labeling, side)})
    sides = _nearest_first(labeling, side)
    ready = sides[_borders_a_row(labeling, sides)]
    if len(ready):
        return LabelStep("label_row_at", {"edge": ready[0]})
    border = sides[labeling.mesh.twin[sides] == BORDER]
    if len(border):
        return LabelStep("start_at_edge", {"edge": border[0]})
    if not labeling.labeled.any():
        raise ParameterError(f"face {face}: lies at no border; point at a border, from which the first row starts")
    return LabelStep("label_rows", {"count": 1})


def free_border_sides(labeling: PartialLabeling) -> IntArray:
    """Return the sides on borders that no row has reached, at which a row can start, shape (n,)."""
    mesh = labeling.mesh
    return np.flatnonzero((mesh.twin == BORDER) & (labeling.edge_label[mesh.side_edge] == UNKNOWN))


def _nearest_first(labeling: PartialLabeling, side: int) -> IntArray:
    """The sides of the face of a side, beginning with the side itself."""
    mesh = labeling.mesh
    face = mesh.side_face[side]
    sides = np.arange(mesh.face_start[face], mesh.face_start[face + 1])
    return np.concatenate([[side], sides[sides != side]])


def _borders_a_row(labeling: PartialLabeling, sides: IntArray) -> np.ndarray:
    """Whether each side is a course edge with a labeled face across, shape (n,)."""
    mesh = labeling.mesh
    across = mesh.twin[sides]
    course = labeling.edge_label[mesh.side_edge[sides]] == COURSE
    return course & (across != BORDER) & labeling.labeled[mesh.side_face[across]]


def _side_beside_row(labeling: PartialLabeling, side: int) -> int:
    """A side, if possible of this face, between its row and a face without a row."""
    mesh = labeling.mesh
    row = labeling.row[mesh.side_face[side]]
    for sides in (_nearest_first(labeling, side), mesh.sides_of(np.flatnonzero(labeling.row == row))):
        across = mesh.twin[sides]
        free = (across != BORDER) & ~labeling.labeled[mesh.side_face[across]]
        free &= labeling.edge_label[mesh.side_edge[sides]] == COURSE
        if free.any():
            return int(sides[free][0])
    raise ParameterError(f"row {row}: has no face without a row beside it; it can only be reversed, by flip_row")
