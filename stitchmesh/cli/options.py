# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options of several commands. Each group is a frozen dataclass, and the defaults are those of the library.

The docstring of a field is the help text of the option.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from numpy.typing import ArrayLike
from tyro.conf import UseAppendAction, arg

from stitchmesh.cli.arguments import Direction, Flag, OneOrTwo, Pair, help_entry
from stitchmesh.compute.threads import VARIABLE
from stitchmesh.errors import ParameterError
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.mesh.layers import Layer
from stitchmesh.mesh.palette import Palette, parse_yarn_colours, recolour_palette
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase
from stitchmesh.meshrelax.options import MeshRelaxOptions
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, SPACING, SwatchOptions
from stitchmesh.quality import PRESETS, Quality, Solver, quality_with
from stitchmesh.recipe.sections import (
    LabelSection,
    MaterialSection,
    PhysicsSection,
    RestLengthsSection,
    StitchesSection,
)
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarn.stitch_size import StitchMeasures, stitch_size
from stitchmesh.yarn.yarn_presets import Yarn, yarn_names
from stitchmesh.yarnrelax.model.material import (
    DEFAULT_MATERIAL,
    NAMED,
    REFERENCE_RADIUS,
    YarnMaterial,
    check_one_mass,
)

if TYPE_CHECKING:
    from stitchmesh.faces.face_mesh import FaceMesh
    from stitchmesh.io.garments import MeshReading
    from stitchmesh.mesh import Mesh
    from stitchmesh.pipeline.options import RelaxOptions
    from stitchmesh.run import Run
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarnrelax.energies.term import ConstraintChoice

READ_STITCHES = "stitch mesh: .h5, .smobj or .st"
WRITTEN_STITCHES = "stitch mesh: .h5, .smobj, or .k for a knitting machine"
READ_YARNS = "yarns: .h5, .pyp, .bcc, .yarns, .usda, .usdc, .vtp or .obj"
WRITTEN_YARNS = "yarns: .h5, .pyp, .bcc, .yarns, .usda, .usdc, .vtp, .glb or .obj"
FOUND_RADIUS = "from the file, or estimated from the distances between yarns"
SWATCH_RADIUS = f"that of the yarn, or {SwatchOptions.yarn_radius}"
SWATCH_LOOP = f"that of the gauge or of the yarn, or {COMPACT_LOOP} diameters"
DRAWN_RADIUS = "that of the yarn, or 1.7 times its radius"
GENERATED_RADIUS = "that of the yarn, or an eighth of the stitch width"

FACTORS = (
    "for a stitch type (k=1.1), a row (row:3=0.9), a yarn (yarn:12=1.2), or the floats or held loops of slip stitches "
    "(floats=F, held=F)"
)

ASPECT_UNSET = f"that of the stitches, {COURSE_OVER_WALE_SPACING} if it is not known"
STIFFNESS_HELP = (
    f"one value of the material, of a yarn with a radius of {REFERENCE_RADIUS} cm; the values are "
    f"{', '.join(field.name for field in fields(YarnMaterial))}"
)

QualityName = Annotated[str, help_entry("NAME", help=f"preset of accuracy and cost: {', '.join(PRESETS)}")]
Device = Annotated[
    str | None, help_entry("NAME", "the first GPU, or the CPU without a GPU", help="processor: cpu or cuda:0")
]
Threads = Annotated[int | None, help_entry("N", f"that of {VARIABLE}, or all cores", help="number of threads on a CPU")]
Overwrite = Annotated[
    Flag, help_entry("", help="replace files that StitchMesh did not write or that were changed since, but no input")
]
Unit = Annotated[str, help_entry("UNIT", help=f"unit of a file that states no unit: {', '.join(CENTIMETRES)}")]
StitchWidth = Annotated[
    float | None, help_entry("CM", f"that of the gauge or of the yarn, or {STITCH_WIDTH}", help="wale spacing [cm]")
]
YarnName = Annotated[str | None, help_entry("NAME", "none", help=f"hand-knitting yarn: {', '.join(yarn_names())}")]
Material = Annotated[str, help_entry("NAME", help=f"material, scaled to the yarn radius: {', '.join(sorted(NAMED))}")]
MaxIterations = Annotated[
    int | None, help_entry("N", "that of the quality", help="largest number of iterations of the relaxation")
]
OnSelection = Annotated[
    str | None, help_entry("SELECTION", "none", help="part of the fabric, such as 'hem 6' (docs/selections.md)")
]
Ground = Annotated[
    str | None,
    help_entry("COLOUR", "the commonest", help="colour of a chart that stitches left over take, or number of a yarn"),
]
Shift = Annotated[
    tuple[int, int], help_entry("STITCHES ROWS", help="stitches to the right and rows upwards by which it is moved")
]
Mirror = Annotated[Flag, help_entry("", help="exchange left and right of the pattern")]
Centre = Annotated[
    Flag, help_entry("", help="put the middle of a repeat in the middle of the front of rounds, and of flat rows")
]
ReportFolder = Annotated[
    str | None, help_entry("DIR", "no report", help="folder for report.json, convergence.csv and convergence.png")
]


