# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The files that a job names, and where they may be.

A job file may come from somebody else, and names files that the program opens. They have to be in the project: in the
folder of the job file, in the folder in which the program runs, or in one that the command line names; each with all
folders inside it. Symbolic links count as what they lead to.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from os import fspath
from pathlib import Path

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.jobs.job import Job
from stitchmesh.recipe.recipe_file import (
    edits_with_paths,
    pattern_with_path,
    patterns_with_paths,
    read_recipe,
    recipe_with_paths,
)


def check_job_paths(job: Job, file: FilePath, allowed: Sequence[FilePath] = ()) -> None:
    """Check that all files that a job reads are in the project, those too that its recipe names.

    Args:
        job: the job, whose paths are relative to the present folder.
        file: the file that names them: a job file, or one from which many jobs are made.
        allowed: further folders in which files may be, from the command line.

    Raises:
        FileError: a file is outside the project, or the recipe cannot be read.
    """
    folders = [Path(file).parent, Path(), *allowed]
    job_with_paths(job, _checked(file, folders))
    if job.recipe is not None:
        recipe_with_paths(read_recipe(job.recipe), _checked(job.recipe, folders))


def job_with_paths(job: Job, change: Callable[[str], str]) -> Job:
    """Return a job with all paths of what it reads changed, those in selections too."""
    body, swatch = job.relax_yarns.body, job.swatch
    return replace(
        job,
        mesh=None if job.mesh is None else change(job.mesh),
        recipe=None if job.recipe is None else change(job.recipe),
        apply_pattern=patterns_with_paths(job.apply_pattern, change),
        apply_edit=edits_with_paths(job.apply_edit, change),
        relax_yarns=replace(job.relax_yarns, body=None if body is None else change(body)),
        swatch=None if swatch is None else replace(swatch, pattern=pattern_with_path(swatch.pattern, change)),
    )


def _checked(file: FilePath, folders: Sequence[FilePath]) -> Callable[[str], str]:
    """Return a function that returns a path that a file names, if it leads into one of the folders."""
    roots = [Path(folder).resolve() for folder in folders]

    def check(path: str) -> str:
        found = Path(path).resolve()
        if not any(found.is_relative_to(root) for root in roots):
            raise FileError(
                f"{fspath(file)}: names {found}, which is outside the project; expected a file in {roots[0]} or in the "
                f"present folder; if it may be read, add --allow-paths {found.parent}"
            )
        return path

    return check
