# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The things that the page shows: a mesh, stitches, yarns or a run with their companions, a picture, or a text."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from stitchmesh.app.project.project import Project
from stitchmesh.errors import FileError
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.io.any_file import read_any
from stitchmesh.io.contents import read_bytes, read_lines
from stitchmesh.io.hdf5 import stored_format
from stitchmesh.io.history import HistoryEntry, read_history
from stitchmesh.io.path_kind import is_file
from stitchmesh.io.stitches import read_stitches
from stitchmesh.io.yarns import read_yarns
from stitchmesh.jobs.job_status import JobStatus
from stitchmesh.labeling.labeling_file import FORMAT as LABELING
from stitchmesh.labeling.labeling_file import read_labeling
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mixed.drape import Draped
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.face_yarns.generate import face_yarns
from stitchmesh.yarnrelax.checkpoint_yarns import checkpoint_yarns

MOST_CHARACTERS = 20_000
"""Number of characters of a text that are shown; the rest is left out."""
TEXTS = (".json", ".toml", ".txt", ".md", ".k")
"""Suffixes of files whose text is shown."""
SUFFIXES = (
    ".h5", ".bcc", ".yarns", ".usda", ".usdc", ".usd", ".vtp", ".obj", ".pyp", ".smobj", ".st", ".ply", ".off",
    ".stl", ".glb", ".gltf", ".vtk", ".vtu", ".msh", ".mesh", ".csv", ".png", *TEXTS,
)  # fmt: skip
"""Suffixes of files that can be uploaded."""


Thing: TypeAlias = Mesh | YarnSet | Draped
"""The things that can stand in the scene; a run is a run of mixed yarns and triangles."""


@dataclass(frozen=True, eq=False)
class Viewed:
    """Something to look at, with the facts about it."""

    name: str
    """Name of the thing, in the words of the user."""
    thing: Thing | None = None
    """The mesh, the stitches, the yarns or the run; None for a picture, a plot or a text alone."""
    fabric: StitchMesh | None = None
    """The stitches from which the yarns were made, for colours by stitch."""
    history: Sequence[HistoryEntry] = ()
    """Assessments of the relaxation."""
    picture: bytes = b""
    """A PNG file."""
    text: str = ""
    """Text of a file, or a line about a running job."""
    job: JobStatus | None = None
    """Progress of the job that makes it; None for anything else."""


def project_results(project: Project) -> dict[str, Viewed]:
    """Return the results of a project, the newest first, by their names in the list of the page."""
    stitches = project.evened if project.evened is not None else project.fabric
    history = project.history or ()
    found = {
        "Relaxed yarns": Viewed("Relaxed yarns", project.relaxed, stitches, history),
        "Generated yarns": Viewed("Generated yarns", project.yarns, stitches),
        "Evened stitches": Viewed("Evened stitches", project.evened),
        "Stitches": Viewed("Stitches", project.fabric),
        "Labeled mesh": Viewed("Labeled mesh", project.labeled),
        "Mesh": Viewed("Mesh", project.mesh),
    }
    return {name: viewed for name, viewed in found.items() if viewed.thing is not None}


def read_viewed(path: Path) -> Viewed:
    """Read a file; yarns get the stitches of ``stitches.h5`` in the same folder if these fit.

    Raises:
        StitchMeshError: the file cannot be read.
    """
    reader = READERS.get(path.suffix.lower(), _read_thing)
    return replace(reader(path), name=path.name)


def _read_thing(path: Path) -> Viewed:
    if path.suffix.lower() == ".h5" and is_file(path) and stored_format(path) == LABELING:
        return Viewed("", read_labeling(path).mesh)
    thing = read_any(path)
    if isinstance(thing, FaceMesh):
        return Viewed("", face_yarns(thing).yarns)
    return Viewed("", thing, stitches_beside(path, thing) if isinstance(thing, YarnSet) else None)


def stitches_beside(path: Path, yarns: YarnSet) -> StitchMesh | None:
    """Return the stitches in the folder of a file of yarns if the yarns can come from them."""
    beside = path.with_name("stitches.h5")
    if not is_file(beside) or yarns.face.max(initial=-1) < 0:
        return None
    try:
        fabric = read_stitches(beside)
    except FileError:
        return None
    return fabric if yarns.face.max() < fabric.face_count else None


def read_checkpoint_file(path: Path) -> Viewed:
    """Read a checkpoint; its yarns are in the same folder, or beside the folder of checkpoints."""
    stem = path.parent.name.removesuffix(".checkpoints")
    places = [path.with_name("yarns.h5"), path.parent.with_name(f"{stem}.h5")]
    beside = next((place for place in places if is_file(place)), None)
    if beside is None:
        raise FileError(f"{path}: a checkpoint holds positions only; put yarns.h5 of the same job beside it")
    yarns = checkpoint_yarns(path, read_yarns(beside))
    return Viewed("", yarns, stitches_beside(beside, yarns))


def _read_table(path: Path) -> Viewed:
    """Read the convergence of a relaxation, or read any other table as a text."""
    try:
        return Viewed("", history=read_history(path))
    except FileError:
        return _read_text(path)


def _read_picture(path: Path) -> Viewed:
    content = read_bytes(path)
    if not content.startswith(b"\x89PNG\r\n\x1a\n"):
        raise FileError(f"{path}: is no PNG picture; expected one that StitchMesh wrote")
    return Viewed("", picture=content)


def _read_text(path: Path) -> Viewed:
    text = "\n".join(read_lines(path))
    more = f"\n... and {len(text) - MOST_CHARACTERS} more characters" if len(text) > MOST_CHARACTERS else ""
    return Viewed("", text=text[:MOST_CHARACTERS] + more)


READERS: dict[str, Callable[[Path], Viewed]] = {
    ".smc": read_checkpoint_file, ".csv": _read_table, ".png": _read_picture, **dict.fromkeys(TEXTS, _read_text),
}  # fmt: skip
"""Functions that read files other than meshes, stitches and yarns, by suffix."""