@dataclass(frozen=True)
class MeshInFile:
    """What of the file of a mesh is knitted, and how it stands."""

    object: Annotated[UseAppendAction[tuple[str, ...]], help_entry("NAME", "all that can be garments")] = ()
    """object or group of the file that is knitted, by its name; may be repeated"""
    layer: Annotated[Layer, help_entry("LAYER")] = "outer"
    """layer of a garment with a thickness that is knitted: outer, inner or middle"""
    up: Annotated[Direction, help_entry("AXIS|X,Y,Z", "as the file states, or as its openings tell")] = None
    """direction in the file that points up, which becomes y: an axis such as z or -x, or three numbers"""

    def reading(self, unit: str) -> MeshReading:
        """Return how a mesh in a unit is read."""
        from stitchmesh.io.garments import MeshReading

        return MeshReading(unit=unit, up=self.up, objects=self.object, layer=self.layer)


@dataclass(frozen=True)
class FileReading:
    """Properties that a file may not state."""

    unit: Unit = DEFAULT_UNIT
    yarn_radius: Annotated[float | None, help_entry("CM", FOUND_RADIUS)] = None
    """radius of the yarns [cm]"""
    up: Annotated[Direction, help_entry("AXIS|X,Y,Z", "y")] = None
    """direction in the file of a polygon mesh that points up, which becomes y"""

    def read(self, path: str) -> Mesh | YarnSet | FaceMesh:
        """Read a file.

        Raises:
            ParameterError: as for ``read_any``, or a direction is given for stitches or yarns, whose y points up.
        """
        from stitchmesh.io.any_file import read_any
        from stitchmesh.mesh import Mesh
        from stitchmesh.mesh.upright import turned_upright

        found = read_any(path, unit=self.unit, radius=self.yarn_radius)
        if self.up is None:
            return found
        if type(found) is not Mesh:
            raise ParameterError(f"up: {path} holds no polygon mesh, and y points up in it; leave --up out")
        return turned_upright(found, self.up)


@dataclass(frozen=True)
class YarnAndGauge:
    """A yarn and a gauge, from which the sizes follow that are not given."""

    yarn: YarnName = None
    gauge: Annotated[str | None, help_entry("STITCHES[xROWS]", "that of the yarn")] = None
    """stitches and rows in 10 cm of stockinette, for example 22 or 22x30"""

    def size(self, **lengths: float | None) -> StitchMeasures:
        """Return the sizes of stitches and yarn; ``lengths`` are the given ones, as for ``stitch_size``.

        Raises:
            ParameterError: the yarn is unknown, the gauge is malformed, or a gauge and a stitch size are both given.
        """
        return stitch_size(self.yarn, self.gauge, **lengths)

    def named(self) -> Yarn | None:
        """Return the yarn that is named; None if there is none.

        Raises:
            ParameterError: the yarn is unknown.
        """
        return None if self.yarn is None else Yarn.named(self.yarn)


