# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The loadings on which ``mixed`` compares regions. Each has one equilibrium, which a run finds from shaken starts too.

corner      a square is held along its upper border and stretched by its lower one, except for the last quarter of it.
            The lower right corner is pulled up, inwards and out of the plane, so that the cloth folds beside it.
sheared     the patch of ``examples/mixed/sheared.toml``, sheared by less: it wrinkles along its diagonal.
puckering   the seam of ``examples/mixed/puckering.toml``, with less difference in length.

Sheared and puckered cloth buckles: a wave at the start prescribes the direction and the number of the wrinkles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.places import MIXED_SCENES
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.scene.motion_section import AttachmentSection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.scene import ClothSection, Scene, SceneSolverSection, YarnsSection, read_scene
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare

Numbers = NDArray[np.float64]
PULL = (-0.04, 0.02, 0.1)
"""Displacement of the corner, in sizes of the cloth."""
STRETCH = 0.02
"""Displacement of the lower border of the square, in its size."""
LOAD_STEPS = 4
SHAKE = 1e-3
"""Random displacements at the start [cm]; repeated runs have others of this size."""


@dataclass(frozen=True, eq=False)
class Loading:
    """A scene, the part of it that is measured, and regions made by hand around this part."""

    name: str
    prepared: PreparedScene
    spacing: float
    """Distance between neighbouring yarns [cm]."""
    near: NDArray[np.bool_]
    """Whether each node belongs to the measured part, shape (N,)."""
    sizes: tuple[float, ...]
    """Sizes of the regions made by hand [cm]."""
    by_hand: Callable[[float], NDArray[np.int64]]
    """From a size to the triangles of the region."""
    rings: tuple[int, ...] = (1,)
    """Hybrid widths."""

    def shaken(self, seed: int) -> PreparedScene:
        """Return the scene with other random displacements at the start."""
        shake = SHAKE * np.random.default_rng(seed).uniform(-1.0, 1.0, len(self.prepared.vertices))
        return replace(self.prepared, vertices=self.prepared.vertices + shake[:, None] * [0.0, 0.0, 1.0])


def corner(solver: SceneSolverSection, *, size: float = 8.0, density: float = 4.0, edge: float = 1.0) -> Loading:
    """Return the fold beside a corner.

    Args:
        solver: precision, processor and tolerances.
        size: side of the square [cm].
        density: warps and wefts for each cm.
        edge: edges of the triangles [cm].
    """
    far, strip = size + 1.0, 0.6 / density  # the strip holds the outermost yarn, or the outermost vertices
    pulled = BoxSection(low=(size - edge, -1.0, -1.0), high=(far, edge, 1.0))
    border = BoxSection(low=(-1.0, -1.0, -1.0), high=(0.75 * size, strip, 1.0))
    top = BoxSection(low=(-1.0, size - strip, -1.0), high=(far, far, 1.0))
    scene = Scene(
        cloth=ClothSection(rectangle=(size, size), edge_length=edge, material="matched"),
        yarns=YarnsSection(weave="plain", ends=density, picks=density, material="gong-1"),
        gravity=(0.0, 0.0, 0.0),
        load_steps=LOAD_STEPS,
        attachments=(
            AttachmentSection(boxes=(top,)),
            AttachmentSection(boxes=(border,), keyframes=moving((0.0, -STRETCH * size, 0.0))),
            AttachmentSection(boxes=(pulled,), keyframes=moving(tuple(part * size for part in PULL))),
        ),
        solver=solver,
    )
    prepared = prepare(scene)
    right, low = size - prepared.fabric.yarns.position[:, 0], prepared.fabric.yarns.position[:, 1]
    held = (right < edge) & (low < edge)
    part = 3.0 / 8.0 * size
    near = np.array((right < part) & (low < part) & ~held)
    centre = prepared.fabric.cloth.rest.mean(axis=1)

    def by_hand(side: float) -> NDArray[np.int64]:
        return np.flatnonzero((centre[:, 0] > size - side) & (centre[:, 1] < side))

    return Loading("corner", prepared, 1.0 / density, near, (part, 1.3 * part, 1.7 * part, 2.0 * part), by_hand, (1, 2))


