# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The making of a garment from its recipe."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from stitchmesh.budget.budget import Budget
from stitchmesh.io.checkpoint_file import read_checkpoint
from stitchmesh.pipeline.knit import Knitted, knit_and_write
from stitchmesh.quality import quality_named
from stitchmesh.recipe.recipe import Recipe, pattern_regions, recipe_options
from stitchmesh.recipe.recipe_file import write_recipe
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn import YarnSet

RECIPE_FILE = "garment.toml"
"""Name of the recipe that is written beside the results."""


def knit_recipe(
    recipe: Recipe, folder: str | PathLike[str], *, budget: Budget | None = None, run: Run[YarnSet] = SHOWN,
    seconds_after: Callable[[YarnSet], float] | None = None,
) -> Knitted:  # fmt: skip
    """Make the garment of a recipe, and write it.

    The function writes the files of ``knit_and_write``, and the recipe as ``garment.toml``. This recipe gives the same
    bits again on the same processor.

    Args:
        recipe: the recipe.
        folder: output folder.
        budget: limits on the time and on the error, as for ``knit_and_write``. The written recipe then has the chosen
            quality, and the number of iterations if the time ended the relaxation.
        run: as for ``knit_and_write``.
        seconds_after: estimated time of the caller's own work afterwards, as for ``knit_and_write``.

    Raises:
        StitchMeshError: the recipe cannot be carried out; nothing is written if the error is in the recipe.
    """
    if run.resume is not None:
        read_checkpoint(run.resume)  # A checkpoint that cannot be read is refused before the garment is made.
    pattern_regions(recipe)  # A pattern that cannot be read is refused before the mesh is read.
    found = recipe.read_mesh()
    made = knit_and_write(
        found.mesh, folder, recipe_options(recipe, found.up), budget=budget, repair=found.repairs, run=run,
        seconds_after=seconds_after,
    )  # fmt: skip
    write_recipe(Path(folder) / RECIPE_FILE, recipe if budget is None else _as_made(recipe, made.report))
    return made


def _as_made(recipe: Recipe, report: Mapping[str, Any]) -> Recipe:
    """Return the recipe with the quality that a budget chose, and with the iterations at which the time ended."""
    relaxed, quality = report["yarnrelax"], report["budget"]["quality"] or recipe.quality
    most = relaxed["iterations"] if relaxed["out_of_time"] else recipe.solver.max_iterations
    method = relaxed["solver"] if relaxed["solver"] != quality_named(quality).solver else recipe.solver.method
    return replace(recipe, quality=quality, solver=replace(recipe.solver, method=method, max_iterations=most))
