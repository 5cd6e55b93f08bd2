# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small projects for tests."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np

from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.editing.edit import Edit
from stitchmesh.io.meshes import write_mesh
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.yarn import YarnSet
from tests.gallery import tube

YARNS = YarnSet.from_curves([np.eye(3), np.eye(3) + 0.1], closed=[True, True], radius=0.05)
"""Two yarns, in the place of generated or of relaxed ones."""
REPORT = {"converged": True, "iterations": 7, "energies": {"bend": 0.5}}
HISTORY = [{"iteration": 0, "seconds": 0.5, "residual": 1.0, "energies": {"bend": 0.25}}]
LABEL_ALL = LabelStep("label_all")
COARSE = Division(stitch_width=1.0)
PURL = Edit("change_stitch", {"faces": [30, 31], "stitch": "p"})


def mesh_bytes(folder: Path, around: int = 12, rows: int = 4) -> bytes:
    """The bytes of an OBJ file of a tube."""
    path = folder / "written.obj"
    write_mesh(path, tube(around, rows))
    content = path.read_bytes()
    path.unlink()
    return content


def divided_project(folder: Path) -> Project:
    """A project of a tube that is labeled and divided."""
    project = Project.create(folder)
    project.import_mesh("tube.obj", mesh_bytes(folder))
    project.apply_label_step(LABEL_ALL)
    project.divide(COARSE)
    return project


def relaxed_project(folder: Path) -> Project:
    """A project with an edit and the results of all stages."""
    project = divided_project(folder)
    project.apply_edit(PURL)
    project.set_evened(project.fabric)
    project.set_yarns(YARNS, {"quality": "draft"})
    project.set_relaxed(YARNS, REPORT, HISTORY)
    return project


def same(first: object, second: object) -> bool:
    """Whether two values, of which frozen data are compared field by field, are equal to the last bit."""
    if hasattr(first, "__dataclass_fields__"):
        return type(first) is type(second) and all(
            same(getattr(first, part.name), getattr(second, part.name)) for part in fields(first)
        )
    if isinstance(first, np.ndarray):
        alike = isinstance(second, np.ndarray) and first.dtype == second.dtype
        return alike and np.array_equal(first, second, equal_nan=first.dtype.kind == "f")  # A mass may not be stated.
    if isinstance(first, list | tuple):
        return type(first) is type(second) and len(first) == len(second) and all(map(same, first, second))
    return first == second


def same_project(first: Project, second: Project) -> bool:
    """Whether two projects hold equal values."""
    names = ["name", "labeling", "label_steps", "labeled", "division", "fabric", "edits", "evened", "yarns",
             "yarn_settings", "relaxed", "report", "history", "edit_history", "can_restore"]  # fmt: skip
    return all(same(getattr(first, name), getattr(second, name)) for name in names)
