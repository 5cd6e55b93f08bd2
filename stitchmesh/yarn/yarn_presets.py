# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns, hand-knitting yarns by name, and the gauge at which they are knitted.

The table holds published values. The Craft Yarn Council's standard yarn weight system gives the stitches in 4 inches
(10.16 cm) of stockinette and the needle. Spin-Off's chart gives the wraps per inch (WPI), for which yarn is wound side
by side around a ruler. Shops state the length of 100 g. All sizes are derived from the middle of a range:

    stitch width      w = 10.16 cm / stitches
    stitch height     h = w / 1.3, with Munden's ratio of course and wale counts in relaxed stockinette
    loop length       l = 4.06 w, with Munden's constant K_w = 4.06 (wales per cm = K_w / l)
    core radius       r = w / 8
    apparent radius   R = 2.54 cm / WPI / 2
    weight            m = 100 g / length
    bending           EI of free wool fibres of 25 um (``free_fibres``)
    stretch           EA = 0.22 N/tex, as a measured acrylic yarn of 77 tex has it (Ding et al. 2023)

Yarn is soft and hairy: its visible part is thicker than the part that resists compression. Loops of incompressible yarn
at Peirce's loop length of 16.67 diameters would be 8.2 radii wide, but hand-knitted stitches are 4 to 5 apparent radii
wide. A yarn therefore has two radii. The core, with 16.2 diameters in a loop, touches other yarns in a simulation. The
apparent radius, 1.2 to 2 times the core radius, is the radius in a picture; fibres of adjacent yarns overlap there.
"""

from __future__ import annotations

import difflib
import json
import math
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.yarn.yarn_look import YarnLook

GAUGE_LENGTH = 10.0
"""Length in which a gauge counts stitches and rows [cm]."""
ROWS_OVER_STITCHES = 1.3
"""Rows over stitches in a square of relaxed stockinette, Munden's K_c / K_w."""
LOOP_OVER_WIDTH = 4.06
"""Loop length over stitch width of relaxed stockinette, Munden's K_w."""
WIDTH_OVER_CORE = 8.0
"""Stitch width over the radius of the core of the yarn."""
CENTIMETRES_PER_INCH = 2.54
CENTIMETRES_PER_METRE = 100.0


@dataclass(frozen=True)
class Gauge:
    """Stitches and rows in 10 cm of stockinette.

    Raises:
        ParameterError: a count is not a positive number.
    """

    stitches: float
    """Stitches in 10 cm along a row."""
    rows: float = math.nan
    """Rows in 10 cm along a wale; by default 1.3 times the stitches."""

    def __post_init__(self) -> None:
        if math.isnan(self.rows):
            object.__setattr__(self, "rows", ROWS_OVER_STITCHES * self.stitches)
        for name in ("stitches", "rows"):
            check_positive("gauge", getattr(self, name), f"{name} in 10 cm")

    @staticmethod
    def of_stitch(width: float, height: float) -> Gauge:
        """Return the gauge of stitches of that width and height [cm]."""
        return Gauge(GAUGE_LENGTH / width, GAUGE_LENGTH / height)

    @property
    def stitch_width(self) -> float:
        """Wale spacing [cm]."""
        return GAUGE_LENGTH / self.stitches

    @property
    def stitch_height(self) -> float:
        """Course spacing [cm]."""
        return GAUGE_LENGTH / self.rows

    @property
    def loop_length(self) -> float:
        """Yarn length of a plain stitch of relaxed stockinette [cm]."""
        return LOOP_OVER_WIDTH * self.stitch_width

    def __str__(self) -> str:
        """Return the gauge as knitters write it: ``22 stitches and 29 rows in 10 cm``."""
        return f"{self.stitches:.3g} stitches and {self.rows:.3g} rows in 10 cm"


