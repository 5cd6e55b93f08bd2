# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The settings of a garment: their sections, as numbers, texts and lists, and the options of the stages that follow.

The names of the fields are the keys of recipes, of jobs and of sweeps, and the options of commands follow from them
(``stitchmesh.settings``).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase
from stitchmesh.mesh.upright import Direction, Y, upright_turn
from stitchmesh.meshrelax.options import MeshRelaxOptions
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER
from stitchmesh.quality import Quality, Solver, quality_named, quality_with
from stitchmesh.settings import changed_settings, check_settings, setting
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement, ShapingOptions
from stitchmesh.shaping.panels.options import PanelOptions
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH
from stitchmesh.yarn.rest_length import RestLengths, parse_rest_lengths
from stitchmesh.yarn.stitch_size import StitchMeasures, stitch_size
from stitchmesh.yarn.yarn_presets import Yarn, yarn_names
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarnrelax.model.material import (
    DEFAULT_MATERIAL,
    NAMED,
    REFERENCE_RADIUS,
    YarnMaterial,
    check_one_mass,
    parse_stiffnesses,
    stiffness_names,
)

if TYPE_CHECKING:
    from stitchmesh.tessellate.edge_file import EdgeSettings
    from stitchmesh.yarnrelax.energies.term import YarnChoice

FACTORS = (
    "for a stitch type (k=1.1), a row (row:3=0.9), a yarn (yarn:12=1.2), or the floats or held loops of slip stitches "
    "(floats=F, held=F)"
)
"""What the factors of rest lengths are for."""
MATERIAL_VALUES = ", ".join(stiffness_names())


@dataclass(frozen=True, kw_only=True)
class LabelSection:
    """Starts and directions of the knitting rows, and the side of the mesh that is outside."""

    start_borders: tuple[tuple[int, int], ...] = setting(
        (), "border from which rows start, whole: the two vertices of one of its edges, counted from 0",
        flag="start-border", form="V,W",
    )  # fmt: skip
    start_edges: tuple[tuple[int, int], ...] = setting(
        (), "course edge from which rows start: its border up to the next corners, or the edge loop through it",
        flag="start-edge", former_flag="--seed", form="V,W",
    )  # fmt: skip
    flip: tuple[int, ...] = setting((), "face whose row is reversed, counted from 0", form="FACE")
    turn_inside_out: bool = setting(
        False, "reverse all faces of the mesh first, so that its other side is outside"
    )


