# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A job as a value: its product, the options of its stages, and its output files.

A job holds names, numbers and paths only. It makes a garment from a mesh or from a recipe, or one repeat of a pattern.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from stitchmesh.budget.budget import Budget
from stitchmesh.errors import ParameterError
from stitchmesh.io.stitches import WRITABLE as STITCH_SUFFIXES
from stitchmesh.io.yarns import FORMATS
from stitchmesh.jobs.sections import RenderTable, SwatchTable
from stitchmesh.quality import quality_named
from stitchmesh.recipe.recipe import Recipe
from stitchmesh.settings import check_settings, setting

SOURCES = {"garment": "mesh", "recipe": "recipe", "swatch": "[swatch]"}
"""Fields that say what a job makes, each with its key in a job file; each job has exactly one of them."""
CHECKPOINT_EVERY, CHECKPOINT_OF_SWATCH = 200, 1000
"""Default number of iterations between two checkpoints of a garment, and of a swatch, whose iterations are faster."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A job that makes a garment from a mesh or a recipe, or a swatch from a pattern.

    Paths of input files are relative to the present folder; ``read_job`` makes them so. In a file, the keys of the
    garment stand beside the keys of the job.

    Raises:
        ParameterError: there is not exactly one source, a name or an amount is not accepted, or the name of an output
            does not name a file in the folder of the job.
    """

    garment: Recipe | None = None
    """A garment with its mesh."""
    recipe: str | None = None
    """Path of the recipe of a garment."""
    swatch: SwatchTable | None = None
    """One repeat of a pattern or weave, instead of a garment."""
    quality: str | None = setting(
        None, "draft, standard or reference", unset="that of the recipe, standard, or the choice of the budget",
        example="draft",
    )  # fmt: skip
    device: str | None = setting(None, "cpu or cuda:0; by default the first GPU", example="cpu")
    within: str | None = setting(None, "time for the whole job", example="8h")
    error: str | None = setting(
        None, "of the stitch spacing; measured tables choose the quality", example="1%"
    )
    checkpoint_every: int | None = setting(
        None, "iterations between two checkpoints", unset=f"{CHECKPOINT_EVERY}, or {CHECKPOINT_OF_SWATCH} of a swatch",
        example=100, least=1, expected="at least 1",
    )  # fmt: skip
    write_stitches: tuple[str, ...] = setting(
        ("stitches.h5",), "files of the stitch mesh, in the folder of the job"
    )
    write_yarns: tuple[str, ...] = setting(
        ("yarns.h5", "yarns.bcc"), "files of the relaxed yarns, in the folder of the job"
    )
    render: tuple[RenderTable, ...] = (RenderTable(),)
    """Pictures of the relaxed yarns."""

    def __post_init__(self) -> None:
        given = [key for name, key in SOURCES.items() if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            raise ParameterError(f"job: got {found}; expected one of mesh, recipe and [swatch]")
        if self.swatch is not None and self.write_stitches != Job.write_stitches:
            raise ParameterError("write_stitches: is no key of a job with a swatch; leave it out")
        check_settings(self)
        if self.quality is not None:
            quality_named(self.quality)
        _check_outputs("write_stitches", self.write_stitches, STITCH_SUFFIXES)
        _check_outputs("write_yarns", self.write_yarns, FORMATS)
        _check_outputs("render", [picture.path for picture in self.render], (".png",))
        for picture in self.render:
            picture.options()
        if self.budget is not None:
            self.budget.refuse_kept_quality(kept=self.quality is not None)

    @property
    def budget(self) -> Budget | None:
        """The limits on the time and on the error of the whole job; None without limits."""
        return Budget.of(self.within, self.error)

    @property
    def interval(self) -> int:
        """Number of iterations between two checkpoints."""
        usual = CHECKPOINT_EVERY if self.swatch is None else CHECKPOINT_OF_SWATCH
        return usual if self.checkpoint_every is None else self.checkpoint_every


def recipe_of(job: Job) -> Recipe:
    """Return the recipe of a job that makes a garment, with the quality and the device of the job.

    Raises:
        FileError: the recipe cannot be read (``read_recipe``).
    """
    from stitchmesh.recipe.recipe_file import read_recipe

    assert job.garment is not None or job.recipe is not None
    recipe = job.garment or read_recipe(str(job.recipe))
    return replace(recipe, quality=job.quality or recipe.quality, device=job.device or recipe.device)


def _check_outputs(key: str, names: Iterable[str], suffixes: Iterable[str]) -> None:
    """Check that each name names a file in the folder of the job, with a known suffix."""
    known = tuple(suffixes)
    for name in names:
        if Path(name).name != name or name.startswith(".") or Path(name).suffix.lower() not in known:
            suffix = f"with one of the suffixes {' '.join(known)}"
            raise ParameterError(f"{key}: got {name!r}; expected a file in the folder of the job, {suffix}")
