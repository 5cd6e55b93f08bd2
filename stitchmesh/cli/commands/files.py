# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that say what a file holds, check it, and convert it: ``info``, ``check`` and ``convert``."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np
from tyro.conf import Positional, arg

from stitchmesh.cli.options import FileReading, Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError, first_few
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.faces.face_type import stitch_of
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh import Mesh, StitchMesh, extent
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.shaping_stitches import stitch_counts
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True)
class InfoCommand:
    """Describe the content of a file."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Print the lines that describe the file."""
        from stitchmesh.io.garments import doubt_of_unit
        from stitchmesh.io.mesh_objects import scene_objects

        found = self.reading.read(self.file)
        for line in _description(found):
            say(line)
        if type(found) is not Mesh:
            return
        objects = scene_objects(self.file, found.vertices, found.polygons).objects
        if len(objects) > 1:
            say(f"objects: {', '.join(objects)}")
        if doubt := doubt_of_unit(self.file, found, self.reading.unit):
            say(f"if it is a garment: {doubt}")


@dataclass(frozen=True)
class CheckCommand:
    """Check a file; the exit status is 0 for a valid file, else 2."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Read the file, which validates it, and print its kind."""
        say(f"{self.file}: valid {_kind_of(self.reading.read(self.file))}")


@dataclass(frozen=True)
class ConvertCommand:
    """Convert yarns, a polygon mesh or a stitch mesh to another format."""

    file: Annotated[Positional[str], help_entry("IN")]
    """polygon mesh, stitch mesh or yarns"""
    output: Annotated[Positional[str], help_entry("OUT")]
    """output file in the format of its suffix; for a stitch mesh also .k for a knitting machine"""
    tile: Annotated[tuple[int, int] | None, help_entry("C R", "the lattice or one period")] = None
    """for periodic yarns: numbers of periods to write along the courses and along the wales"""
    detail: Annotated[Literal["fine", "coarse"], help_entry("fine|coarse")] = "fine"
    """level of detail of the tubes in a .glb file of yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Read the file, and write its content in the other format."""
        from stitchmesh.io import write_mesh, write_stitches, write_yarns
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.meshes import FORMATS
        from stitchmesh.io.stitch_formats.face_meshes import write_face_mesh
        from stitchmesh.io.stitches import WRITABLE
        from stitchmesh.io.yarns import FORMATS as YARNS
        from stitchmesh.yarngen.face_yarns.generate import face_yarns

        content = self.reading.read(self.file)
        if isinstance(content, FaceMesh) and suffix_of(self.output, (".smobj", *YARNS)) != ".smobj":
            content = face_yarns(content).yarns
        if self.detail != "fine" and not isinstance(content, YarnSet):
            raise ParameterError(f"detail: {self.file} is a {_kind_of(content)}; only tubes of yarns have a detail")
        if isinstance(content, YarnSet):
            write_yarns(self.output, content, tiles=self.tile, detail=self.detail)
        elif isinstance(content, FaceMesh):
            write_face_mesh(self.output, content)
        elif self.tile is not None:
            raise ParameterError(f"tile: {self.file} is a {_kind_of(content)}; only periodic yarns can be tiled")
        elif isinstance(content, StitchMesh) and suffix_of(self.output, (*WRITABLE, *FORMATS)) in WRITABLE:
            write_stitches(self.output, content)
        else:
            write_mesh(self.output, content)
        repeats = "" if self.tile is None else f", {self.tile[0]} x {self.tile[1]} repeats of it"
        say(f"Wrote {self.output}: {_in_brief(content)}{repeats}.")


def _kind_of(content: Mesh | YarnSet | FaceMesh) -> str:
    """Return the name of the kind of a file's content."""
    return {YarnSet: "yarns", StitchMesh: "stitch mesh", Mesh: "polygon mesh", FaceMesh: "face mesh"}[type(content)]


def _description(content: Mesh | YarnSet | FaceMesh) -> list[str]:
    """Return the lines that describe a mesh, a stitch mesh, a face mesh or yarns.

    Raises:
        LabelError: the cables of a stitch mesh are malformed.
    """
    if isinstance(content, YarnSet):
        return _yarn_lines(content)
    if isinstance(content, FaceMesh):
        return _face_lines(content)
    counts = f"{content.face_count} faces, {len(content.vertices)} vertices, {len(content.edge_side)} edges"
    lines = [
        f"{_kind_of(content)}: {counts}",
        f"borders: {len(content.boundary_loops)}",
        f"area: {np.linalg.norm(content.face_vector_area, axis=1).sum():.2f} cm2",
        f"extent: {extent(content.vertices)}",
    ]
    return [*lines, *_stitch_lines(content)] if isinstance(content, StitchMesh) else lines


