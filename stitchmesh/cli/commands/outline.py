# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``outline``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional

from stitchmesh import __version__
from stitchmesh.cli.options import Overwrite
from stitchmesh.cli.output_folder import draw_if_possible, output_folder
from stitchmesh.cli.summary import AsJson, print_result
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.meshrelax.options import ASPECT, STITCH_WIDTH

if TYPE_CHECKING:
    from stitchmesh.meshrelax.free.free_shape import FreeShape

STITCHES = ".h5"
"""Suffix of files of stitch meshes; every other name is that of a pattern."""


@dataclass(frozen=True)
class OutlineCommand:
    """Show the natural outline of a pattern within seconds, without yarns."""

    pattern: Annotated[Positional[str], help_entry("PATTERN")]
    """pattern: a name of `stitchmesh patterns`, or a file; or a stitch mesh (.h5)"""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for stitches.h5, outline.png and report.json"""
    form: Annotated[Literal["flat", "tube", "lattice"] | None, help_entry("FORM", "flat")] = None
    """flat piece with borders, tube in rounds, or a repeat without borders on a lattice"""
    columns: Annotated[int | None, help_entry("N", "40 stitches, one repeat on a lattice")] = None
    """repeats side by side"""
    rows: Annotated[int | None, help_entry("N", "40 rows, one repeat on a lattice")] = None
    """repeats one above another"""
    stitch_width: Annotated[float, help_entry("CM")] = STITCH_WIDTH
    """width of a stitch of plain knit"""
    aspect: Annotated[float, help_entry("RATIO")] = ASPECT
    """height of a stitch of plain knit divided by its width"""
    json: AsJson = False
    overwrite: Overwrite = False

    def run(self) -> None:
        """Relax the stitch mesh, and write it, its picture and its figures."""
        from stitchmesh.io import write_stitches
        from stitchmesh.io.atomic import write_json
        from stitchmesh.render.plots.outline_picture import plot_outline, summary

        shape = self._shape()
        name = Path(self.pattern).stem
        report = {"stitchmesh": __version__, "pattern": self.pattern, **shape.measures(), **_relaxation(shape)}
        with output_folder(self.output, ("stitches.h5", "report.json", "outline.png")) as folder:
            write_stitches(folder / "stitches.h5", shape.fabric)
            write_json(folder / "report.json", report)
            draw_if_possible(lambda: plot_outline(shape, folder / "outline.png", name))
        lines = [
            f"{name}: {shape.fabric.face_count:,} stitches, {summary(shape)}.",
            f"Relaxed in {shape.report.seconds:.1f} s; see {Path(self.output) / 'outline.png'}.",
        ]
        print_result(report, lines, as_json=self.json)

    def _shape(self) -> FreeShape:
        """Return the natural shape of the pattern or of the stitch mesh."""
        if Path(self.pattern).suffix.lower() != STITCHES:
            from stitchmesh.periodic.natural_outline import natural_outline

            return natural_outline(
                self.pattern, self.form or "flat", columns=self.columns, rows=self.rows,
                stitch_width=self.stitch_width, aspect=self.aspect,
            )  # fmt: skip
        from stitchmesh.io import read_stitches
        from stitchmesh.meshrelax.free.relax_freely import relax_mesh_freely

        self._refuse_options_of_patterns()
        return relax_mesh_freely(read_stitches(self.pattern), stitch_width=self.stitch_width, aspect=self.aspect)

    def _refuse_options_of_patterns(self) -> None:
        for name in ("form", "columns", "rows"):
            if getattr(self, name) is not None:
                raise ParameterError(f"--{name}: got one for the stitch mesh {self.pattern}; only a pattern has it")


def _relaxation(shape: FreeShape) -> dict[str, Any]:
    """Return the sizes of the mesh and the figures of its relaxation."""
    return {"faces": shape.fabric.face_count, "meshrelax": asdict(shape.report)}
