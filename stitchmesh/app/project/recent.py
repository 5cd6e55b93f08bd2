# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The places of projects, and the list of those that were open last."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from stitchmesh.app.preferences import state_folder
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.project_folder import TABLE_NAME
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.io.path_kind import is_file, is_there
from stitchmesh.mesh import BORDER, Mesh

MOST_LINES = 400
"""Largest number of lines in the outline of a garment."""
OUTLINE = re.compile(r"(M-?\d{1,3} -?\d{1,3}L-?\d{1,3} -?\d{1,3})*")
LONGEST_NAME = 60
"""Largest number of characters in the name of a new project."""


@dataclass(frozen=True)
class RecentProject:
    """A project that was open."""

    folder: Path
    """Folder of the project."""
    name: str
    """Name of the project when it was open."""
    outline: str = ""
    """Its garment from the front, as an SVG path in a square of 100 units; empty without a garment."""

    @property
    def changed(self) -> datetime:
        """When the project was changed last.

        Raises:
            OSError: the project is gone.
        """
        return datetime.fromtimestamp((self.folder / TABLE_NAME).stat().st_mtime)


def projects_folder() -> Path:
    """Return the folder of new projects: the variable ``STITCHMESH_PROJECTS`` names it, else StitchMesh in the home."""
    return Path(os.environ.get("STITCHMESH_PROJECTS") or Path.home() / "StitchMesh")


def new_project_folder(name: str) -> Path:
    """Return a folder for a new project that does not exist yet; its name gets a number if another exists.

    Args:
        name: name of the project; characters that do not suit a folder become hyphens.

    Raises:
        ParameterError: the name has no letter and no digit, or is too long.
    """
    plain = re.sub(r"[^\w.-]+", "-", name).strip("-.")
    if not plain or len(name) > LONGEST_NAME:
        raise ParameterError(f"name: got {name[:LONGEST_NAME]!r}; expected letters or digits, at most {LONGEST_NAME}")
    folder, number = projects_folder() / plain, 2
    while is_there(folder):
        folder, number = projects_folder() / f"{plain}-{number}", number + 1
    return folder


def recent_projects() -> list[RecentProject]:
    """Return the projects that were open, the last one first; projects without a folder are left out."""
    try:
        entries = check_value(read_json(_list_path()), list[dict[str, str]])
        found = [RecentProject(Path(entry["folder"]), entry["name"], _checked(entry.get("outline", "")))
                 for entry in entries]  # fmt: skip
        return [project for project in found if is_file(project.folder / TABLE_NAME)]
    except (StitchMeshError, KeyError):
        return []  # The list is a convenience: a damaged list begins anew.


def remember(project: Project) -> None:
    """Put a project first in the list; if the list cannot be written, it stays as it is."""
    others = [one for one in recent_projects() if one.folder != project.folder]
    mesh = project.evened or project.fabric or project.mesh
    entries = [RecentProject(project.folder, project.name, "" if mesh is None else outline_of(mesh)), *others]
    table = [{"folder": str(one.folder), "name": one.name, "outline": one.outline} for one in entries[:12]]
    text = json.dumps(table, indent=1)
    try:
        write_text(_list_path(), text + "\n")
    except StitchMeshError:
        return


def outline_of(mesh: Mesh) -> str:
    """Return the borders and the outline of a garment from the front as an SVG path, in a square of 100 units.

    An edge belongs to the outline if one of its faces looks to the front and the other to the back.
    """
    towards = mesh.face_vector_area[:, 2] > 0.0
    side = mesh.edge_side
    other = mesh.twin[side]
    shown = side[(other == BORDER) | (towards[mesh.side_face[side]] != towards[mesh.side_face[other]])]
    shown = shown[:: len(shown) // MOST_LINES + 1]
    low, size = mesh.vertices.min(axis=0), float(np.ptp(mesh.vertices[:, :2], axis=0).max()) or 1.0
    place = np.rint(100.0 * (mesh.vertices[:, :2] - low[:2]) / size).astype(int)
    ends = place[mesh.face_vertex[np.stack([shown, mesh.side_next[shown]], axis=1)]]
    return "".join(f"M{x} {100 - y}L{u} {100 - v}" for (x, y), (u, v) in ends.tolist())


def _checked(outline: str) -> str:
    """Return a path from a file; an empty text if ``outline_of`` cannot have made it."""
    return outline if OUTLINE.fullmatch(outline) else ""


def _list_path() -> Path:
    return state_folder() / "projects.json"