def parse_gauge(text: str) -> Gauge:
    """Parse a gauge as a user writes it: stitches in 10 cm (``22``), or stitches and rows (``22x30``).

    Raises:
        ParameterError: the text does not have one of these forms, or a count is not a positive number.
    """
    try:
        counts = [float(word) for word in text.lower().split("x")]
    except ValueError:
        counts = []
    if len(counts) not in (1, 2) or not all(map(math.isfinite, counts)):
        expected = "stitches in 10 cm such as 22, or stitches x rows such as 22x30"
        raise ParameterError(f"gauge: got {text!r}; expected {expected}")
    return Gauge(*counts)


@dataclass(frozen=True)
class Fibre:
    """A textile fibre: initial moduli of Morton and Hearle's tables, as handbooks quote them."""

    density: float
    """Density [g/cm^3]."""
    specific_modulus: float
    """Initial modulus over the density [N/tex]."""


FIBRES = {
    "wool": Fibre(1.31, 2.3),
    "cotton": Fibre(1.52, 5.0),
    "acrylic": Fibre(1.18, 6.2),
    "nylon": Fibre(1.14, 2.6),
    "polyester": Fibre(1.38, 8.8),
    "viscose": Fibre(1.52, 4.8),
    "silk": Fibre(1.34, 7.3),
}
NEWTON_PER_TEX = 1e10
"""1 N/tex in dyn cm / g."""
HAND_KNITTING_WOOL = 25e-4
"""Diameter of the fibres of hand-knitting wool [cm]."""
SPUN_STIFFNESS = 0.22 * NEWTON_PER_TEX
"""Axial stiffness over the linear density of a spun yarn whose curve is not known [dyn cm / g]."""


def free_fibres(mass_per_length: float, fibre: Fibre, diameter: float) -> float:
    """Return the bending rigidity of all fibres of a yarn that slide over one another, m e f^2 / 16 [dyn cm^2].

    Args:
        mass_per_length: mass of a length of the yarn [g/cm].
        fibre: the fibre.
        diameter: diameter of a fibre [cm].
    """
    return mass_per_length * fibre.specific_modulus * NEWTON_PER_TEX * diameter**2 / 16.0


TWIST_OVER_BEND = 2.0 / 3.0
"""Torsional over flexural rigidity of a round rod of an isotropic material that keeps its volume, 2 G / E."""


@dataclass(frozen=True, kw_only=True)
class YarnMechanics:
    """What a laboratory measures of a yarn.

    Raises:
        ParameterError: a value is not a positive number.
    """

    axial_stiffness: float
    """EA, tension over strain [dyn]."""
    flexural_rigidity: float
    """EI, bending moment over curvature [dyn cm^2]."""
    transverse_modulus: float | None = None
    """Pressure between parallel yarns over their compression by a tenth [dyn/cm^2]; None as in the default material."""
    twist: float | None = None
    """Turns in a length [1/cm]."""
    friction: float | None = None
    """Coefficient of friction of the yarn on itself."""
    torsional_rigidity: float | None = None
    """GJ, torque over twist in a length [dyn cm^2]; None for two thirds of EI, as in a solid rod."""
    residual_twist: float | None = None
    """Turns that a length of yarn would lose if it hung free [1/cm]; positive for Z twist, negative for S twist."""
    least_rigidity: float | None = None
    """EI of its free fibres [dyn cm^2], if they are known."""
    source: str = ""
    """Where the values come from."""

    def __post_init__(self) -> None:
        if self.residual_twist is not None and not math.isfinite(self.residual_twist):
            raise ParameterError(f"yarn: residual_twist is {self.residual_twist}; expected a finite number")
        for part in ("axial_stiffness", "flexural_rigidity", "transverse_modulus", "twist", "friction",
                     "torsional_rigidity"):  # fmt: skip
            value = getattr(self, part)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ParameterError(f"yarn: {part} is {value}; expected a positive number")


