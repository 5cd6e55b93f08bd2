# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time until a state of a run is ready to be drawn on the page Drape: sketched, as while it goes on, and whole.

Nothing is simulated: the state is the start of the scene. The first picture also makes what all pictures of a region
share.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

from tyro.conf import Positional

from benchmarks.table import Rows
from stitchmesh.app.pages.view.draped_view import DrapedSketch, DrapedView
from stitchmesh.mixed.drape import Draped
from stitchmesh.mixed.output.display import Displays
from stitchmesh.mixed.output.frames import DrapeFrame, Frames
from stitchmesh.mixed.scene.scene import Scene, read_scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from tests.app.null_front import NullScene

PICTURES = 5
"""Number of pictures after the first one, of whose times the median is printed."""


@dataclass(frozen=True)
class Options:
    """What is measured."""

    scene: Positional[Path]
    densities: tuple[float, ...] = (1.5, 6.0)


def drape_frames(arguments: Options) -> Rows:
    """Yield a line for each density."""
    scene = read_scene(arguments.scene)
    yield "yarn nodes", "whole, first [s]", "whole [s]", "sketch, first [s]", "sketch [s]"
    for density in arguments.densities:
        run = start_of(replace(scene, yarns=replace(scene.yarns, density=density)))
        times = [f"{seconds:.3f}" for draw in (draw_whole, draw_sketch) for seconds in times_of(run, draw)]
        yield f"{run.prepared.fabric.yarns.node_count:,}", *times


def start_of(scene: Scene) -> Draped:
    """Return the start of a scene as a run of one frame."""
    prepared, frames = prepare(scene), Frames()
    region, fabric = prepared.region, prepared.fabric
    state = prepared.vertices, prepared.nodes, prepared.sliding
    frames.add(DrapeFrame(0.0, *state, region.triangle_kind, region.vertex_alpha))
    displays = Displays(fabric.cloth, fabric.yarns, region, scene.output.subdivisions)
    return Draped(prepared=prepared, displays=displays, frames=frames, report={})


def times_of(run: Draped, draw: Callable[[Draped, object], object]) -> tuple[float, float]:
    """Return the times of the first picture and of the later ones [s]."""
    times: list[float] = []
    before: object = None
    for _ in range(1 + PICTURES):
        began = time.perf_counter()
        before = draw(run, before)
        times.append(time.perf_counter() - began)
    return times[0], median(times[1:])


def draw_whole(run: Draped, before: object) -> object:
    """Draw the curves of the simulated yarns, and the smooth surface."""
    view = DrapedView(run, before)
    view.draw(NullScene(), view.coloured("yarn", None, None).points, None)
    return view


def draw_sketch(run: Draped, before: object) -> object:
    """Draw some yarns as lines, and the triangles."""
    sketch = DrapedSketch(run, before)
    sketch.draw(NullScene(), alpha=False)
    return sketch
