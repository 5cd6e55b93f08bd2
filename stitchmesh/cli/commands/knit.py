# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``knit``."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, fields, replace
from os import fspath
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

from tyro.conf import Positional, UseAppendAction, arg

from stitchmesh.budget.budget import NO_TIME_FOR_PICTURE, START_OF_RENDERER
from stitchmesh.cli.budget_options import (
    BudgetOptions,
    chosen_setting,
    exit_status,
    time_after,
)
from stitchmesh.cli.options import (
    Centre,
    Device,
    Ground,
    KeptRun,
    Mirror,
    Overwrite,
    QualityName,
    Remainder,
    Shift,
    Threads,
    YarnColours,
)
from stitchmesh.cli.output_folder import (
    REMEDY,
    draw_if_possible,
    faults_drawn,
    output_folder,
    picture_seconds,
    plot_history,
)
from stitchmesh.cli.say import say
from stitchmesh.cli.setting_flags import flag_of
from stitchmesh.cli.summary import AsJson, files_to_open, finished_lines, knit_summary, print_result
from stitchmesh.cli.words import Flag, help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.io.examples import mesh_file
from stitchmesh.mesh.palette import colour_text, empty_palette
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, check_remainder
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import GarmentSettings, RecipePattern, SolverSection
from stitchmesh.settings import changed_settings

if TYPE_CHECKING:
    from stitchmesh.budget.budget import Budget
    from stitchmesh.pipeline.knit import Knitted
    from stitchmesh.progress import Progress
    from stitchmesh.recipe.recipe import Recipe

SHAPING_PICTURE = "shaping.png"
"""Name of the picture of found rows."""
OUTPUTS = (
    "stitches.h5", "yarns.h5", "yarns.bcc", "report.json", "convergence.csv", "convergence.png", "garment.toml",
)  # fmt: skip
"""Files that the command writes into its output folder."""
FINISHED = ("finished.obj", "finished.json")
"""The mesh at the finished measures, and these measures with the gauges of the swatches."""
PICTURES = ("preview.png", SHAPING_PICTURE)
"""Pictures of the garment and of its found rows there."""


