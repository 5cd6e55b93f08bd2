# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The settings of a fit of a yarn to what was measured on its fabric; the command line loads no more than these."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.errors import ParameterError
from stitchmesh.settings import check_settings, setting

VALUES = ("bending_rigidity", "axial_stiffness", "transverse_modulus", "core_diameter", "loop_length")
"""The values of a yarn in a fabric, as a file ``yarn.toml`` names them, and its loop length."""
STIFFNESSES = VALUES[:3]
"""The values that are stiffnesses."""


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """What a fit of a yarn looks for, and how well it was measured.

    Raises:
        ParameterError: a number is out of bounds, or there is no such value.
    """

    fit: tuple[str, ...] = setting(
        (), f"a value of the yarn to find: {', '.join(VALUES)}", form="VALUE",
        unset="the three stiffnesses, and with a gauge the core diameter and the loop length where it is not given",
    )  # fmt: skip
    loop_length: float | None = setting(
        None, "yarn length of a plain stitch, as measured", unit="cm", positive=True, example=1.1,
        unset="that of the gauge, or of the yarn",
    )  # fmt: skip
    gauge: str | None = setting(
        None, "measured stitches, or stitches and rows, in 10 cm of the free swatch", form="STITCHES[xROWS]",
        unset="none was measured", example="22x30",
    )  # fmt: skip
    strains: int = setting(
        6, "largest number of strains of each curve that are computed; more rows are smoothed", least=1, most=100,
    )  # fmt: skip
    tension_error: float = setting(0.02, "relative standard error of the loads", least=1e-6, most=1.0)
    size_error: float = setting(0.01, "relative standard error of the gauge", least=1e-6, most=1.0)

    def __post_init__(self) -> None:
        check_settings(self)
        for name in self.fit:
            if name not in VALUES:
                raise ParameterError(f"fit: got {name!r}; expected some of {', '.join(VALUES)}")

    def unknowns(self, *, pulled: bool) -> tuple[str, ...]:
        """Return the values to find; ``pulled`` says whether a load was measured."""
        if self.fit:
            return tuple(name for name in VALUES if name in self.fit)
        found: tuple[str, ...] = STIFFNESSES if pulled else ()
        if self.gauge is not None:
            found += ("core_diameter",) + (("loop_length",) if self.loop_length is None else ())
        return found
