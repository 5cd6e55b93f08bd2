# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a mesh, a stitch mesh or yarns are, in a few lines of words and numbers."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import first_few
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.stitch import CODES, Stitch
from stitchmesh.mesh.stitch_counts import stitch_counts
from stitchmesh.yarn import YarnSet

NAMES = {stitch: code for code, stitch in CODES.items()} | {
    Stitch.PANEL: "panel",
    Stitch.CAST_ON: "cast-on",
    Stitch.BIND_OFF: "bind-off",
    Stitch.DRAW_THROUGH: "draw-through",
}
"""What each kind of face is called: its code, where it has one."""


def kind_of(noun: Mesh | YarnSet) -> str:
    """What the noun is, in words."""
    return {YarnSet: "yarns", StitchMesh: "stitch mesh", Mesh: "polygon mesh"}[type(noun)]


def description(noun: Mesh | YarnSet) -> list[str]:
    """The lines that describe it.

    Raises:
        LabelError: cables of a stitch mesh are malformed.
    """
    if isinstance(noun, YarnSet):
        return _of_yarns(noun)
    lines = [
        f"{kind_of(noun)}: {noun.face_count} faces, {len(noun.vertices)} vertices, {len(noun.edge_side)} edges",
        f"borders: {len(noun.boundary_loops)}",
        f"area: {np.linalg.norm(noun.face_vector_area, axis=1).sum():.2f} cm2",
        _extent(noun.vertices),
    ]
    return [*lines, *_of_stitches(noun)] if isinstance(noun, StitchMesh) else lines


def _of_yarns(yarns: YarnSet) -> list[str]:
    return [
        f"yarns: {yarns.yarn_count} ({int(yarns.closed.sum())} closed)",
        f"control points: {len(yarns.points)}",
        f"length: {yarns.lengths.sum():.2f} cm",
        f"radius: {yarns.radius.min():.4g} to {yarns.radius.max():.4g} cm",
        f"strain: {yarns.strain.min():.3%} to {yarns.strain.max():.3%}",
        _extent(yarns.points),
    ]


def _of_stitches(fabric: StitchMesh) -> list[str]:
    """Rows, stitches by their kinds, the most frequent first, and their marks."""
    rows = f"rows: {fabric.row.max() + 1}"
    if (fabric.stitch == Stitch.PANEL).all():
        return [rows, "stitches: none yet, each face is a panel of them"]
    kinds, counts = np.unique(fabric.stitch, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    stitches = ", ".join(f"{counts[k]} {NAMES[Stitch(int(kinds[k]))]}" for k in order)
    shaped = stitch_counts(fabric)
    return [
        rows,
        f"stitches: {stitches}",
        f"increases: {shaped['increases']}",
        f"decreases: {shaped['decreases']}",
        f"twisted loops: {np.count_nonzero(fabric.twist)}",
        f"cables: {_cables(fabric)}",
        f"yarns: {_yarns_of(fabric)}",
    ]


def _yarns_of(fabric: StitchMesh) -> str:
    """How many yarns the stitches name, and where there are several, which is in how many."""
    numbers, faces = np.unique(fabric.yarn, return_counts=True)
    if len(numbers) == 1:
        return "1"
    stitches = ", ".join(f"{count} stitches in {number}" for number, count in zip(numbers, faces, strict=True))
    return f"{len(numbers)} ({stitches})"


def _cables(fabric: StitchMesh) -> str:
    """How many crossings there are, of how many loops."""
    groups = cable_groups(fabric)
    if not groups:
        return "0"
    sizes = sorted({len(group.sides) for group in groups})
    return f"{len(groups)} of {first_few(sizes, len(sizes))} loops"


def _extent(points: FloatArray) -> str:
    size = points.max(axis=0) - points.min(axis=0)
    return f"extent: {size[0]:.2f} x {size[1]:.2f} x {size[2]:.2f} cm"
