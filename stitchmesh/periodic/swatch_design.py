# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The design of a swatch: a pattern and the dials that a designer turns (Leaf et al. 2018, section 7.2).

Some dials act on some patterns only: floats and held loops need stitches that have them, and warps and wefts need a
weave. A design keeps the values of all dials, so that a designer may change the pattern and return to it. It uses the
dials that act on its pattern.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from stitchmesh.io.checked import check_table
from stitchmesh.patterns import format_pattern, parse_pattern
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, GAMMAS, SPACING, TAKE_UP, YARN_RADIUS
from stitchmesh.periodic.weave.text import format_weave, parse_weave
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import quality_named
from stitchmesh.settings import check_settings, setting
from stitchmesh.yarn.rest_length import HOLDING, SLIPS, RestLengths
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarnrelax import YarnMaterial

STIFFNESSES = ("k_len", "k_length", "k_bend", "k_contact")
"""Dials that are fields of ``YarnMaterial``, as factors of the default material."""
FACTORS = ("floats", "held", "warp", "weft")
"""Dials that are factors of rest lengths."""
STIFFNESS_FACTORS = (0.001, 1000.0)
"""Smallest and largest factor of a stiffness."""
SIZES = (0.01, 1000.0)
"""Smallest and largest width or height of a repeat [cm]."""
SPACINGS = (0.01, 50.0)
"""Smallest and largest distance of the yarns of a weave [cm]."""
REPEATS = (1, 100)
"""Smallest and largest number of repeats."""
HUNDRED_METRES = 10_000.0
"""The dial of the mass gives the mass of this length of yarn [cm]."""


def _dial(default: float | None, help: str, bounds: tuple[float, float], *, unit: str = "") -> Any:
    """Return a field for a dial, from its smallest to its largest value."""
    return setting(default, help, least=bounds[0], most=bounds[1], unit=unit)


@dataclass(frozen=True, kw_only=True)
class SwatchDials:
    """Values of all dials.

    Raises:
        ParameterError: a value is out of bounds.
    """

    gamma: float = _dial(1.0, "tightness: more than 1 shortens all yarn at constant yarn radius", GAMMAS)
    width: float | None = _dial(
        None, "width to which the repeat is stretched or compressed in small steps; free without one", SIZES, unit="cm"
    )
    height: float | None = _dial(
        None, "height to which the repeat is stretched or compressed in small steps; free without one", SIZES, unit="cm"
    )
    yarn_radius: float = _dial(YARN_RADIUS, "radius of the yarn where it touches other yarn", (0.005, 1.0), unit="cm")
    loop_length: float = _dial(
        2 * COMPACT_LOOP * YARN_RADIUS, "yarn length of a plain stitch, from which the size of the stitches follows",
        (0.05, 100.0), unit="cm",
    )
    warp_spacing: float = _dial(
        2 * SPACING * YARN_RADIUS, "distance between the warps of a weave, as drawn", SPACINGS, unit="cm"
    )
    weft_spacing: float = _dial(
        2 * SPACING * YARN_RADIUS, "distance between the wefts of a weave, as drawn", SPACINGS, unit="cm"
    )
    floats: float = _dial(
        1.0, "factor of the yarn that passes slipped loops, or is carried behind stitches of other yarns", TAKE_UP
    )
    held: float = _dial(1.0, "factor of the loops held by slips and tucks", TAKE_UP)
    warp: float = _dial(1.0, "factor of the warps of a weave", TAKE_UP)
    weft: float = _dial(1.0, "factor of the wefts of a weave", TAKE_UP)
    k_len: float = _dial(1.0, "factor of the stiffness against stretch within a segment", STIFFNESS_FACTORS)
    k_length: float = _dial(1.0, "factor of the stiffness against a change of length", STIFFNESS_FACTORS)
    k_bend: float = _dial(1.0, "factor of the bending stiffness", STIFFNESS_FACTORS)
    k_contact: float = _dial(1.0, "factor of the contact stiffness", STIFFNESS_FACTORS)
    mass: float = _dial(60.0, "weight of the yarn, which decides the weight per area", (0.1, 10_000.0), unit="g/100 m")
    columns: int = _dial(1, "number of repeats of the pattern that relax together, side by side", REPEATS)
    rows: int = _dial(1, "number of repeats of the pattern that relax together, one above another", REPEATS)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True)
