# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The units of the columns of a sweep."""

from __future__ import annotations

CENTIMETRES = ("width", "height", "wale_spacing", "course_spacing", "loop_length", "thickness", "yarn_radius",
               "drawn_radius", "stitch_width", "course_height", "spacing", "period", "length_cm")  # fmt: skip
"""Last parts of the names of lengths."""
UNITS = {
    **dict.fromkeys(CENTIMETRES, "cm"),
    **dict.fromkeys(("course_tension", "wale_tension", "shear_stress", "blocked", "tension"), "dyn/cm"),
    **dict.fromkeys(("course_moment", "wale_moment"), "dyn"),
    **dict.fromkeys(("energy", "energy_per_stitch"), "erg"),
    "areal_density": "g/cm^2", "mass_per_length": "g/cm", "gravity": "cm/s^2",
}  # fmt: skip
"""Units by the last part of a name."""
OF_GROUPS = {"energies": "erg", "remaining_change": None, "gauge": "in 10 cm"}
"""Units of all columns of a group; the remaining change is relative."""


def unit_of(column: str) -> str | None:
    """Return the unit of a column; None if it has none."""
    *groups, last = column.split(".")
    for group in groups:
        if group in OF_GROUPS:
            return OF_GROUPS[group]
    return "s" if last.endswith("seconds") else UNITS.get(last)


def titled(column: str) -> str:
    """Return the name of a column with its unit, such as ``wale_spacing [cm]``."""
    unit = unit_of(column)
    return column if unit is None else f"{column} [{unit}]"
