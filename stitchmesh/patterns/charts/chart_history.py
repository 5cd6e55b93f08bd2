# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of an edited value: what undo returns to, and what redo brings back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from stitchmesh.errors import ParameterError

ValueT = TypeVar("ValueT")
MOST_STEPS = 200
"""Number of steps that can be undone; older ones are dropped."""


@dataclass(frozen=True, eq=False)
class ChartHistory(Generic[ValueT]):
    """A value with the values before it and the values that were undone."""

    value: ValueT
    past: tuple[ValueT, ...] = ()
    """Earlier values, the oldest first."""
    future: tuple[ValueT, ...] = ()
    """Values that were undone, the next one last."""

    def step(self, value: ValueT, most: int = MOST_STEPS) -> ChartHistory[ValueT]:
        """Return the history after a step to another value; what was undone before is dropped.

        Args:
            value: the value after the step.
            most: number of steps that can be undone then; older ones are dropped.
        """
        return ChartHistory(value, (*self.past, self.value)[-most:])

    def with_value(self, value: ValueT) -> ChartHistory[ValueT]:
        """Return the history with another value as the result of the last step, as for the parts of one stroke."""
        return replace(self, value=value)

    def undone(self) -> ChartHistory[ValueT]:
        """Return the history before the last step.

        Raises:
            ParameterError: there is no step to undo.
        """
        if not self.past:
            raise ParameterError("chart: there is no step to undo; this is its first state")
        return ChartHistory(self.past[-1], self.past[:-1], (*self.future, self.value))

    def redone(self) -> ChartHistory[ValueT]:
        """Return the history after the step that was undone last.

        Raises:
            ParameterError: no step was undone since the last change.
        """
        if not self.future:
            raise ParameterError("chart: there is no step to redo; this is its last state")
        return ChartHistory(self.future[-1], (*self.past, self.value), self.future[:-1])
