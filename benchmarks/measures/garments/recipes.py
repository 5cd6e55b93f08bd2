# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cost of a garment from a recipe, beside the cost of its stages called one by one."""

from __future__ import annotations

import platform
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TypeVar

from tyro.conf import Positional

from benchmarks.table import Rows
from stitchmesh.editing.edit import apply_edit
from stitchmesh.editing.pattern_regions import lay_patterns
from stitchmesh.io.history import write_history
from stitchmesh.io.state_saver import save_yarns
from stitchmesh.io.stitches import write_stitches
from stitchmesh.labeling import label
from stitchmesh.mesh.change import PaletteChange, apply_change
from stitchmesh.mesh.palette import make_palette
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.recipe.knit_recipe import knit_recipe
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.recipe_file import read_recipe, write_recipe
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns

T = TypeVar("T")


def timed(seconds: dict[str, float], name: str, work: Callable[[], T]) -> T:
    """Do some work, and add its time [s]."""
    start = time.perf_counter()
    result = work()
    seconds[name] = seconds.get(name, 0.0) + time.perf_counter() - start
    return result


def stages(recipe: Recipe, folder: Path) -> dict[str, float]:
    """Call the stages one by one, and return the time of each [s]."""
    seconds: dict[str, float] = {}
    options = timed(seconds, "options", lambda: recipe_options(recipe))
    mesh = timed(seconds, "read", lambda: recipe.read_mesh().mesh)
    labeled = timed(seconds, "label", lambda: label(mesh, seeds=options.seeds, flip=options.flip))
    fabric = timed(seconds, "tessellate", lambda: tessellate(
        labeled, stitch_width=options.stitch_width, stitch_height=options.stitch_height))  # fmt: skip
    if options.palette:
        fabric = apply_change(fabric, PaletteChange(make_palette(options.palette)))
    if options.patterns:
        fabric = timed(seconds, "patterns", lambda: lay_patterns(fabric, options.patterns)[-1].fabric)
    for edit in options.edits:
        fabric = timed(seconds, "edits", lambda edit=edit, before=fabric: apply_edit(before, edit).fabric)
    fabric = timed(seconds, "mesh relaxation", lambda: relax_mesh(
        fabric, surface=mesh, device=options.device, options=options.mesh_relax_options).fabric)  # fmt: skip
    yarns = timed(seconds, "yarns", lambda: generate_yarns(
        fabric, yarn_radius=options.yarn_radius, drawn_radius=options.drawn_radius, quality=options.quality,
        **asdict(options.finish)))  # fmt: skip
    relaxed = timed(seconds, "relaxation", lambda: relax_with_options(
        yarns, options.relaxation, quality=options.quality, device=options.device, fabric=fabric,
        keep_shape=True))  # fmt: skip
    timed(seconds, "files", lambda: write_stitches(folder / "stitches.h5", fabric))
    timed(seconds, "files", lambda: save_yarns(folder, relaxed.yarns, dict(relaxed.report)))
    timed(seconds, "files", lambda: write_history(folder / "convergence.csv", relaxed.history))
    timed(seconds, "files", lambda: write_recipe(folder / "garment.toml", recipe))
    return seconds


@dataclass(frozen=True)
class Options:
    """What is measured."""

    recipe: Positional[tuple[str, ...]]
    device: str = "cpu"
    max_iterations: int = 100


def recipes(arguments: Options) -> Rows:
    """Measure the recipes named on the command line."""
    yield f"Python {platform.python_version()}, {platform.machine()}; {arguments.max_iterations} iterations"
    for path in arguments.recipe:
        recipe = read_recipe(path)
        solver = replace(recipe.solver, max_iterations=arguments.max_iterations)
        recipe = replace(recipe, device=arguments.device, solver=solver)
        with tempfile.TemporaryDirectory() as folder:
            stages(recipe, Path(folder))  # The first run loads the kernels.
            parts = stages(recipe, Path(folder))
            whole: dict[str, float] = {}
            timed(whole, "recipe", lambda recipe=recipe, folder=folder: knit_recipe(recipe, folder))
        yield f"{path}: recipe {whole['recipe']:.2f} s, its parts {sum(parts.values()):.2f} s"
        yield "  " + ", ".join(f"{name} {seconds:.3f}" for name, seconds in parts.items())