@dataclass(frozen=True)
class RowOptions:
    """Starts and directions of the knitting rows, and the side of the mesh that is outside."""

    start_border: Annotated[UseAppendAction[tuple[Pair, ...]], help_entry("V,W")] = ()
    """border from which rows start, whole: the two vertices of one of its edges, counted from 0"""
    start_edge: Annotated[UseAppendAction[tuple[Pair, ...]], help_entry("V,W", also="--seed")] = ()
    """course edge from which rows start: its border up to the next corners, or the edge loop through it"""
    flip: Annotated[UseAppendAction[tuple[int, ...]], help_entry("FACE")] = ()
    """face whose row is reversed, counted from 0"""
    turn_inside_out: Flag = False
    """reverse all faces of the mesh first, so that its other side is outside"""

    def section(self) -> LabelSection:
        """Return the section of a recipe."""
        return LabelSection(
            start_borders=self.start_border,
            start_edges=self.start_edge,
            flip=self.flip,
            turn_inside_out=self.turn_inside_out,
        )


@dataclass(frozen=True)
class StitchCounts:
    """Height of the stitches, how increases are made, and numbers of stitches along single edges of the mesh."""

    course_height: Annotated[float | None, help_entry("CM", f"{COURSE_OVER_WALE_SPACING} stitch widths")] = None
    """course spacing [cm]"""
    increase: Annotated[Increase, help_entry("NAME")] = DEFAULT_INCREASE
    """increases: m1 (make one, closed), kfb (knit front and back), lifted (into the loop below, which stays beside), or
    yo (open yarn-overs)"""
    count: Annotated[UseAppendAction[tuple[str, ...]], help_entry("V,W=COUNT")] = ()
    """number of stitches along an edge, named by its two vertices, counted from 0; for a wale edge of its whole row"""
    mark: Annotated[UseAppendAction[tuple[Pair, ...]], help_entry("V,W")] = ()
    """wale edge at which all increases and decreases of its faces stand: its two vertices, counted from 0"""
    edges: Annotated[str | None, help_entry("FILE", "no file")] = None
    """text file of counts V,W=COUNT and marked edges V,W, one on each line"""

    def section(self) -> StitchesSection:
        """Return the section of a recipe."""
        return StitchesSection(
            course_height=self.course_height, increase=self.increase, counts=self.count, marked=self.mark,
            edges=self.edges,
        )  # fmt: skip


@dataclass(frozen=True)
class MeshRelaxation:
    """Relaxation of the stitch mesh."""

    aspect: Annotated[float | None, help_entry("R", ASPECT_UNSET)] = None
    """height of an unstressed stitch divided by its width"""
    alpha: Annotated[float, help_entry("PART")] = MeshRelaxOptions.alpha
    """part of the surface that unstressed stitches cover, above 0 and at most 1"""
    no_area_force: Flag = not MeshRelaxOptions.area_force
    """let crowded stitches lose area without resistance; compressed openwork may then fold over"""

    def mesh_relax_options(self) -> MeshRelaxOptions:
        """Return the options of the relaxation of the stitch mesh.

        Raises:
            ParameterError: a number is out of bounds.
        """
        return MeshRelaxOptions(aspect=self.aspect, alpha=self.alpha, area_force=not self.no_area_force)


@dataclass(frozen=True)
class MaterialOptions:
    """Material of the yarn."""

    material: Material = DEFAULT_MATERIAL
    stiffness: Annotated[UseAppendAction[tuple[str, ...]], help_entry("NAME=VALUE", help=STIFFNESS_HELP)] = ()

    def section(self) -> MaterialSection:
        """Return the section of a recipe."""
        return MaterialSection(name=self.material, stiffness=self.stiffness)

    def yarn_material(self, yarn_radius: float, mass_per_length: ArrayLike | None) -> YarnMaterial:
        """Return the material of a yarn.

        Args:
            yarn_radius: radius of the yarn [cm].
            mass_per_length: mass of a length that the yarn states [g/cm], as for ``check_one_mass``.

        Raises:
            ParameterError: the material or a value is unknown, a value is out of bounds, or the yarn has two masses.
        """
        stiffness = self.section().values()
        check_one_mass(stiffness, mass_per_length)
        return YarnMaterial.named(self.material, stiffness).of_radius(yarn_radius)