def _in_brief(content: Mesh | YarnSet | FaceMesh) -> str:
    """Return the kind and the main counts of a mesh, a stitch mesh, a face mesh or yarns, as part of one line."""
    if isinstance(content, FaceMesh):
        return f"face mesh, {content.face_count:,} faces, {len(content.joins):,} joins"
    if isinstance(content, YarnSet):
        metres = float(content.lengths.sum()) / 100.0
        return f"{content.yarn_count:,} yarns, {len(content.points):,} control points, {metres:.3g} m"
    if not isinstance(content, StitchMesh):
        return f"polygon mesh, {content.face_count:,} faces, {len(content.vertices):,} vertices"
    kind = "panels" if (content.stitch == Stitch.PANEL).all() else "stitches"
    return f"stitch mesh, {content.face_count:,} {kind} in {content.row.max() + 1:,} rows"


def _yarn_lines(yarns: YarnSet) -> list[str]:
    return [
        f"yarns: {yarns.yarn_count} ({int(yarns.closed.sum())} closed)",
        f"control points: {len(yarns.points)}",
        f"colours: {len(np.unique(yarns.colour))}",
        f"length: {yarns.lengths.sum():.2f} cm",
        f"radius: {yarns.radius.min():.4g} to {yarns.radius.max():.4g} cm",
        f"strain: {yarns.strain.min():.3%} to {yarns.strain.max():.3%}",
        f"extent: {extent(yarns.points)}",
    ]


def _face_lines(mesh: FaceMesh) -> list[str]:
    """Return the lines of the faces by their types, the most frequent type first, and of what else the file says."""
    names = Counter(mesh.type_of(face).name for face in range(mesh.face_count)).most_common()
    foreign = sum(stitch_of(mesh.type_of(face)) is None for face in range(mesh.face_count))
    return [
        f"face mesh: {mesh.face_count} faces, {foreign} of them no stitches, {len(mesh.joins)} joins",
        "faces: " + ", ".join(f"{count} {name}" for name, count in names),
        f"joins without reversal: {int((~mesh.reverses).sum())}",
        f"hints for a machine: {len(mesh.hints)}",
        f"checkpoints on yarns: {len(mesh.checkpoints)}",
        f"extent: {extent(mesh.vertices)}",
    ]


def _stitch_lines(fabric: StitchMesh) -> list[str]:
    """Return the lines of the rows, the stitches by their kinds, the most frequent kind first, and the marks."""
    rows = f"rows: {fabric.row.max() + 1}"
    if (fabric.stitch == Stitch.PANEL).all():
        return [rows, "stitches: none, because the mesh is labeled but not tessellated"]
    kinds, counts = np.unique(fabric.stitch, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    stitches = ", ".join(f"{counts[k]} {stitch_name(fabric.stitch_type(int(kinds[k])))}" for k in order)
    shaped = stitch_counts(fabric)
    return [
        rows,
        f"stitches: {stitches}",
        f"increases: {shaped['increases']}",
        f"decreases: {shaped['decreases']}",
        f"twisted loops: {np.count_nonzero(fabric.twist)}",
        f"cables: {_cables(fabric)}",
        f"colours: {_colour_counts(fabric)}",
    ]


def _colour_counts(fabric: StitchMesh) -> str:
    """Return the number of colours of the stitches and, if there are several, the number of stitches of each colour.

    A colour may be knitted with many yarns: each ring of a tube has its own.
    """
    numbers, faces = np.unique(fabric.yarn, return_counts=True)
    if len(numbers) == 1:
        return "1"
    stitches = ", ".join(f"{count} stitches of {number}" for number, count in zip(numbers, faces, strict=True))
    return f"{len(numbers)} ({stitches})"


def _cables(fabric: StitchMesh) -> str:
    """Return the number of cable crossings and their numbers of loops."""
    groups = cable_groups(fabric)
    if not groups:
        return "0"
    sizes = sorted({len(group.sides) for group in groups})
    return f"{len(groups)} of {first_few(sizes, len(sizes))} loops"
