# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Too few stitches under an arm, found by the stretch of the stitch mesh and mended (Yuksel et al. 2012, figure 23).

The upper row of the picture is a sweater whose course edges under the arms have a third of the stitches that their
length needs; in the lower row they have all of them. Left: the stretch of the stitches, which is known before any yarn
is made. Right: the yarns at rest.
"""

from __future__ import annotations

from functools import partial

import numpy as np

import stitchmesh as sm
from benchmarks.options import Output
from benchmarks.places import MESHES
from benchmarks.sheet import drawn
from benchmarks.table import Rows
from stitchmesh.mesh import StitchMesh
from stitchmesh.render.animation_pictures import joined

SWEATER = MESHES / "sweater.obj"
WIDTH = 1.6
"""Stitch width [cm]."""
SHOULDER = 45.0
"""Height that lies above the underarms and below the shoulders [cm]."""
REACH = 9.0
"""Distance from the middle of the underarm within which course edges have too few stitches [cm]."""
SIZE = (640, 520)
"""Size of each picture [pixels]."""


def underarm(mesh: sm.Mesh) -> np.ndarray:
    """The middle of the left underarm: the highest vertex of the body below the sleeve [cm], shape (3,)."""
    points = mesh.vertices
    beside = (np.abs(points[:, 2]) < 1.0) & (points[:, 0] > 15.0) & (points[:, 0] < 23.0) & (points[:, 1] < SHOULDER)
    highest: np.ndarray = points[beside][np.argmax(points[beside, 1])]
    return highest


def too_few(labeled: StitchMesh, middle: np.ndarray) -> dict[tuple[int, int], int]:
    """A third of the stitches for the course edges near both underarms, by their vertices."""
    sides = labeled.edge_side[~labeled.is_wale[labeled.edge_side]]
    ends = np.stack([labeled.face_vertex[sides], labeled.face_vertex[labeled.side_next[sides]]], axis=1)
    places = labeled.vertices[ends].mean(axis=1)
    places[:, 0] = np.abs(places[:, 0])
    near = np.linalg.norm(places - middle, axis=1) < REACH
    length = np.linalg.norm(np.diff(labeled.vertices[ends[near]], axis=1)[:, 0], axis=1)
    counts = np.maximum(1, np.round(length / WIDTH / 3.0)).astype(int)
    return {(int(a), int(b)): int(count) for (a, b), count in zip(ends[near], counts, strict=True)}


def stretched(fabric: StitchMesh, middle: np.ndarray) -> str:
    """Where the stitches are stretched most, in words."""
    stretch = fabric.face_stretch
    assert stretch is not None
    worst = int(np.nanargmax(stretch))
    corners = fabric.vertices[fabric.face_vertex[fabric.sides_of(np.array([worst]))]].mean(axis=0)
    distance = np.linalg.norm(np.abs(corners) - np.abs(middle))
    return (
        f"{fabric.face_count:,} stitches, largest stretch of a stitch {np.nanmax(stretch):.2f}, "
        f"{distance:.1f} cm from the underarm; {np.count_nonzero(stretch > 1.4)} stitches above 1.4"
    )


def armpit(*, output: Output) -> Rows:
    """Knit both sweaters, print their stretch, and draw them."""
    mesh = sm.read_mesh(SWEATER)
    labeled, middle = sm.label(mesh), underarm(mesh)
    place = f"point {middle[0]:.1f} {middle[1]:.1f} {middle[2]:.1f}"
    shown = partial(sm.render, close_up=place, extent=34.0, view="20,-10", size=SIZE)
    pictures = []
    for name, counts in (("too few", too_few(labeled, middle)), ("mended", None)):
        fabric = sm.relax_mesh(sm.tessellate(labeled, stitch_width=WIDTH, counts=counts), surface=mesh).fabric
        yield f"{name}: {stretched(fabric, middle)}"
        relaxed = sm.relax_yarns(sm.generate_yarns(fabric, quality="draft"), quality="draft", keep_shape=fabric)
        yield f"yarns: converged {relaxed.report['converged']}, strain {100 * relaxed.report['max_strain']:.1f} %"
        pictures.append(drawn(partial(shown, fabric, colour="stretch")))
        pictures.append(drawn(partial(shown, relaxed.yarns, colour="yarn")))
    joined(pictures, 2).save(output, quality=85)
