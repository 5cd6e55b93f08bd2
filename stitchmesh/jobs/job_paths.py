# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The files that a job names, and where they may be.

A job file may come from somebody else, and names files that the program opens. They have to be in the project: in the
folder of the job file, in the folder in which the program runs, in a folder that the command line names, or in any
folder inside these. A symbolic link counts as the file to which it leads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from os import fspath
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.path_kind import whole_path
from stitchmesh.jobs.job import Job
from stitchmesh.recipe.recipe_file import (
    pattern_with_path,
    read_recipe,
    recipe_with_paths,
)


def check_job_paths(job: Job, file: FilePath, allowed: Sequence[FilePath] = ()) -> list[str]:
    """Return the paths of all files that a job reads, including the files of its recipe, if all are in the project.

    Args:
        job: the job, whose paths are relative to the present folder.
        file: the file that names them: a job file, or a file from which many jobs are made.
        allowed: further folders in which files may be, from the command line.

    Raises:
        FileError: a file is outside the project, or the recipe cannot be read.
    """
    folders, found = [Path(file).parent, Path(), *allowed], list[str]()
    job_with_paths(job, _checked(file, folders, found))
    if job.recipe is not None:
        recipe_with_paths(read_recipe(job.recipe), _checked(job.recipe, folders, found))
    return found


def job_with_paths(job: Job, change: Callable[[str], str]) -> Job:
    """Return a job with all paths of its input files changed, including the paths in selections."""
    swatch, changes = job.swatch, dict[str, Any]()
    if swatch is not None:  # A sweep has many jobs, and most of them are swatches of the library, without paths.
        pattern = pattern_with_path(swatch.pattern, change)
        changes |= {} if pattern == swatch.pattern else {"swatch": replace(swatch, pattern=pattern)}
    if job.garment is not None:
        changes |= {"garment": recipe_with_paths(job.garment, change)}
    if job.recipe is not None:
        changes |= {"recipe": change(job.recipe)}
    return replace(job, **changes) if changes else job


def _checked(file: FilePath, folders: Sequence[FilePath], seen: list[str]) -> Callable[[str], str]:
    """Return a function that checks that a path leads into one of the folders, notes the path, and returns it."""

    def check(path: str) -> str:
        found, roots = whole_path(path), [whole_path(folder) for folder in folders]
        if not any(found.is_relative_to(root) for root in roots):
            raise FileError(
                f"{fspath(file)}: names {found}, which is outside the project; expected a file in {roots[0]} or in the "
                f"present folder; if it may be read, add --allow-paths {found.parent}"
            )
        seen.append(path)
        return path

    return check
