# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options that several commands take, each group a frozen dataclass; their defaults are those of the library."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import UseAppendAction

from stitchmesh.cli.arguments import OneOrTwo, Pair, shown
from stitchmesh.errors import ParameterError
from stitchmesh.io.units import CENTIMETRES, DEFAULT_UNIT
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, SPACING, SwatchOptions
from stitchmesh.quality import PRESETS, Quality, Solver, quality_with
from stitchmesh.yarn.rest_length import RestLengths, parse_rest_lengths
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL, NAMED

if TYPE_CHECKING:
    from stitchmesh.mesh import Mesh
    from stitchmesh.pipeline import RelaxOptions
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarnrelax.checkpoint import Checkpoints
    from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice

READ_STITCHES = "stitch mesh: .h5 or .smobj"
WRITTEN_STITCHES = "stitch mesh: .h5, .smobj, or .k for a knitting machine"
READ_YARNS = "yarns: .h5, .pyp, .bcc, .usda, .usdc, .vtp or .obj"
WRITTEN_YARNS = "yarns: .h5, .pyp, .bcc, .usda, .usdc, .vtp, .glb or .obj"
FOUND_RADIUS = "the file's own, or estimated from the distances between yarns"
GENERATED_RADIUS = "an eighth of the stitch width"

FACTORS = (
    "of a stitch type (k=1.1), of a row (row:3=0.9), of a yarn (yarn:12=1.2), or of the floats or held loops of slip "
    "stitches (floats=F, held=F)"
)

QualityName = Annotated[str, shown("NAME", help=f"accuracy and cost: {', '.join(PRESETS)}")]
Device = Annotated[str | None, shown("NAME", "the first GPU, else the CPU", help="processor: cpu or cuda:0")]
Unit = Annotated[str, shown("UNIT", help=f"unit of a file that states none: {', '.join(CENTIMETRES)}")]
StitchWidth = Annotated[float, shown("CM", help="wale spacing [cm]")]
Material = Annotated[str, shown("NAME", help=f"material, scaled to the yarn's radius: {', '.join(sorted(NAMED))}")]
MaxIterations = Annotated[
    int | None, shown("N", "the quality's", help="iterations after which the relaxation stops in any case")
]
ReportFolder = Annotated[
    str | None, shown("DIR", "no report", help="folder for report.json, convergence.csv and convergence.png")
]


@dataclass(frozen=True)
class FileReading:
    """What a file does not say about itself."""

    unit: Unit = DEFAULT_UNIT
    yarn_radius: Annotated[float | None, shown("CM", FOUND_RADIUS)] = None
    """radius of yarns [cm]"""

    def read(self, path: str) -> Mesh | YarnSet:
        """What the file holds."""
        from stitchmesh.io.any_file import read_any

        return read_any(path, unit=self.unit, radius=self.yarn_radius)


@dataclass(frozen=True)
class Rows:
    """Knitting rows."""

    seed: Annotated[UseAppendAction[tuple[Pair, ...]], shown("V,W")] = ()
    """course edge that rows start from, by its two vertices counted from 0"""
    flip: Annotated[UseAppendAction[tuple[int, ...]], shown("FACE")] = ()
    """face whose row is turned over, counted from 0"""


@dataclass(frozen=True)
class RestLengthFactors:
    """Rest lengths of yarn, as factors of the generated lengths."""

    rest_length_factor: Annotated[float, shown("F")] = RestLengths.factor
    """factor of all yarn"""
    loop_length: Annotated[float | None, shown("CM", "as generated")] = RestLengths.loop_length
    """yarn in every plain stitch before the factors [cm]"""
    rest_length: Annotated[UseAppendAction[tuple[str, ...]], shown("KEY=F", help=f"factor {FACTORS}")] = ()

    def rest_lengths(self) -> RestLengths:
        """The same for the library."""
        return parse_rest_lengths(self.rest_length, factor=self.rest_length_factor, loop_length=self.loop_length)