@dataclass(frozen=True)
class Yarn:
    """A yarn, at a gauge.

    Raises:
        ParameterError: a radius or the weight is not a positive number, or the core is thicker than the yarn.
    """

    name: str
    """Name of the yarn."""
    core_radius: float
    """Radius within which the yarn resists compression [cm]; the radius of a simulation."""
    apparent_radius: float
    """Radius that the eye sees [cm]; the radius of a picture."""
    grams_per_metre: float
    """Weight of a length of yarn [g/m]."""
    gauge: Gauge
    """Stitches and rows in 10 cm of stockinette."""
    needle: tuple[float, float] = (math.nan, math.nan)
    """Thinnest and thickest needle that is recommended for the yarn [mm]; not a number if unknown."""
    mechanics: YarnMechanics | None = field(default=None, repr=False)
    """Stiffnesses of the yarn; None for the default material, scaled to the radius."""
    look: YarnLook = field(default=YarnLook(), repr=False)
    """How the yarn looks in pictures; like wool by default."""

    def __post_init__(self) -> None:
        for size in ("core_radius", "apparent_radius", "grams_per_metre"):
            check_positive(f"yarn {self.name!r}: {size}", getattr(self, size))
        if self.core_radius > self.apparent_radius:
            found = f"core_radius {self.core_radius:g} cm and apparent_radius {self.apparent_radius:g} cm"
            raise ParameterError(f"yarn {self.name!r}: got {found}; expected a core inside the apparent radius")

    @staticmethod
    def named(name: str) -> Yarn:
        """Return the yarn of that name (``yarn_names`` lists the names), at its usual gauge.

        Raises:
            ParameterError: there is no yarn of that name; the message states the nearest name.
        """
        from stitchmesh.yarn.yarn_description import LIBRARY, described_yarn

        plain = "-".join(str(name).lower().replace("-", " ").replace("_", " ").split())
        if plain in LIBRARY:
            return described_yarn(name=plain, **LIBRARY[plain])
        if plain not in _NAMED:
            known = [*_NAMED, *LIBRARY]
            near = difflib.get_close_matches(plain, known, n=1)
            raise ParameterError(f"yarn: got {name!r}; expected {near[0] if near else ', '.join(known)}")
        return _NAMED[plain]

    @property
    def mass_per_length(self) -> float:
        """Mass of a length of yarn [g/cm]."""
        return self.grams_per_metre / CENTIMETRES_PER_METRE

    @property
    def stitch_width(self) -> float:
        """Wale spacing at the gauge [cm]."""
        return self.gauge.stitch_width

    @property
    def stitch_height(self) -> float:
        """Course spacing at the gauge [cm]."""
        return self.gauge.stitch_height

    @property
    def loop_length(self) -> float:
        """Yarn length of a plain stitch at the gauge [cm]."""
        return self.gauge.loop_length

    def knitted_at(self, gauge: Gauge) -> Yarn:
        """Return the same yarn at another gauge: the radii stay, the stitches change."""
        return replace(self, gauge=gauge)


def format_yarn(yarn: Yarn) -> str:
    """Return a yarn as the JSON text that files of yarns hold; ``parse_yarn`` reads it without loss."""
    return json.dumps(asdict(yarn))


def parse_yarn(text: str | bytes) -> Yarn:
    """Return the yarn of a text of ``format_yarn``.

    Raises:
        ValueError, TypeError, KeyError: the text is no JSON, or lacks a value.
        ParameterError: a value is out of bounds.
    """
    values = json.loads(text)
    mechanics = values["mechanics"]
    # the one not-a-number of ``math``, so that yarns with an unknown needle are equal
    needle = tuple(math.nan if math.isnan(size) else size for size in values["needle"])
    return Yarn(**values | {
        "gauge": Gauge(**values["gauge"]), "needle": needle,
        "mechanics": None if mechanics is None else YarnMechanics(**mechanics),
        "look": YarnLook(**values.get("look", {})),  # files of earlier versions have none
    })  # fmt: skip


