# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options of ``swatch`` and ``stretch_test``, with their defaults and bounds."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarnrelax.model.material import YarnMaterial

YARN_RADIUS = 0.125
"""Default radius of the yarn [cm], the radius of the published materials."""
COMPACT_LOOP = 16.67
"""Default loop length over the yarn diameter: Peirce's compact loop."""
SPACING = 2.4
"""Default distance of adjacent yarns of one layer [yarn diameters]; it gives a plain weave a crimp of 9.5 %."""
GAMMAS = (0.1, 10.0)
"""Smallest and largest gamma."""
TAKE_UP = (0.1, 2.0)
"""Smallest and largest factor of a rest length (Leaf et al. 2018, section 7.2)."""
LONGEST_FLOAT = 7
"""Default largest number of stitches behind which a yarn floats. Knitters carry a yarn behind 5 to 7 stitches; longer
floats catch fingers and pull the fabric together, and are woven in behind a stitch."""
LetGo = Literal["dry", "wet", "full"]
"""States of a knit that was let go off the needles with friction (``off_needles``), whose size is free."""
KnitState = Literal["dry", "wet", "full", "frictionless"]
"""These, and the state without friction, also of weaves."""
YARN_FRICTION = 0.2
"""Default coefficient of friction between yarns, in the range of spun yarns, 0.1 to 0.5."""
STRETCH_STEPS = 9
"""Default number of states of a stretch curve."""


def has_free_size(*, relax_cell: Any, relaxation: KnitState | None, blocked: float | None) -> bool:
    """Whether the size of a swatch relaxes, at least in one direction; arguments as for ``swatch``."""
    return bool(relax_cell) or relaxation in get_args(LetGo) or blocked is not None


@dataclass(frozen=True, kw_only=True)
class SwatchOptions:
    """Options of a swatch.

    Raises:
        ParameterError: a length, the mass, gamma or the tension is not a positive number, gamma or the longest float
            is out of bounds, or there is no such relaxation.
    """

    yarn_radius: float = YARN_RADIUS
    """Contact radius of the yarn [cm]."""
    drawn_radius: float | None = None
    """Apparent radius of the yarn in pictures and files for renderers [cm]; by default ``APPARENT_OVER_CONTACT``
    contact radii for a knitted swatch, and the contact radius for a weave, whose yarns are spun firmly."""
    mass_per_length: float | None = None
    """Mass of a length of yarn of that radius [g/cm], which the yarns of the swatch then state; by default that of the
    material. Threads of a weave that are thicker or thinner are as dense."""
    loop_length: float | None = None
    """Yarn length of a plain stitch of a knitted swatch [cm]; by default ``COMPACT_LOOP`` yarn diameters."""
    spacing: float | tuple[float, float] | None = None
    """Distance between adjacent yarns of a weave [cm], or the distances between its warps and between its wefts."""
    rest_lengths: RestLengths = field(default_factory=RestLengths)
    """Take-up: factors of the rest lengths of stitches, rows, yarns and parts; their product must be in ``TAKE_UP``."""
    gamma: float = 1.0
    """Tightness: the rest lengths are divided by gamma at constant yarn radius."""
    period: tuple[float | None, float | None] = (None, None)
    """Width and height of the repeat [cm]; None keeps the generated size, or leaves it free if the cell is relaxed."""
    columns: int = 1
    """Number of repeats of the pattern in the cell, side by side."""
    rows: int = 1
    """Number of repeats of the pattern in the cell, one above another."""
    relaxation: KnitState | None = None
    """``dry``, ``wet`` or ``full``: the state of a knit that was let go off the needles with friction
    (``off_needles``); width and height are then free. Or ``frictionless``. By default a knit that ``relax_cell=True``
    lets find its size is dry, and all else is without friction: weaves, given sizes, blocking and a ``RelaxCell``."""
    friction: float | None = None
    """Coefficient of friction between the yarns of a knit that is let go; ``YARN_FRICTION`` where not given."""
    unsupported: bool = False
    """Whether a repeat whose size relaxes lies on nothing; by default it lies between two planes (``support``)."""
    blocked: float | None = None
    """Tension with which the repeat is pinned out in both directions [dyn/cm], over its size as generated; its width
    and height then relax under this tension."""
    longest_float: int = LONGEST_FLOAT
    """Largest number of stitches of other yarns behind which a yarn floats; patterns with longer floats are refused."""

    def __post_init__(self) -> None:
        lengths = {"yarn radius": self.yarn_radius, "drawn radius": self.drawn_radius, "loop length": self.loop_length,
                   "period width": self.period[0], "period height": self.period[1]}  # fmt: skip
        for name, value in lengths.items():
            if value is not None:
                check_positive(name, value, "cm")
        if self.mass_per_length is not None:
            check_positive("mass per length", self.mass_per_length, "g/cm")
        if not (np.isfinite(self.gamma) and GAMMAS[0] <= self.gamma <= GAMMAS[1]):
            raise ParameterError(f"gamma: got {self.gamma}; expected {GAMMAS[0]:g} to {GAMMAS[1]:g}")
        if self.blocked is not None and not (np.isfinite(self.blocked) and self.blocked > 0.0):
            raise ParameterError(f"blocked: got {self.blocked} dyn/cm; expected a positive tension")
        if self.relaxation not in (None, *get_args(KnitState)):
            raise ParameterError(f"relaxation: got {self.relaxation!r}; expected dry, wet, full or frictionless")
        if self.longest_float < 0:
            raise ParameterError(f"longest float: got {self.longest_float} stitches; expected 0 or more")
        if self.rest_lengths.loop_length is not None:
            raise ParameterError("rest lengths: got a loop length among them; give the loop length to the swatch")

    @property
    def plain_loop(self) -> float:
        """Yarn length of a plain stitch [cm]."""
        return self.loop_length or 2 * COMPACT_LOOP * self.yarn_radius

    def yarn_material(self, given: YarnMaterial | None) -> YarnMaterial:
        """Return the material of the yarn: the given one, or the default material, with the mass of the options."""
        material = YarnMaterial.named().of_radius(self.yarn_radius) if given is None else given
        mass = self.mass_per_length
        return material if mass is None else replace(material, mass_per_length=mass)

    def stated_masses(self, radius: FloatArray) -> FloatArray:
        """Return the mass of a length of yarns of some contact radii [cm] that they state [g/cm], shape (Y,)."""
        mass = np.nan if self.mass_per_length is None else self.mass_per_length
        stated: FloatArray = mass * (radius / self.yarn_radius) ** 2
        return stated

    def drawn_over_contact(self, default: float) -> float:
        """Apparent radius over contact radius; ``default`` if no apparent radius is given."""
        return default if self.drawn_radius is None else self.drawn_radius / self.yarn_radius
