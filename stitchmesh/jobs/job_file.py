# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Jobs as files: TOML with the fields of ``Job`` as keys. Paths in a file are relative to its folder.

A job file may come from somebody else, and names files that the program opens. They have to be in the project: in the
folder of the job file, in the folder in which the program runs, in a folder that the command line names, or in any
folder inside these. A symbolic link counts as the file to which it leads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass, replace
from os import fspath
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_table, unknown_key
from stitchmesh.io.contents import FilePath
from stitchmesh.io.path_kind import whole_path
from stitchmesh.io.toml_file import SUFFIX, read_table, table_lines, toml_text
from stitchmesh.jobs.former_keys import with_present_keys
from stitchmesh.jobs.job import SOURCES, Job
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.periodic.charts.chart_files import CHART_SUFFIXES
from stitchmesh.recipe.recipe import Recipe
from stitchmesh.recipe.recipe_file import (
    name_with_path,
    pop_edits,
    read_recipe,
    recipe_with_paths,
)
from stitchmesh.recipe.sections import GarmentSettings
from stitchmesh.settings import SETTING, setting_comments, settings_of

HEADER = """\
# A job: `stitchmesh run FILE` runs it (docs/how-to/jobs.md). Paths are relative to this file, lengths in cm.
# A key behind # is not set; every other key has its default.
"""
OWN_KEYS = tuple(part.name for part in fields(Job) if part.name != "garment")
"""Keys of a job that are no keys of its garment."""
GARMENT_KEYS = tuple(part.name for part in fields(Recipe) if part.name not in OWN_KEYS)
"""Keys of the garment of a job with a mesh."""


def read_job(path: FilePath, *, allow_paths: Sequence[FilePath] = ()) -> Job:
    """Read a job from a TOML file.

    Args:
        path: the file.
        allow_paths: additional folders for the files that the job names, besides the folder of the file and the present
            folder (``check_job_paths``).

    Raises:
        FileError: the file cannot be read, is not TOML, or has a key or a value that no job has; the message names the
            key and, for an unknown key, the nearest known key. Or the job names a file in another folder.
    """
    job = job_of_table(read_table(path), fspath(path))
    check_job_paths(job, path, allow_paths)
    return job


def job_of_table(table: dict[str, Any], name: str) -> Job:
    """Return the job of a table; the places of its files are not checked (``check_job_paths``).

    Args:
        table: the table of a job file, in which paths are relative to the folder of the file.
        name: path of the file, for messages.

    Raises:
        FileError: the table has a key or a value that no job has.
    """
    try:
        present = with_present_keys(table)
        _check_keys(present)
        edits = pop_edits(present, "edits")
        job = _checked_job(present)
        if job.garment is not None:
            job = replace(job, garment=replace(job.garment, edits=edits))
        return job_with_paths(job, lambda path: fspath(Path(name).parent / path))
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


def _check_keys(table: dict[str, Any]) -> None:
    """Refuse unknown keys, and keys of a garment in a job that does not begin with a mesh."""
    for key in (key for key in table if key not in OWN_KEYS):
        if key not in GARMENT_KEYS:
            raise ParameterError(unknown_key("", key, [*GARMENT_KEYS, *OWN_KEYS]))
        if "mesh" not in table and ("recipe" in table or "swatch" in table):
            remedy = f"recipe; write it into {table['recipe']}" if "recipe" in table else "swatch; leave it out"
            raise ParameterError(f"{key}: is no key of a job with a {remedy}")


def _checked_job(table: dict[str, Any]) -> Job:
    """Return the job of a table without edits, in which the keys of the garment stand beside the keys of the job."""
    garment = {key: value for key, value in table.items() if key not in OWN_KEYS}
    own = {key: value for key, value in table.items() if key in OWN_KEYS}
    try:
        return check_table(own | {"garment": garment} if "mesh" in garment else own, Job)
    except ParameterError as error:
        raise ParameterError(str(error).removeprefix("garment.")) from error


def example_job(source: str) -> str:
    """Return the text of a new job file with all keys, their defaults and comments.

    Args:
        source: path of a mesh, of a recipe (``.toml``) or of a chart, or the name of a pattern of the library.
    """
    suffix = Path(source).suffix.lower()
    table: dict[str, Any]
    own = {key: value for key, value in _defaults(Job(recipe=source)).items() if key not in SOURCES}
    pictures = own.pop("render")
    comments = setting_comments(Job(recipe=source))
    if suffix in ("", *CHART_SUFFIXES):
        swatch = SwatchTable(pattern=source)
        del own["write_stitches"]
        table = own | {"swatch": _defaults(swatch), "render": pictures}
        comments |= {f"swatch.{path}": text for path, text in setting_comments(swatch).items()}
    else:
        garment: dict[str, Any] = {} if suffix == SUFFIX else _defaults(GarmentSettings())
        pictures = [{key: value for key, value in one.items() if key != "tiles"} for one in pictures]
        table = {"recipe" if suffix == SUFFIX else "mesh": source} | own | garment | {"render": pictures}
        comments |= setting_comments(GarmentSettings())
    lines = table_lines(table, comments=comments)
    return HEADER + "\n" + "\n".join(map(_with_unset, lines)) + "\n"


def _defaults(value: Any) -> Any:
    """Return a value as TOML can hold it: dataclasses become tables, and None becomes a mark."""
    if is_dataclass(value):
        return {part.name: _defaults(getattr(value, part.name)) for part in fields(value)}
    if isinstance(value, tuple):
        return [_defaults(part) for part in value]
    return _NOTHING if value is None else value


_NOTHING = "\0"
"""Mark that stands for None, which TOML does not have."""


EXAMPLES = {"view": "back", "colour": "strain"} | {
    path.rpartition(".")[2]: declared.example
    for one in (Job(recipe="-"), GarmentSettings(), SwatchTable(pattern="-"))
    for path, part, _found in settings_of(one)
    if (declared := part.metadata[SETTING]).example is not None
}
"""Example of each key that is not set by default."""


def _with_unset(line: str) -> str:
    """Return a line of a file; a key without a value becomes a comment with an example."""
    key, sign, value = line.partition(" = ")
    mark = '"\\u0000"'
    if not (sign and value.startswith(mark)):
        return line
    return f"# {key} = {toml_text(EXAMPLES[key])}{value.removeprefix(mark)}"


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
        pattern = name_with_path(swatch.pattern, change)
        material = None if swatch.material is None else name_with_path(swatch.material, change)
        if (pattern, material) != (swatch.pattern, swatch.material):
            changes |= {"swatch": replace(swatch, pattern=pattern, material=material)}
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
