# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The units of the columns of a sweep: those of its inputs are declared, and those of its measures stand here."""

from __future__ import annotations

from functools import cache

from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.recipe.sections import GarmentSettings
from stitchmesh.settings import SETTING, settings_of

UNITS = {
    **dict.fromkeys(("width", "height", "wale_spacing", "course_spacing", "thickness", "length_cm"), "cm"),
    **dict.fromkeys(("course_tension", "wale_tension", "shear_stress", "tension"), "dyn/cm"),
    **dict.fromkeys(("course_moment", "wale_moment"), "dyn"),
    **dict.fromkeys(("energy", "energy_per_stitch"), "erg"),
    "areal_density": "g/cm^2",
}  # fmt: skip
"""Units of measures by the last part of a name."""
OF_GROUPS = {"energies": "erg", "remaining_change": None, "gauge": "in 10 cm"}
"""Units of all columns of a group; the remaining change is relative."""


@cache
def _units_of_inputs() -> dict[str, str]:
    """Units of the inputs of garments and of swatches, by their names."""
    inputs = {"": GarmentSettings(), "swatch.": SwatchTable(pattern="stockinette")}
    units = {
        f"{above}{path}": part.metadata[SETTING].unit
        for above, settings in inputs.items()
        for path, part, _value in settings_of(settings)
    }
    return {name: unit for name, unit in units.items() if unit}


def unit_of(column: str) -> str | None:
    """Return the unit of a column; None if it has none."""
    if column in _units_of_inputs():
        return _units_of_inputs()[column]
    *groups, last = column.split(".")
    for group in groups:
        if group in OF_GROUPS:
            return OF_GROUPS[group]
    return "s" if last.endswith("seconds") else UNITS.get(last)


def titled(column: str) -> str:
    """Return the name of a column with its unit, such as ``wale_spacing [cm]``."""
    unit = unit_of(column)
    return column if unit is None else f"{column} [{unit}]"
