# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options that differ between the jobs of a sweep, and their values.

An option is a path of keys into the table of a job, such as ``("swatch", "gamma")``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import check_table

Keys = tuple[str, ...]
"""Path of keys into a table."""
LARGEST = 1e15
"""Largest bound of random numbers: whole numbers up to it are exact."""
MOST_DRAWS = 10_000_000
"""Largest number of random samples."""


@dataclass(frozen=True, kw_only=True)
class Range:
    """Random numbers between two bounds.

    Raises:
        ParameterError: the bounds are not in order, or are not positive numbers where their logarithm is taken.
    """

    low: float
    """Smallest number."""
    high: float
    """Largest number."""
    spread: Literal["even", "log"] = "even"
    """Whether numbers or their logarithms are spread evenly."""
    whole: bool = False
    """Whether only whole numbers are drawn."""

    def __post_init__(self) -> None:
        if not -LARGEST <= self.low <= self.high <= LARGEST:
            found = f"got low {self.low:g} and high {self.high:g}"
            raise ParameterError(f"{found}; expected numbers in this order, at most {LARGEST:g}")
        if self.spread == "log" and self.low <= 0.0:
            raise ParameterError(f"got low {self.low:g} for a spread by logarithms; expected a positive number")

    def draw(self, generator: np.random.Generator) -> float | int:
        """Return one random number."""
        if self.whole:
            return int(generator.integers(math.ceil(self.low), math.floor(self.high), endpoint=True))
        if self.spread == "log":
            return math.exp(generator.uniform(math.log(self.low), math.log(self.high)))
        return float(generator.uniform(self.low, self.high))


@dataclass(frozen=True)
class Choices:
    """A list of values: a grid uses each in turn, and each random sample draws one."""

    values: tuple[Any, ...]

    def draw(self, generator: np.random.Generator) -> Any:
        """Return one of the values."""
        return self.values[int(generator.integers(len(self.values)))]


@dataclass(frozen=True)
class Axis:
    """One option and its values."""

    keys: Keys
    """Where the option stands in the table of a job."""
    values: Choices | Range
    """The values that the option gets."""

    @property
    def name(self) -> str:
        """The option as users write it."""
        return ".".join(self.keys)


def grid_axes(table: Mapping[str, Any]) -> tuple[Axis, ...]:
    """Return the axes of a grid, in the order of the file.

    Args:
        table: tables of options, with a list of values for each option.

    Raises:
        ParameterError: an option has no list of values.
    """
    axes = []
    for keys, value in leaves(table):
        if not isinstance(value, list) or not value:
            raise ParameterError(f"grid.{'.'.join(keys)}: got {value!r}; expected a list of values, such as [0.9, 1.0]")
        axes.append(Axis(keys, Choices(tuple(value))))
    return tuple(axes)


def random_axes(table: Mapping[str, Any]) -> tuple[Axis, ...]:
    """Return the axes of random samples.

    Args:
        table: tables of options, with a list of values or a ``Range`` for each option.

    Raises:
        ParameterError: an option has neither.
    """
    return tuple(Axis(keys, _drawn_from(f"random.{'.'.join(keys)}", value)) for keys, value in leaves(table))


def leaves(table: Mapping[str, Any], above: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """Yield the options of nested tables; a table with bounds is the value of an option."""
    for key, value in table.items():
        if isinstance(value, dict) and not {"low", "high"} & value.keys():
            yield from leaves(value, (*above, key))
        else:
            yield (*above, key), value


def _drawn_from(name: str, value: Any) -> Choices | Range:
    if isinstance(value, list) and value:
        return Choices(tuple(value))
    if not isinstance(value, dict):
        raise ParameterError(f"{name}: got {value!r}; expected a list of values, or {{ low = 0.9, high = 1.1 }}")
    try:
        found = check_table(value, Range)
        if found.whole and math.ceil(found.low) > math.floor(found.high):
            raise ParameterError(f"got no whole number between {found.low:g} and {found.high:g}")
    except ParameterError as error:
        raise ParameterError(f"{name}: {error}") from error
    return found


def with_option(table: Mapping[str, Any], keys: Keys, value: Any) -> dict[str, Any]:
    """Return a table in which one option has another value; tables on the way are made where they are missing.

    Raises:
        ParameterError: a key on the way holds no table.
    """
    first, *rest = keys
    if not rest:
        return {**table, first: value}
    inner = table.get(first, {})
    if not isinstance(inner, Mapping):
        raise ParameterError(f"{'.'.join(keys)}: {first} is {inner!r} in the job; expected a table of options")
    return {**table, first: with_option(inner, tuple(rest), value)}
