# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Quantities of yarns with the units that people use, as numbers in CGS units.

Pint knows the units of length, force and pressure, and the counts of yarns: tex, denier, metric (Nm) and English (Ne)
counts. The trade writes the count of a plied yarn in either order and its unit on either side: ``2/28 Nm``, ``28/2 Nm``
and ``Nm 28/2`` have two plies of Nm 28. The smaller number is that of the plies.
"""

from __future__ import annotations

import functools
import math
import re
from typing import Any

from stitchmesh.errors import ParameterError

LINEAR_DENSITY, LENGTH, PER_LENGTH = "g/cm", "cm", "1/cm"
FORCE, PRESSURE, RIGIDITY, SPECIFIC_STIFFNESS, TORQUE = "dyn", "dyn/cm^2", "dyn*cm^2", "dyn*cm/g", "dyn*cm"
TENSION = "dyn/cm"
EXAMPLES = {
    LINEAR_DENSITY: "72 tex, 2/28 Nm, 20/2 Ne or 70 denier",
    LENGTH: "0.17 mm or 22 um",
    PER_LENGTH: "850/m or 12 wpi",
    FORCE: "17 N or 500 cN",
    TENSION: "5 N/m or 0.2 N/cm",
    PRESSURE: "815 MPa or 50 kPa",
    RIGIDITY: "0.004 cN cm2 or 1e-9 N m2",
    SPECIFIC_STIFFNESS: "220 cN/tex",
    TORQUE: "2 nN m or 0.02 dyn cm",
}
"""What a user writes, by the unit of the result."""
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
UNIT = r"[A-Za-zµμ]+(?:\^?[2-4])?"
QUANTITY = re.compile(rf"({NUMBER})\s*(/?\s*{UNIT}(?:\s*[*/ ]\s*{UNIT})*)")
LONGEST = 60
"""Longest text of a quantity; pint calls itself for each factor of a unit."""
NUMBER_OF_YARN = r"\d+(?:\.\d+)?"
UNIT_FIRST = re.compile(rf"(Nm|Ne|tex|dtex|denier)\s*({NUMBER_OF_YARN}(?:\s*/\s*{NUMBER_OF_YARN})?)")
PLIED = re.compile(rf"({NUMBER_OF_YARN})\s*/\s*({NUMBER_OF_YARN})\s*(Nm|Ne)")


@functools.cache
def _registry() -> Any:
    """Return Pint's registry with the words of yarns; it takes half a second, and is made when first used."""
    import pint

    registry: Any = pint.UnitRegistry()
    registry.enable_contexts("textile")
    registry.define("wraps_per_inch = 1 / inch = wpi")
    registry.define("turns_per_inch = 1 / inch = tpi")
    registry.define("turns_per_metre = 1 / meter = tpm")
    return registry


def in_cgs(value: float | str, unit: str, what: str) -> float:
    """Return a quantity in a CGS unit.

    Args:
        value: a number in that unit, or a text with a unit, such as ``0.17 mm``.
        unit: the unit of the result, a key of ``EXAMPLES``.
        what: name of the quantity, for the message.

    Raises:
        ParameterError: the text is no number with a unit, the unit measures something else, or the number is not
            positive and finite.
    """
    number = value if isinstance(value, int | float) else _parsed(value, unit, what)
    if not (math.isfinite(number) and number > 0.0):
        raise ParameterError(f"{what}: got {value}; expected a positive number, for example {EXAMPLES[unit]}")
    return float(number)


def _single_count(text: str) -> str:
    """Return a count with its unit behind it, and that of a plied yarn as the count of one yarn of its mass."""
    text = UNIT_FIRST.sub(r"\2 \1", text) if UNIT_FIRST.fullmatch(text) else text
    plied = PLIED.fullmatch(text)
    if plied is None:
        return text
    plies, single = sorted(map(float, plied.groups()[:2]))
    return f"{single / plies} {plied[3]}" if plies >= 1.0 else text


def _parsed(text: str, unit: str, what: str) -> float:
    import pint

    found = QUANTITY.fullmatch(_single_count(text.strip()))
    refusal = ParameterError(f"{what}: got {text!r}; expected for example {EXAMPLES[unit]}")
    if not found or len(text) > LONGEST:
        raise refusal
    powers = re.sub(r"(?<=[a-zµμ])([234])", r"^\1", found[2])  # cm2 as cm^2
    per = powers.removeprefix("turns").lstrip()
    units = "1" + per if per.startswith("/") else powers
    try:
        return float(_registry().Quantity(float(found[1]), units).to(unit).magnitude)
    except (pint.PintError, ArithmeticError, ValueError) as error:
        raise refusal from error
