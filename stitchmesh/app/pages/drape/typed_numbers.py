# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers that a user types in a row, such as the corner of a box or a displacement."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError


def three_numbers(name: str, text: object, unit: str = "cm") -> tuple[float, float, float]:
    """Return the three numbers of a text.

    Raises:
        ParameterError: there are not three.
    """
    numbers = typed_numbers(text)
    if len(numbers) != 3:
        raise ParameterError(f"{name}: got {str(text)[:40]!r}; expected three numbers of {unit}, such as 1, 2.5, -1")
    x, y, z = numbers
    return x, y, z


def typed_numbers(text: object) -> tuple[float, ...]:
    """Return the finite numbers of a text, between commas; none if a part is no number."""
    try:
        numbers = tuple(float(part) for part in str(text).replace(";", ",").split(","))
    except ValueError:
        return ()
    return numbers if np.isfinite(numbers).all() else ()


def as_text(numbers: tuple[float, ...]) -> str:
    """Return numbers as a text that can be typed."""
    return ", ".join(f"{number:g}" for number in numbers)
