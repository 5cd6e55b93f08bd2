# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Labeling steps as data: a name, and arguments that JSON can hold, so that a labeling can be saved and repeated."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from stitchmesh.errors import ParameterError, StitchMeshError, check_kind, described
from stitchmesh.io.checked import check_table, plain_value
from stitchmesh.io.contents import FilePath
from stitchmesh.io.step_log import read_step_log, write_step_log
from stitchmesh.labeling.partial_labeling import EdgeLabel, PartialLabeling, start_labeling
from stitchmesh.labeling.seeds import EdgeName
from stitchmesh.mesh import Mesh
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
        if not isinstance(self.arguments, Mapping) or not all(isinstance(name, str) for name in self.arguments):
            expected = 'arguments by name, such as {"edge": [3, 4]}'
            raise ParameterError(f"step {self.name!r}: got {described(self.arguments)}; expected {expected}")
        object.__setattr__(self, "arguments", {name: plain_value(value) for name, value in self.arguments.items()})


class _Arguments(Protocol):
    """Checked arguments of a step, which take the step."""

    def applied(self, labeling: PartialLabeling) -> PartialLabeling: ...


@dataclass(frozen=True)
class _StartAtBorder:
    edge: EdgeName

    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return labeling.start_at_border(self.edge)


@dataclass(frozen=True)
class _StartAtEdge:
    edge: EdgeName

    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return labeling.start_at_edge(self.edge)


@dataclass(frozen=True)
class _LabelRows:
    count: int = 1

    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return labeling.label_rows(self.count)


@dataclass(frozen=True)
class _LabelRowAt:
    edge: EdgeName

    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return labeling.label_row_at(self.edge)


@dataclass(frozen=True)
class _LabelAll:
    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return labeling.label_all()


@dataclass(frozen=True)
class _SetEdge:
    edge: EdgeName
    label: EdgeLabel | None

    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return labeling.set_edge(self.edge, self.label)


@dataclass(frozen=True)
class _FlipRow:
    face: int

    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return labeling.flip_row(self.face)


@dataclass(frozen=True)
class _ClearLabels:
    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return start_labeling(labeling.mesh)


@dataclass(frozen=True)
class _TurnInsideOut:
    def applied(self, labeling: PartialLabeling) -> PartialLabeling:
        return start_labeling(turn_inside_out(labeling.mesh))


LABEL_STEPS: dict[str, type[_Arguments]] = {
    "start_at_border": _StartAtBorder,
    "start_at_edge": _StartAtEdge,
    "label_rows": _LabelRows,
    "label_row_at": _LabelRowAt,
    "label_all": _LabelAll,
    "set_edge": _SetEdge,
    "flip_row": _FlipRow,
    "clear_labels": _ClearLabels,
    "turn_inside_out": _TurnInsideOut,
}
"""Arguments of each step, by name.

All names but two are methods of ``PartialLabeling``. ``clear_labels`` removes all labels. ``turn_inside_out`` removes
all labels and reverses all faces of the mesh, so that its other side is outside.
"""


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
    return _checked(step).applied(labeling)


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
    _checked(step)
    return step


def _checked(step: LabelStep) -> _Arguments:
    """Return the checked arguments of a step.

    Raises:
        ParameterError: the step is unknown, or an argument is missing, unknown or of another type.
    """
    if step.name not in LABEL_STEPS:
        near = difflib.get_close_matches(str(step.name), LABEL_STEPS, n=1) or [", ".join(LABEL_STEPS)]
        raise ParameterError(f"step {step.name!r}: is unknown; expected {near[0]}")
    try:
        return check_table(dict(step.arguments), LABEL_STEPS[step.name])
    except ParameterError as error:
        raise ParameterError(f"step {step.name}: {error}") from error
