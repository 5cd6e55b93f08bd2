# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options of ``swatch`` and ``stretch_test``, with their defaults and bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.mesh import FloatArray
from stitchmesh.settings import check_settings, setting
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarnrelax.model.material import YarnMaterial

if TYPE_CHECKING:
    from stitchmesh.yarnrelax import RelaxCell

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
"""Default largest number of stitches behind which a yarn floats. Knitters carry a yarn behind 5 to 7 stitches. Longer
floats catch fingers and pull the fabric together, so knitters weave them in behind a stitch."""
MOST_TURNS = 1e6
"""Largest residual twist [turns/m]."""
LetGo = Literal["dry", "wet", "full"]
"""States of a knit of free size after it was let go off the needles with friction (``off_needles``)."""
KnitState = Literal["dry", "wet", "full", "frictionless"]
"""The states of ``LetGo``, and the state without friction, which weaves have too."""
YARN_FRICTION = 0.2
"""Default coefficient of friction between yarns, in the range of spun yarns, 0.1 to 0.5."""


@dataclass(frozen=True, kw_only=True)
class RepeatSettings:
    """The size and the number of the repeats of a swatch, apart from its yarn.

    Raises:
        ParameterError: a number is out of bounds.
    """

    loop_length: float | None = setting(
        None, "yarn length of a plain stitch", unit="cm", positive=True, example=2.0,
        unset=f"that of the gauge or of the yarn, or {COMPACT_LOOP} diameters",
    )  # fmt: skip
    spacing: float | tuple[float, float] | None = setting(
        None, "distance between the yarns of a weave, or between its warps and between its wefts", unit="cm",
        form="CM [CM]", unset=f"{SPACING} diameters", example=0.6,
    )  # fmt: skip
    gamma: float = setting(
        1.0, "tightness: all rest lengths are divided by this factor, 0.1 to 10, at constant yarn radius", form="G",
        least=GAMMAS[0], most=GAMMAS[1],
    )  # fmt: skip
    columns: int = setting(1, "number of repeats of the pattern, side by side")
    rows: int = setting(1, "number of repeats of the pattern, one above another")
    longest_float: int = setting(
        LONGEST_FLOAT, "largest number of stitches behind which a yarn floats; patterns with longer floats are refused",
        least=0, expected="0 or more stitches",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, kw_only=True)
class StateSettings:
    """The state in which a repeat comes to rest: friction between its yarns, planes around it, tension on it."""

    relaxation: KnitState | None = setting(
        None, "let a knit go off the needles with friction between its yarns, to one of Munden's three states, or "
        "without any", form="dry|wet|full|frictionless", unset="dry for a knit whose size is free, or frictionless",
        example="wet", choices=get_args(KnitState),
    )  # fmt: skip
    friction: float | None = setting(
        None, "coefficient of friction between the yarns of a knit that is let go", form="MU",
        unset=f"{YARN_FRICTION:g}", example=0.2,
    )  # fmt: skip
    unsupported: bool = setting(
        False, "let a repeat whose size relaxes lie on nothing instead of between two planes"
    )
    # Smallest tension of a repeat that is pinned out [dyn/cm], so that it is above 0
    blocked: float | None = setting(
        None, "pin the repeat out along courses and wales with this tension; its size then relaxes too",
        unit="dyn/cm", form="TENSION", unset="not blocked", example=50.0, least=1e-6,
        expected="a positive tension",
    )  # fmt: skip
    residual_twist: float | None = setting(
        None, "turns that a length of the yarn would lose if it hung free, positive for Z twist and negative for S "
        "twist; their torque shears a repeat of free size (spirality)", unit="turns/m", form="TURNS",
        unset="yarn without torque", example=100.0, least=-MOST_TURNS, most=MOST_TURNS,
    )  # fmt: skip
    steamed: float | None = setting(
        None, "share of the bending and of the residual twist that steam or a wash sets in the state at rest; a swatch "
        "that is blocked is then freed of its pins, and comes to rest again", form="SHARE", unset="not steamed",
        example=0.6, least=0.0, most=1.0, expected="a share from 0 to 1",
    )  # fmt: skip
    yield_curvature: float | None = setting(
        None, "curvature of the yarn beyond which its bending lasts", unit="1/cm", form="K", unset="elastic yarn",
        positive=True, example=10.0,
    )  # fmt: skip
    relax_cell: bool = setting(False, "relax the width and the height of the repeat too, except those that are given")

    @property
    def has_free_size(self) -> bool:
        """Whether the size of the repeat relaxes, at least in one direction."""
        return bool(self.relax_cell) or self.relaxation in get_args(LetGo) or self.blocked is not None