@dataclass(frozen=True)
class YarnColours:
    """Colours of the yarns in pictures and files."""

    colour: Annotated[UseAppendAction[tuple[str, ...]], help_entry("N=COLOUR", "those of the pattern")] = ()
    """colour of a yarn number: #rrggbb or a name, such as 0=cream; may be repeated"""

    def recoloured(self, palette: Palette) -> Palette:
        """Return a palette with these colours.

        Raises:
            ParameterError: a text has no number or no colour.
        """
        return recolour_palette(palette, parse_yarn_colours(self.colour))


@dataclass(frozen=True)
class RestLengthFactors:
    """Rest lengths of the yarns, as factors of the generated lengths."""

    rest_length_factor: Annotated[float, help_entry("F")] = RestLengths.factor
    """factor for all yarns"""
    loop_length: Annotated[float | None, help_entry("CM", "as generated")] = RestLengths.loop_length
    """yarn length of every plain stitch before the factors apply [cm]"""
    rest_length: Annotated[UseAppendAction[tuple[str, ...]], help_entry("KEY=F", help=f"factor {FACTORS}")] = ()

    def section(self) -> RestLengthsSection:
        """Return the section of a recipe."""
        return RestLengthsSection(
            factor=self.rest_length_factor, loop_length=self.loop_length, factors=self.rest_length
        )


@dataclass(frozen=True)
class MorePhysics:
    """Additional energies; each energy acts only if its option is given."""

    gravity: Annotated[tuple[float, float, float] | None, help_entry("X Y Z", "off")] = None
    """acceleration of gravity [cm/s^2]; 0 -981 0 on Earth if y points up"""
    friction: Annotated[OneOrTwo, help_entry("MU[,MU]", "off")] = None
    """coefficient of friction between yarns, or two coefficients: along the yarn and across the yarn"""
    twist: Annotated[OneOrTwo, help_entry("K[,ANGLE]", "off")] = None
    """torsional stiffness [erg cm], and twist of each yarn from end to end [rad], 0 if it is not given"""
    body: Annotated[str | None, help_entry("MESH", "off")] = None
    """polygon mesh of a solid body that the yarns do not enter"""
    body_unit: Annotated[str, help_entry("UNIT")] = DEFAULT_UNIT
    """unit of the file of the body"""
    body_up: Annotated[Direction, help_entry("AXIS|X,Y,Z", "that of the mesh, or y")] = None
    """direction in the file of the body that points up"""

    def section(self) -> PhysicsSection:
        """Return the section of a recipe."""
        return PhysicsSection(
            gravity=self.gravity,
            friction=_number_or_pair(self.friction),
            twist=_number_or_pair(self.twist),
            body=self.body,
            body_unit=self.body_unit,
            body_up=self.body_up,
        )


def _number_or_pair(numbers: tuple[float, ...] | None) -> float | tuple[float, float] | None:
    """Return a single number, or two numbers as a pair."""
    if numbers is None or len(numbers) == 1:
        return None if numbers is None else numbers[0]
    return numbers[0], numbers[1]


@dataclass(frozen=True)
class SolverOptions:
    """Method and limits of the relaxation of yarns."""

    solver: Annotated[Solver | None, help_entry("NAME", "that of the quality")] = None
    """method: quasistatic, or dynamics (Leaf et al. 2018)"""
    max_iterations: MaxIterations = None
    checkpoint_every: Annotated[int | None, help_entry("N", "no checkpoints")] = None
    """write a checkpoint every N iterations, to the output folder or to OUTPUT.checkpoints beside the output file"""
    resume: Annotated[str | None, help_entry("PATH", "a new relaxation")] = None
    """checkpoint (.smc) from which the relaxation continues; give the same other options as before"""

    def quality(self, preset: str) -> str | Quality:
        """Return the preset, changed by these options."""
        return quality_with(preset, solver=self.solver, max_iterations=self.max_iterations)

    def relax_options(
        self, physics: MorePhysics, rest_lengths: RestLengths, material: MaterialOptions
    ) -> RelaxOptions:
        """Return the options of the relaxation.

        Args:
            physics: additional energies.
            rest_lengths: changes of the rest lengths.
            material: material of the yarn.
        """
        from stitchmesh.pipeline.options import RelaxOptions

        return RelaxOptions(
            material=material.material,
            stiffness=material.section().values(),
            rest_lengths=rest_lengths,
            terms=physics.section().terms(),
        )

    def kept_run(self, folder: Path) -> Run[YarnSet]:
        """Return the run that continues from the given checkpoint, and writes checkpoints to a folder if asked to."""
        from stitchmesh.run import Checkpoints, Run

        every = self.checkpoint_every
        return Run(checkpoints=None if every is None else Checkpoints(folder, every), resume=self.resume)


