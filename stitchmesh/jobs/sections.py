# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a job file. A table has the name of a public function, and its keys are arguments of the function.

Values are numbers, texts and lists, as TOML holds them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase
from stitchmesh.periodic.swatch_options import KnitState, SwatchOptions
from stitchmesh.quality import Quality, Solver, quality_named, quality_with
from stitchmesh.recipe.sections import MarkTable, PhysicsSection, RowsSection
from stitchmesh.render.options import PICTURE_SIZE, PictureOptions
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement, ShapingOptions
from stitchmesh.tessellate import STITCH_WIDTH
from stitchmesh.yarn.rest_length import parse_rest_lengths
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarnrelax.model.material import (
    DEFAULT_MATERIAL,
    YarnMaterial,
    check_one_mass,
    parse_stiffnesses,
)

Free = Literal["free"]
CHECKPOINT_EVERY, CHECKPOINT_OF_SWATCH = 200, 1000
"""Default number of iterations between two checkpoints of a garment, and of a swatch, whose iterations are faster."""


def _check_interval(table: str, every: int) -> None:
    if every < 1:
        raise ParameterError(f"{table}.checkpoint_every: got {every}; expected at least 1")


@dataclass(frozen=True, kw_only=True)
class LabelTable:
    """Arguments of ``label``."""

    borders: tuple[tuple[int, int], ...] = ()
    """Borders from which rows start, each named by the two vertices of one of its edges."""
    seeds: tuple[tuple[int, int], ...] = ()
    """Course edges from which rows start, each named by its two vertices."""
    flip: tuple[int, ...] = ()
    """Faces whose rows are reversed."""


@dataclass(frozen=True, kw_only=True)
class TessellateTable:
    """Arguments of ``tessellate``."""

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    stitch_height: float | None = None
    """Course spacing [cm]; None for 0.77 times the width."""
    increase: Increase = DEFAULT_INCREASE
    """How increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo``."""
    counts: tuple[str, ...] = ()
    """Numbers of stitches along edges, ``V,W=COUNT``."""
    marked: tuple[tuple[int, int], ...] = ()
    """Wale edges at which all increases and decreases of their faces stand, each named by its two vertices."""


@dataclass(frozen=True, kw_only=True)
class AutoStitchesTable:
    """Arguments of ``auto_stitches``.

    Raises:
        ParameterError: a number or a mark is not possible.
    """

    stitch_width: float = STITCH_WIDTH
    """Wale spacing [cm]."""
    stitch_height: float | None = None
    """Course spacing [cm]; None for 0.77 times the width."""
    increase: Increase = DEFAULT_INCREASE
    """How increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo``."""
    up: tuple[float, float, float] = ShapingOptions.up
    """Direction in which the garment is knitted where nothing else decides."""
    multiple: int = ShapingOptions.multiple
    """Number that the stitches of each round are a multiple of."""
    short_rows: bool = ShapingOptions.short_rows
    """Whether the yarn turns back and comes again where rows are far too high."""
    marks: tuple[MarkTable, ...] = ()
    """Where knitting begins and ends, lines along which rows run, and plain places."""
    most_shaping: float | None = ShapingOptions.most_shaping
    """Largest part of the stitches of a row that are increases or decreases; None for as many as the surface asks."""
    shaping: Placement = DEFAULT_PLACEMENT
    """Where increases and decreases stand: ``seams`` or ``spread``."""

    def __post_init__(self) -> None:
        self.rows()

    def rows(self) -> RowsSection:
        """Return the section of a recipe."""
        given = {part.name: getattr(self, part.name) for part in fields(RowsSection) if part.name != "auto"}
        return RowsSection(auto=True, **given)


@dataclass(frozen=True, kw_only=True)
class GenerateYarnsTable:
    """Arguments of ``generate_yarns``."""

    yarn_radius: float | None = None
    """Yarn radius [cm]; None for an eighth of the stitch width."""
    drawn_radius: float | None = None
    """Radius of the yarn in pictures and files for renderers [cm]; None for 1.7 yarn radii."""
    mass_per_length: float | None = None
    """Mass of a length of yarn [g/cm]; None for that of the material."""
    bind_off: str = YarnFinish.bind_off
    """``chain`` or ``drawn``."""
    cast_on: str = YarnFinish.cast_on
    """``backward`` or ``open``."""
    longest_float: int = YarnFinish.longest_float
    """Largest number of stitches of other yarns behind which a yarn floats."""


@dataclass(frozen=True, kw_only=True)
class RelaxYarnsTable(PhysicsSection):
    """Arguments of ``relax_yarns``, and the interval of its checkpoints.

    Raises:
        ParameterError: the interval is less than 1.
    """

    material: str = DEFAULT_MATERIAL
    """Name of a material, which is scaled to the radius of the yarn."""
    stiffness: tuple[str, ...] = ()
    """New values of the material, ``NAME=VALUE``."""
    solver: Solver | None = None
    """``quasistatic`` or ``dynamics``; None for that of the quality."""
    max_iterations: int | None = None
    """Largest number of iterations; None for that of the quality."""
    checkpoint_every: int = CHECKPOINT_EVERY
    """Iterations between two checkpoints."""

    def __post_init__(self) -> None:
        _check_interval("relax_yarns", self.checkpoint_every)

    @property
    def physics(self) -> PhysicsSection:
        """The additional energies."""
        return PhysicsSection(**{part.name: getattr(self, part.name) for part in fields(PhysicsSection)})


