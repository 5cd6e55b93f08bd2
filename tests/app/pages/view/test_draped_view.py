# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page View on the folder of a run of mixed yarns and triangles, without a browser."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.view.draped_view import DrapedView
from stitchmesh.app.pages.view.state import DRAPED_COLOURS
from stitchmesh.app.scene.drawing import Surface, YarnTubes
from stitchmesh.mixed.drape import Draped, drape
from stitchmesh.mixed.enrichment.region import YARNS
from stitchmesh.mixed.output.files import state_maps
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl, Snapshot
from tests.app.pages.headless import SAFETY, Headless, headless
from tests.app.pages.view.test_view import job_changed, opened, yarns_drawn
from tests.mixed.small_scene import SWINGING


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """The output folder of a run that has ended."""
    place = tmp_path_factory.mktemp("swinging")
    drape(SWINGING, place).write(place)
    return place


@pytest.fixture
def view(tmp_path) -> Iterator[Headless]:
    with headless(tmp_path, None, "View") as page:
        yield page


def run_of(view: Headless) -> Draped:
    assert isinstance(view.app.page._view, DrapedView)
    return view.app.page._view.draped


def surface(view: Headless) -> Surface:
    drawing = view.scene.drawings["viewed surface"]
    assert isinstance(drawing, Surface)
    return drawing


def test_yarns_are_drawn_in_the_region_and_triangles_outside(view, folder):
    opened(view, folder)
    run = run_of(view)
    assert np.array_equal(yarns_drawn(view).points, run.yarns.points)
    assert np.array_equal(surface(view).points, run.shown.surface)
    kinds = run.prepared.region.node_kind[view.app.page._view.node]
    # runs are cut at the region: each drawn piece has at most its two ends beside it
    assert set(np.flatnonzero(kinds == YARNS)) <= set(yarns_drawn(view).blocks.source.tolist())
    assert len(yarns_drawn(view).blocks.source) < len(kinds)
    assert "Time of a step" in view.controls.text_shown() and "is finished" in view.controls.text_shown()
    view.controls.set("Yarns everywhere", True)
    view.app.queue.settle(SAFETY)
    assert "viewed surface" not in view.scene.drawings
    assert set(yarns_drawn(view).blocks.source.tolist()) == set(range(len(kinds)))


def test_frames_are_chosen_by_slider_and_buttons(view, folder):
    opened(view, folder)
    run = run_of(view)
    for act, number in ((("set", "Moment", 0.0), 0), (("press", "Frames", "Next frame"), 1),
                        (("press", "Frames", "Frame before"), 0), (("press", "Frames", "Newest"), 2)):  # fmt: skip
        blocks = yarns_drawn(view).blocks
        getattr(view.controls, act[0])(*act[1:])
        view.app.queue.settle(SAFETY)
        assert np.array_equal(yarns_drawn(view).points, run.yarns_at(run.frames[number]).points)
        assert yarns_drawn(view).blocks is blocks


def test_colours_cover_yarns_and_surface(view, folder):
    opened(view, folder)
    for words in DRAPED_COLOURS:
        view.controls.set("Colour the run by", words)
        tubes = yarns_drawn(view)
        assert tubes.colours.shape == tubes.points.shape
        assert len(surface(view).colours.index) == len(surface(view).points) == len(run_of(view).shown.surface)


def test_alpha_and_tension_are_those_of_the_maps(view, folder):
    """The largest tension of the map has the last colour; alpha 1 has the colour of yarns."""
    opened(view, folder)
    run = run_of(view)
    shown = view.app.page._view
    tension = state_maps(run.prepared.fabric, run.display, run.end).triangle_tension
    scale = shown.coloured("cloth-tension", None, None).scale
    assert 0.0 < scale.high <= tension.max() and scale.low == 0.0
    alpha = shown.coloured("alpha", None, None)
    full = run.prepared.region.node_alpha[shown.node] == 1.0
    assert (alpha.points[: len(full)][full] == alpha.scale.of(np.ones(1))).all()


def test_a_click_says_what_is_simulated(view, folder):
    opened(view, folder)
    view.controls.set("Moment", 0.0)
    view.app.queue.settle(SAFETY)
    view.click([1.51, 1.48, 0.0])
    assert "of panel: yarns are simulated" in view.controls.text_shown()
    view.click([0.05, 2.95, 0.0])
    assert "of panel: triangles are simulated" in view.controls.text_shown()


def test_a_run_is_followed(view, tmp_path):
    """Each frame is shown when it is written; what the frames share is made once."""
    place, seen = tmp_path / "run", []

    def look(snapshot: Snapshot[Draped]) -> None:
        if not seen:
            opened(view, place)
        else:
            job_changed(view, place)
        run = run_of(view)
        assert run.report == {} and np.array_equal(yarns_drawn(view).points, run.yarns.points)
        seen.append(run)

    drape(SWINGING, place, run=Run(control=RunControl(look, seconds=0.0))).write(place)
    job_changed(view, place)
    last = run_of(view)
    assert len(last.frames) == 3 and last.report and all(run.display is last.display for run in seen)
    assert "is finished" in view.controls.text_shown()


@pytest.mark.parametrize("kind", ["none", "all"])
def test_triangles_alone_and_yarns_alone_are_shown(view, tmp_path, kind):
    place = tmp_path / "run"
    drape(replace(SWINGING, region=RegionSection(yarns=kind), duration=0.004), place).write(place)
    opened(view, place)
    assert ("viewed" in view.scene.drawings) == (kind == "all")
    assert ("viewed surface" in view.scene.drawings) == (kind == "none")
    assert view.notices() == ""


def test_another_thing_takes_the_place_of_a_run(view, folder):
    opened(view, folder)
    opened(view, folder / "yarns.bcc")
    assert isinstance(view.scene.drawings["viewed"], YarnTubes) and "viewed surface" not in view.scene.drawings
    opened(view, folder)
    assert "viewed surface" in view.scene.drawings
    opened(view, folder / "cloth.obj")
    assert isinstance(view.scene.drawings["viewed"], Surface) and "viewed surface" not in view.scene.drawings
