# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Jobs as files: TOML with the fields of ``Job`` as keys. Paths in a file are relative to its folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from os import fspath
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_table
from stitchmesh.io.contents import FilePath
from stitchmesh.io.toml_file import SUFFIX, read_table, table_lines
from stitchmesh.jobs.job import OF_GARMENTS, OF_MESHES, Job
from stitchmesh.jobs.job_paths import check_job_paths, job_with_paths
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.periodic.charts.chart_files import CHART_SUFFIXES
from stitchmesh.recipe.recipe_file import pop_edits

EDITS = "apply_edit"
HEADER = """\
# A job: `stitchmesh run FILE` runs it (docs/how-to/jobs.md). Paths are relative to this file, lengths in cm.
# A key behind # is not set; every other key has its default.
"""
UNSET = {
    "auto_stitches": "{ stitch_width = 0.8 }",
    "quality": '"draft"', "device": '"cpu"', "within": '"8h"', "error": '"1%"', "stitch_height": "0.6",
    "yarn_radius": "0.1", "drawn_radius": "0.17", "aspect": "0.77", "loop_length": "2.0", "gravity": "[0, -981, 0]",
    "friction": "0.2", "twist": "0.1", "body": '"body.obj"', "solver": '"dynamics"', "max_iterations": "20000",
    "view": '"back"', "colour": '"strain"', "spacing": "0.6", "blocked": "50.0", "relaxation": '"wet"',
    "mass_per_length": "0.004", "up": "[0, 0, 1]", "body_up": "[0, 0, 1]",
}  # fmt: skip
"""Example of each key that is not set by default."""
COMMENTS = {
    "unit": "of a mesh file that states none",
    "up": "direction in the mesh file that points up; found if it is not given",
    "objects": "names in the mesh file; by default all that can be garments",
    "layer": "outer, inner or middle one of a garment with a thickness",
    "turn_inside_out": "whether the other side of the mesh is outside",
    "quality": "draft, standard or reference",
    "device": "cpu or cuda:0; by default the first GPU",
    "within": "time for the whole job",
    "error": "of the stitch spacing; measured tables choose the quality",
    "auto_stitches": "rows are found on any mesh, in the place of label and tessellate",
    "make_spiral": "whether tubes are one spiral row",
    "write_stitches": "in the folder of the job",
    "borders": "[V, W]: an edge of a border from which rows start",
    "seeds": "[V, W]: a course edge from which rows start",
    "flip": "faces whose rows are reversed",
    "stitch_width": "wale spacing",
    "stitch_height": "course spacing",
    "increase": "m1, kfb, lifted or yo",
    "shaping": "seams or spread",
    "counts": "V,W=COUNT",
    "aspect": "height over width of a stitch",
    "alpha": "part of the surface that unstressed stitches cover",
    "bind_off": "chain or drawn",
    "cast_on": "backward or open",
    "longest_float": "in stitches",
    "factor": "of all rest lengths",
    "factors": "KEY=FACTOR, of stitches, rows and yarns",
    "stiffness": "NAME=VALUE",
    "gravity": "[cm/s^2]",
    "mass_per_length": "[g/cm]",
    "checkpoint_every": "iterations",
    "pattern": "name of the library or path of a chart",
    "gamma": "tightness",
    "period": "width and height, or free",
    "columns": "repeats side by side",
    "blocked": "tension [dyn/cm]",
    "relaxation": "dry, wet or full",
    "shaken": "more starts with noise, for the spread of the size",
    "tiles": "repeats of a swatch in the picture",
}
"""Comments beside keys of a new file, each at the first place of its key."""


def read_job(path: FilePath, *, allow_paths: Sequence[FilePath] = ()) -> Job:
    """Read a job from a TOML file.

    Args:
        path: the file.
        allow_paths: folders in which files may be that the job names, besides the folder of the file and the present
            one (``job_paths``).

    Raises:
        FileError: the file cannot be read, is not TOML, or has a key or a value that no job has; the message names the
            key and, for an unknown key, the nearest known one. Or the job names a file in another folder.
    """
    job = job_of_table(read_table(path), fspath(path))
    check_job_paths(job, path, allow_paths)
    return job


def job_of_table(table: dict[str, Any], name: str) -> Job:
    """Return the job of a table; where its files are is not checked (``check_job_paths``).

    Args:
        table: the table of a job file, in which paths are relative to the folder of the file.
        name: path of the file, for messages.

    Raises:
        FileError: the table has a key or a value that no job has.
    """
    try:
        edits, folder = pop_edits(table, EDITS), Path(name).parent
        job = check_table(table, Job)
        job = replace(job, apply_edit=edits) if edits else job
        return job_with_paths(job, lambda path: fspath(folder / path))
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


def example_job(source: str) -> str:
    """Return the text of a new job file with all keys, their defaults and comments.

    Args:
        source: path of a mesh, of a recipe (``.toml``) or of a chart, or the name of a pattern of the library.
    """
    suffix = Path(source).suffix.lower()
    kind = "recipe" if suffix == SUFFIX else "swatch" if suffix in ("", *CHART_SUFFIXES) else "mesh"
    others = {"mesh": {"recipe", "swatch"}, "recipe": {"mesh", "swatch", *OF_MESHES}}.get(
        kind, {"mesh", "recipe", *OF_MESHES, *OF_GARMENTS}
    )
    table: dict[str, Any] = {}
    for part in fields(Job):
        if part.name == kind:
            table[part.name] = _defaults(SwatchTable(pattern=source)) if kind == "swatch" else source
        elif part.name not in others and part.name != EDITS:
            default = part.default if part.default_factory is MISSING else part.default_factory()
            table[part.name] = _defaults(default)
    if kind == "recipe":
        table["relax_yarns"] = {"checkpoint_every": table["relax_yarns"]["checkpoint_every"]}
    if kind != "swatch":
        table["render"] = [{key: value for key, value in one.items() if key != "tiles"} for one in table["render"]]
    return HEADER + "\n" + "\n".join(_with_unset(line) for line in table_lines(table, comments=COMMENTS)) + "\n"


def _defaults(value: Any) -> Any:
    """Return a value as TOML can hold it: dataclasses become tables, and None becomes a mark."""
    if is_dataclass(value):
        return {part.name: _defaults(getattr(value, part.name)) for part in fields(value)}
    if isinstance(value, tuple):
        return [_defaults(part) for part in value]
    return _NOTHING if value is None else value


_NOTHING = "\0"
"""Mark in the place of None, which TOML does not have."""


def _with_unset(line: str) -> str:
    """Return a line of a file; a key without a value becomes a comment with an example."""
    key, sign, value = line.partition(" = ")
    mark = '"\\u0000"'
    return f"# {key} = {UNSET.get(key, '...')}{value.removeprefix(mark)}" if sign and value.startswith(mark) else line
