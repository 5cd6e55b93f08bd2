# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page says about a scene and its run, as HTML."""

from __future__ import annotations

from stitchmesh.app.controls.html_pieces import figures, message
from stitchmesh.app.live_run import AnyRun
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.project.project import Project
from stitchmesh.markup import Markup
from stitchmesh.mixed.drape import Draped
from stitchmesh.reporting.figures import duration

NO_SCENE = "There is no scene yet. Open a scene file, or a cloth: panels, a mesh or stitches."


def no_scene_html(project: Project) -> Markup:
    """Return what can be opened where there is no scene: the garment of the project among it, if there is one."""
    if project.fabric is not None:
        return message(f"{NO_SCENE} The stitches of the garment of this project are a cloth too.", "info")
    if project.mesh is not None:
        return message(f"{NO_SCENE} The garment of this project is a cloth once it is divided into stitches.", "info")
    return message(NO_SCENE, "info")


def counts_html(opened: OpenedScene) -> Markup:
    """Return the numbers of nodes and vertices of a scene, and the memory that it needs."""
    counts, free = opened.counts, opened.free_memory()
    rows = [
        ("Yarn nodes, simulated", f"{counts['yarn_nodes_full']:,}"),
        ("Yarn nodes, hybrid", f"{counts['yarn_nodes_hybrid']:,}"),
        ("Yarn nodes, all", f"{counts['yarn_nodes']:,} of {counts['yarns']:,} yarns"),
        ("Vertices, triangles only", f"{counts['vertices_triangle_only']:,}"),
        ("Vertices, hybrid", f"{counts['vertices_hybrid']:,}"),
        ("Triangles", f"{counts['triangles']:,}"),
        ("Memory, about", f"{1e-6 * opened.memory:,.0f} of {1e-6 * free:,.0f} MB that are free"),
    ]
    trouble = message(opened.trouble, "doubtful") if opened.trouble else Markup()
    if not trouble and opened.memory > free:
        trouble = message("The run needs more memory than is free; make the region smaller.", "doubtful")
    if not trouble and opened.scene.region.yarns == "automatic":
        trouble = message("The region is found at the start of the run, or now by the button below.", "info")
    return figures(rows) + trouble


def run_words(run: AnyRun) -> str:
    """Return how far a run is."""
    if run.newest is None:
        return f"Running: {run.task.stage}, {100 * run.task.done:.0f} %." if run.task.stage else "Preparing."
    now = run.newest
    state = "Paused" if run.paused else "Running"
    left = run.outlook.words
    remaining = f" {left[0].upper()}{left[1:]}." if left and not run.paused else ""
    time = now.state.end.time
    static = now.state.prepared.scene.mode == "static"
    work = _counted(now.iteration, *(("iteration", "iterations") if static else ("step", "steps")))
    return f"{state}: {time:.4g} s of the scene, {work}, {duration(now.seconds)}.{remaining}"


def end_html(draped: Draped | None, *, current: bool) -> Markup:
    """Return how a run ended; an empty text without one.

    Args:
        draped: the result.
        current: whether it is that of the scene as it is now.
    """
    mixed = {} if draped is None else draped.report.get("mixed", {})
    if not mixed:
        return Markup()
    if not current:
        return message("The scene has changed since the run, which shows it as it was.", "info")
    unit = "dyn" if mixed["mode"] == "static" else "cm/s"
    names = ("equilibrium", "equilibria") if mixed["mode"] == "static" else ("step", "steps")
    if mixed["converged"]:
        work = _counted(mixed["steps"], *names)
        return message(f"The run has converged: {work}, {duration(mixed['seconds'])}.", "good")
    return message(f"The run was stopped or has not converged: the error is {mixed['error']:.2g} {unit}.", "doubtful")


def _counted(count: int, one: str, many: str) -> str:
    return f"{count:,} {one if count == 1 else many}"