def sheared(solver: SceneSolverSection, *, shear: float = 0.35, edge: float = 0.8) -> Loading:
    """Return the patch that is sheared by a displacement [cm]."""
    scene = read_scene(MIXED_SCENES / "sheared.toml")
    fixed, moved = scene.attachments
    moved = replace(moved, keyframes=moving((-0.1 * shear, shear, 0.0)))
    prepared = _prepared(scene, (fixed, moved), solver, edge)
    vertices = prepared.vertices
    along = (vertices[:, 0] - vertices[:, 1]) / np.sqrt(2.0)
    prepared = _waved(prepared, along, length=1.6, height=0.05)
    width, height = 5.0, 4.0
    position, centre = prepared.fabric.yarns.position, prepared.fabric.cloth.rest.mean(axis=1)

    def inside(points: Numbers, size: float) -> NDArray[np.bool_]:
        part = size / height
        across = np.abs(points - [0.5 * width, 0.5 * height])
        return np.array((across <= 0.5 * part * np.array([width, height])).all(axis=1))

    def by_hand(size: float) -> NDArray[np.int64]:
        return np.flatnonzero(inside(centre, size))

    return Loading("sheared", prepared, 0.2, inside(position, 2.0), (1.5, 2.0, 2.6, 3.2), by_hand)


def puckering(solver: SceneSolverSection, *, longer: float = 0.3, edge: float = 0.6) -> Loading:
    """Return two patches of different lengths that are sewn together; the difference is in cm."""
    scene = read_scene(MIXED_SCENES / "puckering.toml")
    long, short = scene.cloth.panels
    short = replace(short, outline=((0.0, 0.0), (6.0 - longer, 0.0), (6.0 - longer, 2.0), (0.0, 2.0)))
    scene = replace(scene, cloth=replace(scene.cloth, panels=(long, _moved(short, 0.5 * longer))))
    prepared = _prepared(scene, scene.attachments, solver, edge)
    distance = np.abs(prepared.vertices[:, 1] - 2.0)
    prepared = _waved(prepared, prepared.vertices[:, 0], length=2.0, height=0.1 * np.maximum(1.0 - distance, 0.0))
    fabric = prepared.fabric
    nodes = fabric.yarns.world(fabric.cloth)[:, 1]
    centre = fabric.cloth.vertices[fabric.cloth.triangles].mean(axis=1)[:, 1]

    def by_hand(size: float) -> NDArray[np.int64]:
        return np.flatnonzero(np.abs(centre - 2.0) <= 0.5 * size)

    return Loading("puckering", prepared, 0.2, np.abs(nodes - 2.0) < 0.6, (1.0, 1.8), by_hand)


LOADINGS: dict[str, Callable[..., Loading]] = {"corner": corner, "sheared": sheared, "puckering": puckering}
"""The loadings by name."""


def moving(displacement: tuple[float, ...]) -> tuple[Keyframe, Keyframe]:
    """Return the keyframes of a displacement [cm] in a time of 1 s."""
    x, y, z = displacement
    return Keyframe(time=0.0), Keyframe(time=1.0, displacement=(x, y, z))


def _moved(panel: Panel, shift: float) -> Panel:
    """A panel that begins farther along x [cm]."""
    assert panel.position is not None
    return replace(panel, position=replace(panel.position, origin=(shift, *panel.position.origin[1:])))


def _prepared(
    scene: Scene, attachments: tuple[AttachmentSection, ...], solver: SceneSolverSection, edge: float
) -> PreparedScene:
    cloth = replace(scene.cloth, material="matched", edge_length=edge)
    return prepare(
        replace(scene, cloth=cloth, attachments=attachments, solver=solver, load_steps=LOAD_STEPS, disturbance=0.0)
    )


def _waved(prepared: PreparedScene, along: Numbers, length: float, height: Numbers | float) -> PreparedScene:
    """A scene whose flat cloth begins with a wave of a length and a height [cm]."""
    wave = height * np.cos(2.0 * np.pi * along / length)
    return replace(prepared, vertices=prepared.vertices + np.outer(wave, [0.0, 0.0, 1.0]))