@dataclass(frozen=True)
class MorePhysics:
    """More energies, each of which acts only if it is given."""

    gravity: Annotated[tuple[float, float, float] | None, shown("X Y Z", "off")] = None
    """acceleration [cm/s^2]; on Earth 0 -981 0 where y points up"""
    friction: Annotated[OneOrTwo, shown("MU[,MU]", "off")] = None
    """coefficient of friction between yarns, or two: along the yarn and across it"""
    twist: Annotated[OneOrTwo, shown("K[,ANGLE]", "off")] = None
    """torsional stiffness [erg cm], and twist of each yarn from end to end [rad], 0 unless given"""
    body: Annotated[str | None, shown("MESH", "off")] = None
    """polygon mesh that the yarns stay outside of"""
    body_unit: Annotated[str, shown("UNIT")] = DEFAULT_UNIT
    """unit of the body's file"""

    def terms(self) -> list[TermChoice]:
        """The energies asked for; the module of one that is not is not imported."""
        terms: list[TermChoice] = []
        if self.gravity is not None:
            from stitchmesh.yarnrelax.energies.gravity import Gravity

            terms.append(Gravity(self.gravity))
        if self.friction is not None:
            from stitchmesh.yarnrelax.energies.friction import Friction

            along, *across = self.friction
            terms.append(Friction((along, across[0]) if across else along))
        if self.twist is not None:
            from stitchmesh.yarnrelax.energies.twist import Twist

            terms.append(Twist(*self.twist))
        if self.body is not None:
            from stitchmesh.io import read_mesh
            from stitchmesh.yarnrelax.energies.body import Body

            terms.append(Body(read_mesh(self.body, unit=self.body_unit)))
        return terms


@dataclass(frozen=True)
class SolverOptions:
    """How yarns come to rest."""

    material: Material = DEFAULT_MATERIAL
    solver: Annotated[Solver | None, shown("NAME", "the quality's")] = None
    """quasistatic, or dynamics as in Leaf 2018"""
    max_iterations: MaxIterations = None
    checkpoint_every: Annotated[int | None, shown("N", "no checkpoints")] = None
    """write a checkpoint every N iterations: in knit's folder, or beside the file in a folder of its name"""
    resume: Annotated[str | None, shown("PATH", "start anew")] = None
    """checkpoint, .smc, to go on from; give all other options as they were given then"""

    def quality(self, preset: str) -> str | Quality:
        """The preset, or what these options make of it."""
        return quality_with(preset, solver=self.solver, max_iterations=self.max_iterations)

    def relax_options(self, physics: MorePhysics, rest_lengths: RestLengths, checkpoints: Path) -> RelaxOptions:
        """The same for the library; checkpoints, if asked for, go into the folder named."""
        from stitchmesh.pipeline import RelaxOptions

        return RelaxOptions(
            material=self.material,
            rest_lengths=rest_lengths,
            terms=physics.terms(),
            checkpoint=self._checkpoints(checkpoints),
            resume=self.resume,
        )

    def _checkpoints(self, folder: Path) -> Checkpoints | None:
        if self.checkpoint_every is None:
            return None
        from stitchmesh.yarnrelax.checkpoint import Checkpoints

        return Checkpoints(folder, self.checkpoint_every)


@dataclass(frozen=True)
class PinnedPlaces:
    """Yarn that does not move."""

    pin_point: Annotated[UseAppendAction[tuple[int, ...]], shown("POINT")] = ()
    """control point that stays where it is, counted from 0"""
    pin_face: Annotated[UseAppendAction[tuple[int, ...]], shown("FACE")] = ()
    """stitch face whose loops stay where they are, counted from 0"""

    def constraints(self) -> list[ConstraintChoice]:
        """The same for the library."""
        if not (self.pin_point or self.pin_face):
            return []
        from stitchmesh.yarnrelax.constraints.pins import Pins

        return [Pins(points=self.pin_point, faces=self.pin_face)]


@dataclass(frozen=True)
class SwatchFabric:
    """The fabric of a swatch."""

    yarn_radius: Annotated[float, shown("CM")] = SwatchOptions.yarn_radius
    """yarn radius [cm]"""
    loop_length: Annotated[float | None, shown("CM", f"{COMPACT_LOOP} diameters")] = SwatchOptions.loop_length
    """yarn of a plain stitch [cm]"""
    spacing: Annotated[tuple[float, ...] | None, shown("CM [CM]", f"{SPACING} diameters")] = None
    """distance of a weave's yarns [cm], or of its warps and of its wefts"""
    gamma: Annotated[float, shown("G")] = SwatchOptions.gamma
    """yarn is taken up by this factor, 0.1 to 10; the fabric becomes tighter by the same factor"""
    columns: Annotated[int, shown("N")] = SwatchOptions.columns
    """repeats of the pattern side by side"""
    rows: Annotated[int, shown("N")] = SwatchOptions.rows
    """repeats of the pattern above one another"""

    def options(self) -> dict[str, Any]:
        """Fields of ``SwatchOptions``.

        Raises:
            ParameterError: there are more than two spacings.
        """
        return {**asdict(self), "spacing": self._spacing()}

    def _spacing(self) -> float | tuple[float, float] | None:
        numbers = self.spacing
        if numbers is None or len(numbers) == 1:
            return None if numbers is None else numbers[0]
        if len(numbers) != 2:
            raise ParameterError(f"spacing: got {len(numbers)} numbers; expected one, or one of warps and one of wefts")
        return numbers[0], numbers[1]