@dataclass(frozen=True, kw_only=True)
class RowsSection(ShapingOptions):
    """Rows that are found on a mesh of any kind, instead of the labeled rows of a modelled mesh.

    Raises:
        ParameterError: another key is given without ``auto``, or as for ``ShapingOptions``. ``GarmentSettings`` checks
            the placement of increases and decreases, because it may also apply to panels.
    """

    auto: bool = setting(False, "find rows and stitches on any mesh, also of triangles; the mesh is repaired first")

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in () if self.auto else changed_settings(self):
            if name != "shaping":
                raise ParameterError(f"{name}: is for rows that are found; give auto (--auto) too")

    def options(self, up: Direction = Y) -> ShapingOptions | None:
        """Return how rows are found; None if the rows of the mesh are labeled.

        Args:
            up: direction that points up in the coordinates of the marks; the marks are turned so that it becomes y.
        """
        if not self.auto:
            return None
        marks = tuple(mark.turned(upright_turn(up)) for mark in self.marks)
        return ShapingOptions(
            up=self.up, multiple=self.multiple, short_rows=self.short_rows, marks=marks,
            most_shaping=self.most_shaping, shaping=self.shaping,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class PanelsSection(PanelOptions):
    """Panels of a sewing pattern, each knitted in its own direction.

    Raises:
        ParameterError: another key is given without ``knit``, or as for ``PanelOptions``.
    """

    knit: bool = setting(
        False, "knit the mesh as a sewing pattern, panel by panel, by its texture coordinates or groups "
        "(docs/panels.md)", flag="panels",
    )  # fmt: skip

    def __post_init__(self) -> None:
        for name in () if self.knit else changed_settings(self):
            raise ParameterError(f"{name}: is for the panels of a sewing pattern; give knit (--panels) too")
        super().__post_init__()

    def options(self, placement: Placement = DEFAULT_PLACEMENT) -> PanelOptions | None:
        """Return how the panels are knitted; None if the mesh is no sewing pattern.

        Args:
            placement: where increases and decreases stand if the section does not place them.
        """
        if not self.knit:
            return None
        shaping = placement if self.shaping == DEFAULT_PLACEMENT else self.shaping
        return PanelOptions(directions=self.directions, sewn=self.sewn, shaping=shaping)


@dataclass(frozen=True, kw_only=True)
class StitchesSection:
    """Height of the stitches, how increases are made, and numbers of stitches along single edges of the mesh."""

    course_height: float | None = setting(
        None, "course spacing", unit="cm", unset=f"{COURSE_OVER_WALE_SPACING} stitch widths", example=0.6
    )
    increase: Increase = setting(
        DEFAULT_INCREASE, "increases: m1 (make one, closed), kfb (knit front and back), lifted (into the loop below, "
        "which stays beside), or yo (open yarn-overs)",
    )  # fmt: skip
    counts: tuple[str, ...] = setting(
        (), "number of stitches along an edge, named by its two vertices, counted from 0; for a wale edge of its whole "
        "row", flag="count", form="V,W=COUNT",
    )  # fmt: skip
    marked: tuple[tuple[int, int], ...] = setting(
        (), "wale edge at which all increases and decreases of its faces stand: its two vertices, counted from 0",
        flag="mark", form="V,W",
    )  # fmt: skip
    edges: str | None = setting(
        None, "text file of counts V,W=COUNT and marked edges V,W, one on each line", form="FILE", unset="no file",
        example="edges.txt",
    )  # fmt: skip

    def edge_settings(self) -> EdgeSettings:
        """Return the counts and marked edges of the section and of the file.

        Raises:
            FileError: the file cannot be read, or a line is malformed.
            ParameterError: a count is malformed, or two counts for one edge differ.
        """
        from stitchmesh.tessellate.edge_file import EdgeSettings, parse_edge_counts, read_edge_settings

        given = parse_edge_counts(self.counts).joined(EdgeSettings(marked=self.marked))
        return given if self.edges is None else read_edge_settings(self.edges).joined(given)


@dataclass(frozen=True, kw_only=True)
class MaterialSection:
    """Material of the yarn."""

    name: str | None = setting(
        None, f"material, scaled to the yarn radius: {', '.join(sorted(NAMED))}; or a yarn, or its file",
        flag="material", form="NAME", unset=f"that of the yarn, or {DEFAULT_MATERIAL}", example=DEFAULT_MATERIAL,
    )  # fmt: skip
    stiffness: tuple[str, ...] = setting(
        (), f"one value of the material, of a yarn with a radius of {REFERENCE_RADIUS} cm; the values are "
        f"{MATERIAL_VALUES}", form="NAME=VALUE",
    )  # fmt: skip

    def values(self) -> dict[str, float]:
        """Return the changed values of the material, by name.

        Raises:
            ParameterError: a value is malformed, or its name is unknown.
        """
        return parse_stiffnesses(self.stiffness)

    def chosen(self, yarn: str | None) -> str:
        """Return the name of the material, by default that of the yarn, whose name or None is given."""
        return self.name or yarn or DEFAULT_MATERIAL

    def yarn_material(
        self, yarn_radius: float, mass_per_length: ArrayLike | None, yarn: str | None = None
    ) -> YarnMaterial:
        """Return the material of a yarn.

        Args:
            yarn_radius: radius of the yarn [cm].
            mass_per_length: mass of a length that the yarn states [g/cm], as for ``check_one_mass``.
            yarn: name of the yarn, or path of its description.

        Raises:
            ParameterError: the material or a value is unknown, a value is out of bounds, or the yarn has two masses.
        """
        stiffness = self.values()
        check_one_mass(stiffness, mass_per_length)
        return YarnMaterial.named(self.chosen(yarn), stiffness).of_radius(yarn_radius)


@dataclass(frozen=True, kw_only=True)
class RestLengthsSection:
    """Rest lengths of the yarns, as factors of the generated lengths."""

    factor: float = setting(
        RestLengths.factor, "factor for all yarns; less than 1 makes the fabric tighter", flag="rest-length-factor",
        form="F",
    )  # fmt: skip
    loop_length: float | None = setting(
        RestLengths.loop_length, "yarn length of every plain stitch before the factors apply", unit="cm",
        unset="as generated", example=2.0,
    )  # fmt: skip
    factors: tuple[str, ...] = setting((), f"factor {FACTORS}", flag="rest-length", form="KEY=F")

    def rest_lengths(self, loop_length: float | None = None) -> RestLengths:
        """Return the changes of the rest lengths.

        Args:
            loop_length: yarn length of every plain stitch if the section has none [cm].

        Raises:
            ParameterError: a factor is malformed or out of bounds.
        """
        length = loop_length if self.loop_length is None else self.loop_length
        return parse_rest_lengths(self.factors, factor=self.factor, loop_length=length)


@dataclass(frozen=True, kw_only=True)
class PhysicsSection:
    """Additional energies; each energy acts only if its setting is given."""

    gravity: tuple[float, float, float] | None = setting(
        None, "acceleration of gravity; 0 -981 0 on Earth if y points up", unit="cm/s^2", form="X Y Z", unset="off",
        example=(0, -981, 0),
    )  # fmt: skip
    friction: float | tuple[float, float] | None = setting(
        None, "coefficient of friction between yarns, or two coefficients: along the yarn and across the yarn",
        form="MU[,MU]", unset="off", example=0.2,
    )  # fmt: skip
    twist: float | tuple[float, float] | None = setting(
        None, "torsional stiffness [erg cm], and twist of each yarn from end to end [rad], 0 if it is not given",
        form="K[,ANGLE]", unset="off", example=0.1,
    )  # fmt: skip
    body: str | None = setting(
        None, "polygon mesh of a solid body that the yarns do not enter", form="MESH", unset="off", example="body.obj"
    )
    body_unit: str = setting(DEFAULT_UNIT, "unit of the file of the body", form="UNIT")
    body_up: Direction | None = setting(
        None, "direction in the file of the body that points up", form="AXIS|X,Y,Z", unset="that of the mesh, or y",
        example=(0, 0, 1),
    )  # fmt: skip

    def terms(self, up: Direction = Y) -> list[YarnChoice]:
        """Return the energies whose keys are given; the modules of the other energies are not imported.

        Args:
            up: direction that points up in the file of the garment, and in the file of a body whose format does not fix
                it.

        Raises:
            FileError: the body cannot be read.
            ParameterError: a value is out of bounds, or there is a unit of a body but no body.
        """
        if self.body is None and self.body_unit != DEFAULT_UNIT:
            raise ParameterError(f"body unit: got {self.body_unit!r} without a body; give the body, or leave it out")
        terms: list[YarnChoice] = []
        if self.gravity is not None:
            from stitchmesh.simulation.dead_load import Gravity

            terms.append(Gravity(self.gravity))
        if self.friction is not None:
            from stitchmesh.yarnrelax.friction.friction import Friction

            terms.append(Friction(self.friction))
        if self.twist is not None:
            from stitchmesh.yarnrelax.energies.twist import Twist

            terms.append(Twist(*self.twist) if isinstance(self.twist, tuple) else Twist(self.twist))
        if self.body is not None:
            from stitchmesh.io.garments import read_body
            from stitchmesh.yarnrelax.energies.body import Body

            terms.append(Body(read_body(self.body, unit=self.body_unit, up=self.body_up or up)))
        return terms


@dataclass(frozen=True, kw_only=True)
class SolverSection:
    """Method and limits of the relaxation of yarns."""

    method: Solver | None = setting(
        None, "method: quasistatic, or dynamics (Leaf et al. 2018)", flag="solver", form="NAME",
        unset="that of the quality", example="dynamics",
    )  # fmt: skip
    max_iterations: int | None = setting(
        None, "largest number of iterations of the relaxation", form="N", unset="that of the quality", example=20_000,
        least=1, expected="at least 1",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)

    def quality(self, preset: str) -> str | Quality:
        """Return the preset, changed by this section.

        Raises:
            ParameterError: the preset is unknown, or a number is out of bounds.
        """
        quality_named(preset)
        return quality_with(preset, solver=self.method, max_iterations=self.max_iterations)


@dataclass(frozen=True, kw_only=True)
class RecipePattern:
    """A pattern on a part of the garment."""

    pattern: str
    """Name of a pattern of the library, or the path of a file."""
    on: str | None = setting(
        None, "part of the fabric that takes the pattern, such as 'hem 6' (docs/selections.md)", form="SELECTION",
        unset="the whole fabric",
    )  # fmt: skip
    remainder: str = setting(
        DEFAULT_REMAINDER, "treatment of stitches that remain beside whole tiles of the pattern: centre, stretch or "
        "refuse", form="HOW",
    )  # fmt: skip
    ground: str | None = setting(
        None, "colour of a chart that stitches left over take, or number of a yarn", form="COLOUR",
        unset="the commonest",
    )  # fmt: skip
    shift: tuple[int, int] = setting(
        (0, 0), "stitches to the right and rows upwards by which it is moved", form="STITCHES ROWS"
    )
    mirror: bool = setting(False, "exchange left and right of the pattern")
    centre: bool = setting(
        False, "put the middle of a repeat in the middle of the front of rounds, and of flat rows"
    )


@dataclass(frozen=True, kw_only=True)
class RecipeColour:
    """A colour on a part of the garment: the number of a yarn, or its colour.

    Raises:
        ParameterError: both are given, or neither.
    """

    on: str
    """Selection."""
    yarn: int | None = None
    """Number of the yarn, a place in the palette counted from 0."""
    colour: str | None = None
    """Colour (``parse_colour``); a colour that the palette does not have is added to it."""

    def __post_init__(self) -> None:
        if (self.yarn is None) == (self.colour is None):
            raise ParameterError(f"on '{self.on}': expected either a yarn number or a colour")


@dataclass(frozen=True, kw_only=True)
class YarnAndGauge:
    """A yarn and a gauge, which decide all sizes that are not given."""

    yarn: str | None = setting(
        None, f"yarn: {', '.join(yarn_names())}; more with `stitchmesh yarn list`, or a file yarn.toml", form="NAME",
        unset="none", example="dk",
    )
    gauge: str | None = setting(
        None, "stitches and rows in 10 cm of stockinette, for example 22 or 22x30", form="STITCHES[xROWS]",
        unset="that of the yarn", example="22x30",
    )  # fmt: skip

    def measures(self, **lengths: float | None) -> StitchMeasures:
        """Return the sizes of stitches and yarn; ``lengths`` are the given sizes, as for ``stitch_size``.

        Raises:
            ParameterError: the yarn is unknown, the gauge is malformed, or a gauge and a stitch size are both given.
        """
        return stitch_size(self.named(), self.gauge, **lengths)

    def named(self) -> Yarn | None:
        """Return the yarn of the given name; None without a name.

        Raises:
            ParameterError: the yarn is unknown.
        """
        from stitchmesh.io.yarn_files import yarn_of

        return None if self.yarn is None else yarn_of(self.yarn)


@dataclass(frozen=True, kw_only=True)
class GarmentSettings(YarnAndGauge, MeshReading):
    """All settings of a garment, apart from its mesh, its patterns, its edits and the quality.

    Raises:
        ParameterError: increases and decreases are placed, but rows are neither found nor knitted on panels.
    """

    stitch_width: float | None = setting(
        None, "wale spacing", unit="cm", unset=f"that of the gauge or of the yarn, or {STITCH_WIDTH}", example=0.8
    )
    yarn_radius: float | None = setting(
        None, "radius of the yarn where it touches other yarn", unit="cm",
        unset="that of the yarn, or an eighth of the stitch width", example=0.1,
    )
    drawn_radius: float | None = setting(
        None, "radius of the yarn in pictures and files for renderers", unit="cm",
        unset="that of the yarn, or 1.7 times its radius", example=0.17,
    )  # fmt: skip
    mass_per_length: float | None = setting(
        None, "mass of a length of yarn", unit="g/cm", unset="that of the yarn, or of the material", example=0.004
    )
    edge_forms: tuple[str, ...] = setting(
        (), "edge that is folded or rolls, and its rows: hem=fold:5, neck=roll:4 (docs/edges.md); may be repeated",
        flag="edge-form", form="BORDER=FORM:ROWS", unset="none",
    )  # fmt: skip
    spiral: bool = setting(False, "knit tubes in one spiral row with a single yarn instead of rings")
    palette: tuple[str, ...] = setting(
        (), "colours of the yarns by number, each #rrggbb or a name such as navy; a chart adds its own colours",
        flag=None,
    )  # fmt: skip
    rows: RowsSection = field(default_factory=RowsSection)
    panels: PanelsSection = field(default_factory=PanelsSection)
    label: LabelSection = field(default_factory=LabelSection)
    stitches: StitchesSection = field(default_factory=StitchesSection)
    mesh_relaxation: MeshRelaxOptions = field(default_factory=MeshRelaxOptions)
    finish: YarnFinish = field(default_factory=YarnFinish)
    material: MaterialSection = field(default_factory=MaterialSection)
    rest_lengths: RestLengthsSection = field(default_factory=RestLengthsSection)
    physics: PhysicsSection = field(default_factory=PhysicsSection)
    solver: SolverSection = field(default_factory=SolverSection)

    def __post_init__(self) -> None:
        placed = self.rows.shaping != DEFAULT_PLACEMENT
        if placed and not (self.rows.auto or self.panels.knit):
            raise ParameterError("shaping: is for rows that are found; give auto (--auto) too")

    @property
    def size(self) -> StitchMeasures:
        """Sizes of stitches and yarn.

        Raises:
            ParameterError: the yarn is unknown, the gauge is malformed, or a gauge and a stitch size are both given.
        """
        return self.measures(
            stitch_width=self.stitch_width, stitch_height=self.stitches.course_height, yarn_radius=self.yarn_radius,
            drawn_radius=self.drawn_radius, mass_per_length=self.mass_per_length,
        )  # fmt: skip