@dataclass(frozen=True)
class PinnedPlaces:
    """Control points that do not move."""

    pin_point: Annotated[UseAppendAction[tuple[int, ...]], help_entry("POINT")] = ()
    """control point that does not move, counted from 0"""
    pin_face: Annotated[UseAppendAction[tuple[int, ...]], help_entry("FACE")] = ()
    """stitch face whose control points do not move, counted from 0"""

    def constraints(self) -> list[ConstraintChoice]:
        """Return the constraints of the relaxation."""
        if not (self.pin_point or self.pin_face):
            return []
        from stitchmesh.yarnrelax.constraints.pins import Pins

        return [Pins(points=self.pin_point, faces=self.pin_face)]


@dataclass(frozen=True)
class SwatchFabric:
    """The fabric of a swatch."""

    yarn: Annotated[YarnAndGauge, arg(name="")] = field(default_factory=YarnAndGauge)
    yarn_radius: Annotated[float | None, help_entry("CM", SWATCH_RADIUS)] = None
    """yarn radius [cm]"""
    loop_length: Annotated[float | None, help_entry("CM", SWATCH_LOOP)] = None
    """yarn length of a plain stitch [cm]"""
    spacing: Annotated[tuple[float, ...] | None, help_entry("CM [CM]", f"{SPACING} diameters")] = None
    """distance between the yarns of a weave [cm], or between its warps and between its wefts"""
    gamma: Annotated[float, help_entry("G")] = SwatchOptions.gamma
    """tightness: all rest lengths are divided by this factor, 0.1 to 10"""
    columns: Annotated[int, help_entry("N")] = SwatchOptions.columns
    """number of repeats of the pattern, side by side"""
    rows: Annotated[int, help_entry("N")] = SwatchOptions.rows
    """number of repeats of the pattern, one above another"""
    longest_float: Annotated[int, help_entry("N")] = SwatchOptions.longest_float
    """largest number of stitches behind which a yarn floats; patterns with longer floats are refused"""

    def options(self, *, woven: bool, drawn_radius: float | None = None) -> dict[str, Any]:
        """Return the fields of ``SwatchOptions`` by name.

        Args:
            woven: whether the swatch is a weave, for which a yarn sets no loop length.
            drawn_radius: radius of the yarn in pictures [cm]; where not given that of the yarn.

        Raises:
            ParameterError: there are more than two spacings, the yarn is unknown, or the gauge is malformed or has
                rows, which follow from the loop length.
        """
        gauge = self.yarn.gauge
        if gauge is not None and "x" in gauge.lower():
            found = f"gauge: got {gauge!r} for a swatch, which finds its rows by itself"
            raise ParameterError(f"{found}; give the stitches alone, or hold its size (--period)")
        size = self.yarn.size(yarn_radius=self.yarn_radius, drawn_radius=drawn_radius, loop_length=self.loop_length)
        only_yarn = self.loop_length is None and self.yarn.gauge is None
        return {
            "yarn_radius": SwatchOptions.yarn_radius if size.yarn_radius is None else size.yarn_radius,
            "drawn_radius": drawn_radius if woven else size.drawn_radius,
            "mass_per_length": size.mass_per_length,
            "loop_length": None if woven and only_yarn else size.loop_length,
            "spacing": self._spacing(),
            "gamma": self.gamma,
            "columns": self.columns,
            "rows": self.rows,
            "longest_float": self.longest_float,
        }

    def _spacing(self) -> float | tuple[float, float] | None:
        """Return one spacing, the spacings of warps and of wefts, or None [cm]."""
        numbers = self.spacing
        if numbers is None or len(numbers) == 1:
            return None if numbers is None else numbers[0]
        if len(numbers) != 2:
            raise ParameterError(f"spacing: got {len(numbers)} numbers; expected one, or one of warps and one of wefts")
        return numbers[0], numbers[1]
