# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the user of a live swatch has asked for."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.yarnrelax import REFERENCE_RADIUS, RelaxCell, YarnMaterial


@dataclass(frozen=True)
class SwatchSettings:
    """The arguments of ``swatch`` that may change while it relaxes."""

    pattern: FilePath | Source
    """A pattern or a weave, its name or the path of its file."""
    material: YarnMaterial | None
    """Of the yarn; the material ``stitchmesh`` scaled to its radius where None."""
    relax_cell: bool | RelaxCell
    """Whether the repeat finds its own size; or what it is free to do."""
    options: SwatchOptions
    """All else."""

    def changed(self, **changes: Any) -> SwatchSettings:
        """The same wishes but for some, by the name of the argument of ``swatch``.

        Raises:
            ParameterError: there is no such argument or it cannot change, or a value is out of bounds.
        """
        own = {"pattern", "material", "relax_cell"}
        optional = {option.name for option in fields(SwatchOptions)}
        unknown = sorted(changes.keys() - own - optional)
        if unknown:
            known = ", ".join(sorted(own | optional))
            raise ParameterError(f"session: got a change of {unknown[0]!r}; expected one of {known}")
        options = replace(self.options, **{name: changes[name] for name in changes.keys() & optional})
        return replace(self, options=options, **{name: changes[name] for name in changes.keys() & own})

    @property
    def yarn_material(self) -> YarnMaterial:
        """What the yarn is made of."""
        if self.material is not None:
            return self.material
        return YarnMaterial.named().scaled(self.options.yarn_radius / REFERENCE_RADIUS)
