# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The settings of a live swatch: what the user has asked for."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.periodic.relaxation.off_needles import Release, chosen_release
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.sampling.sampling import path_to
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.solvers import solver_named


@dataclass(frozen=True)
class SwatchSettings:
    """The arguments of ``swatch`` that may change while the swatch relaxes.

    Raises:
        ParameterError: the solver is unknown, or it cannot relax the cell.
    """

    pattern: FilePath | Source
    """A pattern or a weave, its name, or the path of its file."""
    material: YarnMaterial | None
    """Material of the yarn; None for the default material, scaled to the yarn radius."""
    options: SwatchOptions
    """All other options."""
    quality: Quality
    """Resolution, tolerance and solver of the relaxation."""

    def __post_init__(self) -> None:
        solver_named(self.quality.solver)
        for name in ("steamed", "yield_curvature"):
            if getattr(self.options, name):
                found = f"{name}: got one for a live swatch, which is not at rest"
                raise ParameterError(f"{found}; steam the swatch that is made from it")
        if self.quality.solver == "dynamics" and self.options.freedom is not False:
            found = "solver: got dynamics for a free cell, which has no mass to move with"
            raise ParameterError(f"{found}; take quasistatic, or set relax_cell to False")

    def changed(self, **changes: Any) -> SwatchSettings:
        """Return the settings with some values replaced.

        Args:
            changes: new values, by the names of the arguments of ``swatch``, or ``solver`` for the solver alone.

        Raises:
            ParameterError: there is no such argument or it cannot change, or a value is out of bounds.
        """
        own = {"pattern", "material", "quality", "solver"}
        optional = {option.name for option in fields(SwatchOptions)}
        unknown = sorted(changes.keys() - own - optional)
        if unknown:
            known = ", ".join(sorted(own | optional))
            raise ParameterError(f"session: got a change of {unknown[0]!r}; expected one of {known}")
        options = replace(self.options, **{name: changes[name] for name in changes.keys() & optional})
        given = {name: changes[name] for name in changes.keys() & own}
        quality = quality_named(given.pop("quality", self.quality))
        solver = given.pop("solver", None)
        given["quality"] = quality if solver is None else replace(quality, solver=solver)
        return replace(self, options=options, **given)

    @property
    def sampled(self) -> Quality:
        """The quality with as many control points as a swatch without friction has."""
        free = self.options.freedom
        cell = RelaxCell() if free is True or self.options.blocked is not None else free or None
        return path_to(self.quality, cell)[-1]

    def release(self, source: Source) -> Release | None:
        """Return how the knit is let go off the needles; None without friction.

        Raises:
            ParameterError: an error of ``chosen_release``.
        """
        return chosen_release(self.options, woven=isinstance(source, Weave))

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of ``swatch``, except for the pattern and the device."""
        return {"material": self.material, "quality": self.quality} | vars(self.options)

    @property
    def yarn_material(self) -> YarnMaterial:
        """The material of the yarn, the default material included."""
        return self.options.yarn_material(self.material)