@dataclass(frozen=True)
class KnitCommand:
    """Make relaxed yarns, a picture and a report from a polygon mesh or a recipe."""

    mesh: Annotated[Positional[str], help_entry("MESH|RECIPE")]
    """polygon mesh: OBJ, PLY, GLB, USD ...; a name of `stitchmesh examples`; or a recipe: TOML (docs/recipes.md)"""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for the stitches, the yarns, a picture, a report, the convergence and the recipe"""
    garment: Annotated[GarmentSettings, arg(name="")] = field(default_factory=GarmentSettings)
    pattern: Annotated[UseAppendAction[tuple[str, ...]], help_entry("NAME|FILE", "all knit")] = ()
    """pattern of the stitches: a name of `stitchmesh patterns`, or a file; may be repeated, each with its --on"""
    on: Annotated[UseAppendAction[tuple[str, ...]], flag_of(RecipePattern, "on")] = ()
    pattern_remainder: Remainder = DEFAULT_REMAINDER
    pattern_ground: Ground = None
    pattern_shift: Shift = (0, 0)
    pattern_mirror: Mirror = False
    pattern_centre: Centre = False
    finished: Annotated[str | None, help_entry("MEASURES", "the mesh as it is")] = None
    """measures of the finished garment when nothing holds it, such as chest=96,length=62 [cm] or chest=38in; swatches
    of its patterns give the numbers of stitches and rows, and the mesh is scaled to the measures"""
    stripes: Annotated[str | None, help_entry("BANDS", "no stripes")] = None
    """rows and colours of stripes from the first row up, which repeat: '4 cream, 2 navy'"""
    quality: Annotated[QualityName | None, help_entry("NAME", f"that of the recipe, or {DEFAULT_QUALITY}")] = None
    device: Device = None
    threads: Threads = None
    budget: BudgetOptions = field(default_factory=BudgetOptions)
    no_picture: Flag = False
    """do not write preview.png and shaping.png"""
    json: AsJson = False
    colours: YarnColours = field(default_factory=YarnColours)
    kept: KeptRun = field(default_factory=KeptRun)
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Run all stages, write their results, draw the pictures and print a summary.

        Returns:
            The exit status if the time ended the relaxation of the yarns, otherwise None.
        """
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.first_use import compile_before_relaxing
        from stitchmesh.io.atomic import write_json
        from stitchmesh.io.meshes import write_mesh
        from stitchmesh.recipe.finished import finished_garment, parse_measures
        from stitchmesh.recipe.knit_recipe import knit_recipe

        recipe = self._recipe_of_file() if self._is_recipe else self.recipe()
        after, draws = time_after(None if self.no_picture else START_OF_RENDERER, self.budget.within)
        seconds_after = picture_seconds if draws else None
        budget = self._budget(recipe, after)
        remedy = f"write auto = true under [rows] into {self.mesh}" if self._is_recipe else REMEDY
        asked = None if self.finished is None else parse_measures(self.finished)
        outputs = [*OUTPUTS, *([] if self.no_picture else PICTURES), *([] if asked is None else FINISHED)]
        with output_folder(self.output, outputs) as folder, show_progress() as progress, faults_drawn(folder, remedy):
            compile_before_relaxing(recipe.device, on_lattice=False, progress=progress)
            sized = None
            if asked is not None:
                sized = finished_garment(recipe, asked, quality=recipe.quality, progress=progress)
                recipe = replace(sized.recipe, mesh=fspath(folder / FINISHED[0]))
                write_mesh(recipe.mesh, sized.mesh)
                write_json(folder / FINISHED[1], sized.report())
            run = replace(self.kept.run(Path(self.output)), progress=progress)
            made = knit_recipe(recipe, folder, budget=budget, run=run, seconds_after=seconds_after)
            plot_history(made.history, folder, chosen_setting(made.report) or recipe.quality)
            drawn = False
            if draws:
                drawn = _draw(made, folder, progress)
            elif not self.no_picture:
                say(NO_TIME_FOR_PICTURE, file=sys.stderr)
        lines = knit_summary(made.fabric, made.yarns, made.report, recipe.named())
        if sized is not None:
            lines += finished_lines(sized)
        print_result(made.report, [*lines, files_to_open(folder, drawn)], as_json=self.json)
        return exit_status(made.report["yarnrelax"])

    @property
    def _is_recipe(self) -> bool:
        return self.mesh.lower().endswith(".toml")

    def _budget(self, recipe: Recipe, after: float) -> Budget | None:
        """Return the budget, which chooses the quality unless the options or the recipe ask for one.

        Raises:
            ParameterError: an amount is malformed or out of bounds, or an error is given beside a quality.
        """
        unset = self.quality is None and recipe.quality == DEFAULT_QUALITY and recipe.solver == SolverSection()
        return self.budget.budget(after, chooses=unset)

    def _recipe_of_file(self) -> Recipe:
        """Return the recipe of a file, with the quality and the device of the options.

        Raises:
            FileError: as for ``read_recipe``.
            ParameterError: another option is given that is part of a recipe.
        """
        from stitchmesh.recipe.recipe_file import read_recipe

        free = KnitCommand(
            self.mesh, self.output, quality=self.quality, device=self.device, threads=self.threads,
            budget=self.budget, no_picture=self.no_picture, json=self.json, kept=self.kept,
            finished=self.finished, overwrite=self.overwrite,
        )  # fmt: skip
        others = [part.name for part in fields(self) if getattr(self, part.name) != getattr(free, part.name)]
        for name in (*changed_settings(self.garment), *(name.replace("_", "-") for name in others)):
            raise ParameterError(f"{name}: is part of a recipe; write it into {self.mesh}")
        recipe = read_recipe(self.mesh)
        return replace(recipe, quality=self.quality or recipe.quality, device=self.device or recipe.device)

    def recipe(self) -> Recipe:
        """Return the recipe that the options describe."""
        from stitchmesh.editing.edit import Edit
        from stitchmesh.recipe.recipe import Recipe

        colours = self.colours.recoloured(empty_palette()) if self.colours.colour else ()
        return Recipe(
            **vars(self.garment) | {"palette": tuple(map(colour_text, colours))},
            mesh=fspath(mesh_file(self.mesh)),
            quality=self.quality or DEFAULT_QUALITY,
            device=self.device,
            patterns=self._patterns(),
            edits=() if self.stripes is None else (Edit("stripes", {"bands": self.stripes}),),
        )

    def _patterns(self) -> tuple[RecipePattern, ...]:
        if len(self.on) != len(self.pattern) and (self.on or len(self.pattern) > 1):
            counts = f"{len(self.pattern)} patterns and {len(self.on)} selections"
            raise ParameterError(f"pattern: got {counts}; give one --on SELECTION for each --pattern")
        places = self.on or (None,) * len(self.pattern)
        remainder = check_remainder(self.pattern_remainder)
        if not self.pattern and remainder != DEFAULT_REMAINDER:
            raise ParameterError(f"pattern remainder: got {remainder} without a pattern; add --pattern NAME")
        parts = zip(self.pattern, places, strict=True)
        return tuple(
            RecipePattern(pattern=name, on=on, remainder=remainder, ground=self.pattern_ground,
                          shift=self.pattern_shift, mirror=self.pattern_mirror, centre=self.pattern_centre)
            for name, on in parts
        )  # fmt: skip


def _draw(made: Knitted, folder: Path, progress: Progress) -> bool:
    """Draw the yarns and, if rows were found, their shaping; returns whether this machine can draw."""
    progress("picture", 0.0, "preview.png")
    from stitchmesh.render import render_yarns

    drawn = draw_if_possible(lambda: render_yarns(made.yarns, folder / "preview.png"))
    if drawn and "shape" in made.report:
        progress("picture", 0.5, SHAPING_PICTURE)
        from stitchmesh.render.shaping_picture import render_shaping

        path, figures = folder / SHAPING_PICTURE, cast(dict[str, Any], made.report["shape"])
        drawn = draw_if_possible(lambda: render_shaping(made.fabric, path, figures))
    return drawn