@dataclass(frozen=True)
class _YarnWeight:
    """One row of the table: the lowest and the highest value of each range."""

    names: tuple[str, ...]
    """Names of the yarn; ``Yarn.name`` is the first one."""
    stitches: tuple[float, float]
    """Stitches in 10.16 cm of stockinette."""
    needle: tuple[float, float]
    """Diameter of the needle [mm]."""
    wraps: tuple[float, float]
    """Wraps per inch."""
    metres: tuple[float, float]
    """Length of 100 g [m]."""

    def yarn(self) -> Yarn:
        """Return the yarn, with the sizes of the module docstring."""
        width = 4.0 * CENTIMETRES_PER_INCH / _middle(self.stitches)
        mass = 1.0 / _middle(self.metres)  # 100 g over metres, in g/cm
        rigidity = free_fibres(mass, FIBRES["wool"], HAND_KNITTING_WOOL)
        return Yarn(
            name=self.names[0],
            core_radius=width / WIDTH_OVER_CORE,
            apparent_radius=CENTIMETRES_PER_INCH / _middle(self.wraps) / 2.0,
            grams_per_metre=100.0 / _middle(self.metres),
            gauge=Gauge(GAUGE_LENGTH / width),
            needle=self.needle,
            mechanics=YarnMechanics(
                axial_stiffness=SPUN_STIFFNESS * mass, flexural_rigidity=rigidity, least_rigidity=rigidity,
                source="Craft Yarn Council (gauge), Spin-Off (wraps); free wool fibres of 25 um; 0.22 N/tex",
            ),
        )  # fmt: skip


def _middle(bounds: tuple[float, float]) -> float:
    return (bounds[0] + bounds[1]) / 2.0


_TABLE = (
    _YarnWeight(("lace",), (33, 40), (1.5, 2.25), (18, 18), (600, 800)),
    _YarnWeight(("fingering", "sock", "baby"), (27, 32), (2.25, 3.25), (16, 18), (350, 450)),
    _YarnWeight(("sport",), (23, 26), (3.25, 3.75), (14, 15), (250, 350)),
    _YarnWeight(("dk", "double-knitting", "light-worsted"), (21, 24), (3.75, 4.5), (12, 13), (200, 250)),
    _YarnWeight(("worsted", "aran"), (16, 20), (4.5, 5.5), (10, 11), (120, 200)),
    _YarnWeight(("bulky", "chunky"), (12, 15), (5.5, 8.0), (8, 9), (100, 130)),
    _YarnWeight(("super-bulky", "super-chunky"), (6, 11), (8.0, 12.75), (7, 7), (50, 100)),
)
"""Yarns from thin to thick. Wraps of the first and the last yarn are one-sided ranges (18 or more, 7 or fewer), whose
bound is taken. The same holds for the needle and the length of the last yarn (8 mm and more, less than 100 m)."""

_NAMED = {name: row.yarn() for row in _TABLE for name in row.names}


def yarn_names() -> tuple[str, ...]:
    """Return the names of the hand-knitting yarns from thin to thick, without their other names."""
    return tuple(row.names[0] for row in _TABLE)


def yarn_for_gauge(gauge: Gauge) -> Yarn:
    """Return the named yarn whose usual number of stitches is nearest, by ratio, to the number of a gauge."""
    return min(_NAMED.values(), key=lambda yarn: abs(math.log(yarn.gauge.stitches / gauge.stitches)))


def needle_for(loop_length: float) -> float:
    """Return the diameter of the needle [mm] on which hand knitters make loops of a length [cm].

    It is interpolated, on logarithmic scales, between the middles of the table. Beyond the table it is proportional to
    the loop length. Knitters differ by a size or two, so that this is where a first swatch begins.
    """
    yarns = [row.yarn() for row in _TABLE]
    loops, needles = np.log([each.loop_length for each in yarns]), np.log([_middle(each.needle) for each in yarns])
    beyond = math.log(loop_length) - float(np.clip(math.log(loop_length), loops[0], loops[-1]))
    return math.exp(float(np.interp(math.log(loop_length), loops, needles)) + beyond)