@dataclass(frozen=True, kw_only=True)
class SwatchTable:
    """Arguments of ``swatch``, and the interval of its checkpoints.

    Raises:
        ParameterError: the interval is less than 1.
    """

    pattern: str
    """Name of a pattern or weave of the library, or the path of a chart."""
    yarn_radius: float = SwatchOptions.yarn_radius
    """Yarn radius [cm]."""
    drawn_radius: float | None = None
    """Radius of the yarn in pictures and files for renderers [cm]."""
    mass_per_length: float | None = None
    """Mass of a length of yarn [g/cm]; None for that of the material."""
    loop_length: float | None = None
    """Yarn length of a plain stitch [cm]."""
    spacing: float | tuple[float, float] | None = None
    """Distance between the yarns of a weave [cm], or of its warps and of its wefts."""
    rest_lengths: tuple[str, ...] = ()
    """Factors of rest lengths, ``KEY=FACTOR``."""
    gamma: float = SwatchOptions.gamma
    """Tightness: all rest lengths are divided by it."""
    period: tuple[float | Free, float | Free] = ("free", "free")
    """Width and height of the repeat [cm], or ``free``."""
    columns: int = SwatchOptions.columns
    """Repeats side by side."""
    rows: int = SwatchOptions.rows
    """Repeats one above another."""
    unsupported: bool = SwatchOptions.unsupported
    """Whether a repeat whose size relaxes lies on nothing."""
    blocked: float | None = None
    """Tension with which the repeat is pinned out [dyn/cm]."""
    longest_float: int = SwatchOptions.longest_float
    """Largest number of stitches of other yarns behind which a yarn floats."""
    relax_cell: bool = False
    """Whether the width and the height relax too."""
    relaxation: KnitState | None = None
    """``dry``, ``wet`` or ``full``, off the needles with friction, or ``frictionless``; None as for ``swatch``."""
    friction: float | None = None
    """Coefficient of friction between the yarns of a knit that is let go."""
    shaken: int = 0
    """Number of shaken starts that relax too, for the spread of the size."""
    material: str = DEFAULT_MATERIAL
    """Name of a material, which is scaled to the radius of the yarn."""
    stiffness: tuple[str, ...] = ()
    """New values of the material, ``NAME=VALUE``."""
    max_iterations: int | None = None
    """Largest number of iterations; None for that of the quality."""
    checkpoint_every: int = CHECKPOINT_OF_SWATCH
    """Iterations between two checkpoints."""

    def __post_init__(self) -> None:
        _check_interval("swatch", self.checkpoint_every)

    def options(self) -> SwatchOptions:
        """Return the options of the swatch.

        Raises:
            ParameterError: a value is out of bounds.
        """
        given = {part.name: getattr(self, part.name) for part in fields(SwatchOptions)}
        period = tuple(None if size == "free" else size for size in self.period)
        return SwatchOptions(**given | {"rest_lengths": parse_rest_lengths(self.rest_lengths), "period": period})

    def yarn_material(self) -> YarnMaterial:
        """Return the material of the yarn.

        Raises:
            ParameterError: the material or a value is unknown, a value is out of bounds, or the yarn has two masses.
        """
        stiffness = parse_stiffnesses(self.stiffness)
        check_one_mass(stiffness, self.mass_per_length)
        return YarnMaterial.named(self.material, stiffness).of_radius(self.yarn_radius)

    def quality(self, preset: str) -> Quality:
        """Return the preset with the limit of iterations."""
        return quality_named(quality_with(preset, max_iterations=self.max_iterations))

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of ``swatch`` except for the pattern, the quality and the device."""
        return {"relax_cell": self.relax_cell} | vars(self.options())


@dataclass(frozen=True, kw_only=True)
class RenderTable:
    """Arguments of ``render``."""

    path: str = "preview.png"
    """Picture in the folder of the job."""
    view: str | None = None
    """Direction of the camera; None for the front."""
    size: tuple[int, int] = PICTURE_SIZE
    """Width and height [pixels]."""
    colour: str | None = None
    """``yarn``, ``row``, ``stitch``, ``strain``, ``contact`` or a colour; None for the colours of the yarns."""
    tiles: tuple[int, int] = (5, 5)
    """Repeats of a swatch, along the courses and along the wales."""

    def options(self) -> dict[str, Any]:
        """Return the options of ``render``.

        Raises:
            ParameterError: a value is not possible.
        """
        given: dict[str, Any] = {"view": self.view, "size": self.size, "colour": self.colour}
        PictureOptions(**given)
        return given