class SwatchDesign:
    """A pattern and the values of the dials."""

    pattern: Source
    """A pattern or a weave."""
    dials: SwatchDials = SwatchDials()
    """The values of the dials."""
    quality: str = "draft"
    """Preset of the accuracy."""

    def __post_init__(self) -> None:
        quality_named(self.quality)

    def turned(self, **dials: Any) -> SwatchDesign:
        """Return the design with other values of some dials.

        Raises:
            ParameterError: a value is out of bounds.
        """
        return replace(self, dials=replace(self.dials, **dials))

    def settings(self) -> dict[str, Any]:
        """Return the arguments of ``SwatchSession`` and ``SwatchSession.set``; dials without effect are left out."""
        return {"pattern": self.pattern, "quality": self.quality, "relax_cell": True} | self.options()

    def options(self) -> dict[str, Any]:
        """Return the material, and the options that ``stretch_test`` takes too (without the period)."""
        dials, used = self.dials, acting_dials(self.pattern)
        # Number of stitches behind which a yarn may float in a design. A designer sees a long float in the fabric, so a
        # design refuses only floats that no knitter would make.
        return {
            "material": self._material(),
            "yarn_radius": dials.yarn_radius,
            "mass_per_length": dials.mass / HUNDRED_METRES,
            "loop_length": dials.loop_length if "loop_length" in used else None,
            "spacing": (dials.warp_spacing, dials.weft_spacing) if "warp_spacing" in used else None,
            "rest_lengths": RestLengths(**{name: getattr(dials, name) for name in FACTORS if name in used}),
            "gamma": dials.gamma,
            "period": (dials.width, dials.height),
            "columns": dials.columns if "columns" in used else 1,
            "rows": dials.rows if "rows" in used else 1,
            "longest_float": 40,
        }

    def _material(self) -> YarnMaterial:
        material = YarnMaterial.named().of_radius(self.dials.yarn_radius)
        return replace(material, **{name: getattr(material, name) * getattr(self.dials, name) for name in STIFFNESSES})


@dataclass(frozen=True, kw_only=True)
class _Table:
    """The form of a design in JSON."""

    kind: Literal["knit", "weave"]
    text: str
    dials: SwatchDials = SwatchDials()
    quality: str = "draft"


def acting_dials(source: Source) -> frozenset[str]:
    """Return the names of the dials that act on a pattern."""
    common = {"gamma", "width", "height", "yarn_radius", "mass", *STIFFNESSES}
    if isinstance(source, Weave):
        return frozenset(common | {"warp_spacing", "weft_spacing", "warp", "weft"})
    cells = {cell.stitch for row in source.rows for cell in row.cells}
    carries = any(len({cell.yarn for cell in row.cells}) > 1 for row in source.rows)
    floats = {"floats"} if carries or cells & set(SLIPS) else set()
    held = {"held"} if cells & set(HOLDING) else set()
    return frozenset(common | {"loop_length", "columns", "rows"} | floats | held)


def dials_of_yarn(yarn: Yarn, pattern: Source) -> dict[str, float]:
    """Return the dials that a yarn sets: thickness, weight, stiffnesses, and in a knit the loops of its gauge."""
    own, usual = YarnMaterial.of_yarn(yarn), YarnMaterial.named().of_radius(yarn.core_radius)
    dials = {
        "yarn_radius": yarn.core_radius, "loop_length": yarn.gauge.loop_length,
        "mass": yarn.mass_per_length * HUNDRED_METRES,
    } | {name: getattr(own, name) / getattr(usual, name) for name in STIFFNESSES}  # fmt: skip
    acting = acting_dials(pattern)
    return {name: float(f"{value:.4g}") for name, value in dials.items() if name in acting}


def design_table(design: SwatchDesign) -> dict[str, Any]:
    """Return a design as a table for JSON; ``read_design`` reads the design from it."""
    source = design.pattern
    woven = isinstance(source, Weave)
    return {
        "kind": "weave" if woven else "knit",
        "text": format_weave(source) if isinstance(source, Weave) else format_pattern(source),
        "dials": asdict(design.dials),
        "quality": design.quality,
    }


def read_design(table: Mapping[str, Any]) -> SwatchDesign:
    """Return the design from a table of ``design_table``.

    Raises:
        ParameterError: a key is unknown or missing, or a value is out of bounds.
        PatternError: the text does not describe a pattern.
    """
    read = check_table(dict(table), _Table)
    source: Source = parse_weave(read.text) if read.kind == "weave" else parse_pattern(read.text)
    return SwatchDesign(source, read.dials, read.quality)
