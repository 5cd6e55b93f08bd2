# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The sections of a recipe, as numbers, texts and lists, and the options of the stages that follow from them.

The names of the fields are the keys of the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Literal

from stitchmesh.errors import ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase
from stitchmesh.mesh.upright import Direction, Y, upright_turn
from stitchmesh.quality import Quality, Solver, quality_named, quality_with
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, UP, Placement, ShapingOptions
from stitchmesh.shaping.panels.options import PanelOptions
from stitchmesh.yarn.rest_length import RestLengths, parse_rest_lengths
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL, parse_stiffnesses

if TYPE_CHECKING:
    from stitchmesh.tessellate.edge_file import EdgeSettings
    from stitchmesh.yarnrelax.energies.term import TermChoice


@dataclass(frozen=True, kw_only=True)
class LabelSection:
    """How the knitting rows are found, and which side of the mesh is outside."""

    start_borders: tuple[tuple[int, int], ...] = ()
    """Borders from which rows start, whole: each named by the two vertices of one of its edges."""
    start_edges: tuple[tuple[int, int], ...] = ()
    """Course edges from which rows start, each named by its two vertices."""
    flip: tuple[int, ...] = ()
    """Faces whose rows are reversed."""
    turn_inside_out: bool = False
    """Whether all faces of the mesh are reversed first, so that its other side is outside."""


@dataclass(frozen=True, kw_only=True)
class MarkTable:
    """A mark on the surface: where knitting begins or ends, a line along which a row runs, or a plain place."""

    kind: Literal["border", "stroke", "point"]
    """The border nearest to the first point, a line through all points, or a tip at the first point."""
    points: tuple[tuple[float, float, float], ...]
    """Points on the surface [cm]."""
    role: Literal["begin", "end", "row", "side", "plain"] = "row"
    """Whether knitting begins or ends here, a row runs here, rows end at this border, or shaping is kept away."""
    time: float | None = None
    """Distance along the fabric from where knitting begins [cm]."""
    radius: float | None = None
    """Distance from a plain mark up to which the fabric is plain [cm]."""

    def time_mark(self) -> TimeMark:
        """Return the mark as the library holds it.

        Raises:
            ParameterError: as for ``TimeMark``.
        """
        return TimeMark(self.kind, self.points, self.role, self.time, self.radius)


