# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options of several commands that are not settings of a recipe, and groups of single settings for commands.

Each group is a frozen dataclass. The docstring of a field is the help text of the option.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import UseAppendAction

from stitchmesh.app.guard import LOOPBACK, PORT
from stitchmesh.cli.setting_flags import flag_of
from stitchmesh.cli.words import DirectionWord, Flag, help_entry
from stitchmesh.compute.threads import VARIABLE
from stitchmesh.errors import ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh.palette import Palette, parse_yarn_colours, recolour_palette
from stitchmesh.periodic.swatch_options import RepeatSettings, SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.recipe.sections import GarmentSettings, RecipePattern, SolverSection, StitchesSection, YarnAndGauge
from stitchmesh.settings import setting

if TYPE_CHECKING:
    from stitchmesh.app.project.project import Project
    from stitchmesh.faces.face_mesh import FaceMesh
    from stitchmesh.mesh import Mesh
    from stitchmesh.run import Run
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarnrelax.energies.term import ConstraintChoice

READ_STITCHES = "stitch mesh: .h5, .smobj or .st"
WRITTEN_STITCHES = "stitch mesh: .h5, .smobj, or .k for a knitting machine"
READ_YARNS = "yarns: .h5, .pyp, .bcc, .yarns, .usda, .usdc, .vtp or .obj"
WRITTEN_YARNS = "yarns: .h5, .pyp, .bcc, .yarns, .usda, .usdc, .vtp, .glb or .obj"
FOUND_RADIUS = "from the file, or estimated from the distances between yarns"

QualityName = Annotated[str, help_entry("NAME", help=f"preset of accuracy and cost: {', '.join(PRESETS)}")]
Device = Annotated[
    str | None, help_entry("NAME", "the first GPU, or the CPU without a GPU", help="processor: cpu or cuda:0")
]
Threads = Annotated[int | None, help_entry("N", f"that of {VARIABLE}, or all cores", help="number of threads on a CPU")]
Overwrite = Annotated[
    Flag, help_entry("", help="replace files that StitchMesh did not write or that were changed since, but no input")
]
Unit = Annotated[str, flag_of(GarmentSettings, "unit")]
StitchWidth = Annotated[float | None, flag_of(GarmentSettings, "stitch_width")]
CourseHeight = Annotated[float | None, flag_of(StitchesSection, "course_height")]
YarnRadius = Annotated[float | None, flag_of(GarmentSettings, "yarn_radius")]
DrawnRadius = Annotated[float | None, flag_of(GarmentSettings, "drawn_radius")]
YarnName = Annotated[str | None, flag_of(GarmentSettings, "yarn")]
MaxIterations = Annotated[int | None, flag_of(SolverSection, "max_iterations")]
OnSelection = Annotated[
    str | None, help_entry("SELECTION", "none", help="part of the fabric, such as 'hem 6' (docs/selections.md)")
]
Remainder = Annotated[str, flag_of(RecipePattern, "remainder")]
Ground = Annotated[str | None, flag_of(RecipePattern, "ground")]
Shift = Annotated[tuple[int, int], flag_of(RecipePattern, "shift")]
Mirror = Annotated[Flag, flag_of(RecipePattern, "mirror")]
Centre = Annotated[Flag, flag_of(RecipePattern, "centre")]
ReportFolder = Annotated[
    str | None, help_entry("DIR", "no report", help="folder for report.json, convergence.csv and convergence.png")
]


@dataclass(frozen=True)
class FileReading:
    """Properties that a file may not state."""

    unit: Unit = DEFAULT_UNIT
    yarn_radius: Annotated[float | None, help_entry("CM", FOUND_RADIUS)] = None
    """radius of the yarns [cm]"""
    up: Annotated[DirectionWord, help_entry("AXIS|X,Y,Z", "y")] = None
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
class KeptRun:
    """Checkpoints of the relaxation of yarns."""

    checkpoint_every: Annotated[int | None, help_entry("N", "no checkpoints")] = None
    """write a checkpoint every N iterations, to the output folder or to OUTPUT.checkpoints beside the output file"""
    resume: Annotated[str | None, help_entry("PATH", "a new relaxation")] = None
    """checkpoint (.smc) from which the relaxation continues; give the same other options as before"""

    def run(self, folder: Path) -> Run[YarnSet]:
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


@dataclass(frozen=True, kw_only=True)
class SwatchFabric(RepeatSettings):
    """The fabric of a swatch."""

    yarn: YarnAndGauge = field(default_factory=YarnAndGauge)
    yarn_radius: float | None = setting(
        None, "yarn radius", unit="cm", unset=f"that of the yarn, or {SwatchOptions.yarn_radius}"
    )

    def options(self, *, woven: bool, drawn_radius: float | None = None) -> dict[str, Any]:
        """Return the fields of ``SwatchOptions`` by name.

        Args:
            woven: whether the swatch is a weave, for which a yarn sets no loop length.
            drawn_radius: radius of the yarn in pictures [cm]; where not given that of the yarn.

        Raises:
            ParameterError: the yarn is unknown, or the gauge is malformed or has rows, which follow from the loop
                length.
        """
        gauge = self.yarn.gauge
        if gauge is not None and "x" in gauge.lower():
            found = f"gauge: got {gauge!r}, which only the command swatch brings true"
            raise ParameterError(f"{found}; give the stitches alone, or the loop length")
        size = self.yarn.measures(yarn_radius=self.yarn_radius, drawn_radius=drawn_radius, loop_length=self.loop_length)
        only_yarn = self.loop_length is None and self.yarn.gauge is None
        return {
            "yarn_radius": SwatchOptions.yarn_radius if size.yarn_radius is None else size.yarn_radius,
            "drawn_radius": drawn_radius if woven else size.drawn_radius,
            "mass_per_length": size.mass_per_length,
            "loop_length": None if woven and only_yarn else size.loop_length,
            "spacing": self.spacing,
            "gamma": self.gamma,
            "columns": self.columns,
            "rows": self.rows,
            "longest_float": self.longest_float,
        }


@dataclass(frozen=True)
class Serving:
    """Where the application listens."""

    port: Annotated[int, help_entry("N")] = PORT
    """port of the address; the next free one is taken if it is in use, and any free one for 0"""
    host: Annotated[str, help_entry("ADDRESS")] = LOOPBACK
    """address of this machine on which to listen; other machines reach an address such as 0.0.0.0"""
    token: Annotated[str | None, help_entry("TEXT", "a new one")] = None
    """token that a browser needs; other users can see it here, and not in the variable STITCHMESH_TOKEN"""
    no_token: Flag = False
    """ask for no token; every user of this machine can then read and write files as you"""
    no_browser: Flag = False
    """print the address only, and open no browser"""

    def run(self, open_project: Callable[[], Project], page: str | None = None) -> None:
        """Run the application on a project until it is interrupted."""
        from stitchmesh.app.run import RunOptions, run_app

        token = self.token
        if token is None and not self.no_token:
            token = os.environ.get("STITCHMESH_TOKEN") or None
        options = RunOptions(
            host=self.host, port=self.port, token=token, needs_token=not self.no_token, browser=not self.no_browser
        )
        run_app(open_project, options, page=page)