@dataclass(frozen=True, kw_only=True)
class ReleaseSettings(StateSettings):
    """How the size of a repeat relaxes, and how often."""

    shaken: int = setting(
        0, "relax the repeat from N more starts, with the noise of a real yarn, and say how far their sizes lie apart"
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, kw_only=True)
class SwatchOptions(RepeatSettings, StateSettings):
    """Options of a swatch.

    Raises:
        ParameterError: a length, the mass, gamma or the tension is not a positive number, gamma or the longest float
            is out of bounds, or there is no such relaxation.
    """

    relax_cell: Any = False  # A type of the relaxation would be loaded with every option of a command.
    """Whether the width and height of the repeat are relaxed, between two planes (``support``), or a ``RelaxCell`` with
    the degrees of freedom of a cell that lies on nothing. With ``RelaxCell()`` the cell can also shear; ribs without
    friction do so to one of the two sides."""
    yarn_radius: float = setting(YARN_RADIUS, "contact radius of the yarn", unit="cm", positive=True)
    drawn_radius: float | None = setting(
        None, "radius of the yarn in pictures and files for renderers", unit="cm", positive=True, example=0.17,
        unset="that of the yarn, or 1.7 times its radius; of a weave its radius, whose yarns are spun firmly",
    )  # fmt: skip
    mass_per_length: float | None = setting(
        None, "mass of a length of yarn of that radius; threads that are thicker or thinner are as dense", unit="g/cm",
        positive=True, unset="that of the material", example=0.004,
    )  # fmt: skip
    rest_lengths: RestLengths = field(default_factory=RestLengths)
    """Take-up: factors of the rest lengths of stitches, rows, yarns and parts; their product must be in ``TAKE_UP``."""
    period: tuple[float | None, float | None] = (None, None)
    """Width and height of the repeat [cm]; None keeps the generated size, or leaves it free if the cell is relaxed."""
    terms: Sequence[Any] = ()  # of ``yarnrelax.energies.term.YarnChoice``, which would be loaded with every option
    """What else acts on a repeat of fixed size, for example ``Wind`` between the planes of ``Confinement``."""

    def __post_init__(self) -> None:
        check_settings(self)
        for name, size in zip(("period width", "period height"), self.period, strict=True):
            if size is not None:
                check_positive(name, size, "cm")
        if self.rest_lengths.loop_length is not None:
            raise ParameterError("rest lengths: got a loop length among them; give the loop length to the swatch")
        if self.terms and self.gamma != 1.0:
            raise ParameterError(f"swatch, terms: got gamma {self.gamma:g}, which changes their size; expected gamma 1")

    @property
    def freedom(self) -> bool | RelaxCell:
        """Which changes of the size are free, as for ``relax_cell``; a knit off the needles finds its size."""
        free: bool | RelaxCell = self.relax_cell or self.relaxation in get_args(LetGo)
        return free

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
        """Return the mass per length [g/cm] that yarns of some contact radii [cm] state, shape (Y,)."""
        mass = np.nan if self.mass_per_length is None else self.mass_per_length
        stated: FloatArray = mass * (radius / self.yarn_radius) ** 2
        return stated

    def drawn_over_contact(self, default: float) -> float:
        """Apparent radius over contact radius; ``default`` if no apparent radius is given."""
        return default if self.drawn_radius is None else self.drawn_radius / self.yarn_radius


@dataclass(frozen=True, kw_only=True)
class StretchSettings:
    """How a stretch test goes through its strains, apart from the direction and the strains themselves."""

    steps: int = setting(9, "number of strains, with the first and the last", least=2, expected="at least 2")
    cycles: int = setting(
        0, "how often the swatch is let back to the first strain; between two times it is stretched again; with 0 it "
        "stays stretched", least=0, expected="at least 0",
    )  # fmt: skip
    friction: float | None = setting(
        None, "coefficient of friction between yarns; loading then differs from unloading", form="MU", unset="off"
    )
    slip_length: float | None = setting(
        None, "slip from which on friction is full, in yarn radii; the shorter it is, the better the fabric remembers "
        "where the stretch turned", form="RADII", unset="0.05", positive=True,
    )  # fmt: skip