@dataclass(frozen=True, kw_only=True)
class RowsSection:
    """Rows that are found on a mesh of any kind, in the place of the labeled rows of a modelled mesh.

    Raises:
        ParameterError: another key is given without ``auto``, or as for ``ShapingOptions``.
    """

    auto: bool = False
    """Whether rows are found; the mesh is repaired first."""
    up: tuple[float, float, float] = UP
    """Direction in which the garment is knitted where nothing else decides, after its mesh was turned upright."""
    multiple: int = 1
    """Number that the stitches of each round are a multiple of."""
    short_rows: bool = ShapingOptions.short_rows
    """Whether the yarn turns back and comes again where rows are far too high."""
    marks: tuple[MarkTable, ...] = ()
    """Where knitting begins and ends, lines along which rows run, and plain places."""
    most_shaping: float | None = None
    """Largest part of the stitches of a row that are increases or decreases."""
    shaping: Placement = DEFAULT_PLACEMENT
    """Where increases and decreases stand: ``seams`` or ``spread``."""

    def __post_init__(self) -> None:
        for part in fields(self) if not self.auto else ():
            if getattr(self, part.name) != part.default:
                raise ParameterError(f"{part.name}: is for rows that are found; give auto (--auto) too")
        self.options()

    def options(self, up: Direction = Y) -> ShapingOptions | None:
        """Return how rows are found; None if the rows of the mesh are labeled.

        Args:
            up: direction that points up where the marks were set; they are turned so that it is y.
        """
        if not self.auto:
            return None
        marks = tuple(mark.turned(upright_turn(up)) for mark in time_marks(self.marks))
        return ShapingOptions(
            up=self.up, multiple=self.multiple, short_rows=self.short_rows, marks=marks,
            most_shaping=self.most_shaping, shaping=self.shaping,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class DirectionTable:
    """The direction of knitting of a panel."""

    panel: int | str
    """Number of the panel, or a name: then of all panels whose object, group or material has it."""
    direction: tuple[float, float]
    """Direction in the texture (u, v)."""


@dataclass(frozen=True, kw_only=True)
class PanelsSection:
    """Panels of a sewing pattern that are knitted one by one, in the place of the labeled rows of a modelled mesh.

    Raises:
        ParameterError: another key is given without ``knit``, or as for ``PanelOptions``.
    """

    knit: bool = False
    """Whether the mesh is a sewing pattern, whose panels are knitted."""
    directions: tuple[DirectionTable, ...] = ()
    """Directions of knitting of panels; (0, 1) for all others."""
    sewn: tuple[tuple[int | str, int | str], ...] = ()
    """Pairs of panels whose seams are left to be sewn, also where their stitches fit."""
    shaping: Placement = DEFAULT_PLACEMENT
    """Where increases and decreases stand: at both ends of the rows (``seams``) or ``spread``."""

    def __post_init__(self) -> None:
        for part in fields(self) if not self.knit else ():
            if getattr(self, part.name) != part.default:
                raise ParameterError(f"{part.name}: is for the panels of a sewing pattern; give knit (--panels) too")
        self.options()

    def options(self) -> PanelOptions | None:
        """Return how the panels are knitted; None if the mesh is no sewing pattern."""
        if not self.knit:
            return None
        directions = tuple((one.panel, one.direction) for one in self.directions)
        return PanelOptions(directions=directions, sewn=self.sewn, shaping=self.shaping)


def time_marks(marks: Sequence[MarkTable]) -> tuple[TimeMark, ...]:
    """Return marks as the library holds them.

    Raises:
        ParameterError: as for ``TimeMark``; the message has the number of the mark.
    """
    found = []
    for number, mark in enumerate(marks):
        try:
            found.append(mark.time_mark())
        except ParameterError as error:
            raise ParameterError(f"marks[{number}]: {str(error).removeprefix('mark: ')}") from error
    return tuple(found)


@dataclass(frozen=True, kw_only=True)
class StitchesSection:
    """Height of the stitches, how increases are made, and numbers of stitches along single edges of the mesh.

    Raises:
        ParameterError: there is no such form of increases.
    """

    course_height: float | None = None
    """Course spacing [cm]."""
    increase: Increase = DEFAULT_INCREASE
    """How increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo``."""
    counts: tuple[str, ...] = ()
    """Numbers of stitches along edges, ``V,W=COUNT``."""
    marked: tuple[tuple[int, int], ...] = ()
    """Wale edges at which all increases and decreases of their faces stand, each named by its two vertices."""
    edges: str | None = None
    """Path of a file of counts and marked edges."""

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

    name: str = DEFAULT_MATERIAL
    """Name of the material."""
    stiffness: tuple[str, ...] = ()
    """New values of the material, ``NAME=VALUE``."""

    def values(self) -> dict[str, float]:
        """Return the changed values of the material, by name.

        Raises:
            ParameterError: a value is malformed, or its name is unknown.
        """
        return parse_stiffnesses(self.stiffness)


@dataclass(frozen=True, kw_only=True)
class RestLengthsSection:
    """Rest lengths of the yarns."""

    factor: float = RestLengths.factor
    """Factor of all yarns."""
    loop_length: float | None = RestLengths.loop_length
    """Yarn length of every plain stitch before the factors apply [cm]."""
    factors: tuple[str, ...] = ()
    """Factors of stitches, rows, yarns and parts, ``KEY=FACTOR``."""

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
    """Additional energies; each energy acts only if its key is given."""

    gravity: tuple[float, float, float] | None = None
    """Acceleration of gravity [cm/s^2]."""
    friction: float | tuple[float, float] | None = None
    """Coefficient of friction, or two: along the yarn and across the yarn."""
    twist: float | tuple[float, float] | None = None
    """Torsional stiffness [erg cm], and optionally the twist of each yarn from end to end [rad]."""
    body: str | None = None
    """Path of a polygon mesh of a solid body that the yarns do not enter."""
    body_unit: str = DEFAULT_UNIT
    """Unit of the file of the body."""
    body_up: Direction | None = None
    """Direction in the coordinates of this file that points up; None for that of the mesh of the garment."""

    def terms(self, up: Direction = Y) -> list[TermChoice]:
        """Return the energies whose keys are given; the modules of the other energies are not imported.

        Args:
            up: direction that points up in the file of the garment, and in that of a body that does not say it.

        Raises:
            FileError: the body cannot be read.
            ParameterError: a value is out of bounds, or there is a unit of a body but no body.
        """
        if self.body is None and self.body_unit != DEFAULT_UNIT:
            raise ParameterError(f"body unit: got {self.body_unit!r} without a body; give the body, or leave it out")
        terms: list[TermChoice] = []
        if self.gravity is not None:
            from stitchmesh.yarnrelax.energies.gravity import Gravity

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

    method: Solver | None = None
    """``quasistatic`` or ``dynamics``; None for that of the quality."""
    max_iterations: int | None = None
    """Largest number of iterations; None for that of the quality."""

    def quality(self, preset: str) -> str | Quality:
        """Return the preset, changed by this section.

        Raises:
            ParameterError: the preset is unknown, or a number is out of bounds.
        """
        quality_named(preset)
        return quality_with(preset, solver=self.method, max_iterations=self.max_iterations)
