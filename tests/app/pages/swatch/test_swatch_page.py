# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Swatch without a browser: the fabric follows the chart and the dials, and all of it is kept."""

from __future__ import annotations

import io
import threading
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.app.application import App
from stitchmesh.app.pages.gauge_panel import OWN_YARN
from stitchmesh.app.pages.swatch import stretch_panel
from stitchmesh.app.pages.swatch.dial_panel import DialPanel
from stitchmesh.app.pages.swatch.page import SwatchPage
from stitchmesh.app.pages.swatch.state import SwatchState, first_state, state_table
from stitchmesh.app.pages.swatch.stretch_panel import snap_texts
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.drawing import Copies, Labels
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.stretch import StretchCurve, StretchPoint
from stitchmesh.periodic.swatch_design import SwatchDesign
from stitchmesh.yarn.yarn_presets import Yarn
from tests.app.null_front import NullControl, NullControls, NullFront
from tests.app.pages.headless import SAFETY, Headless, call

PLAIN = SwatchState((SwatchDesign(sm.read_weave("plain")),))
"""The fabric that comes to rest soonest, in the place of the first pattern of a new project, which takes seconds."""
LOOKS = 3000
"""Number of times that a waiting test looks before it fails."""


class SwatchRig(Headless):
    """The application on its page Swatch."""

    def __init__(self, folder: Path) -> None:
        front = NullFront()
        super().__init__(App(Project.open_or_create(folder), front), front)
        self.do(self.app.open_page, "Swatch")

    @property
    def page(self) -> SwatchPage:
        assert isinstance(self.app.page, SwatchPage)
        return self.app.page

    def do(self, function: Callable[..., object], *arguments: object) -> None:
        call(self, function, *arguments)

    def set(self, label: str, value: object) -> None:
        self.do(self.front.controls.set, label, value)

    def press(self, label: str, option: str | None = None) -> None:
        self.do(self.front.controls.press, label, option)

    def choose(self, pattern: str) -> None:
        self.do(self.front.left_controls.set, "Start from", pattern)

    def until(self, condition: Callable[[], object]) -> None:
        """Wait until a condition holds in the event thread."""
        found: list[object] = []
        for _ in range(LOOKS):
            self.do(lambda: found.append(condition()))
            if found[-1]:
                return
            threading.Event().wait(SAFETY / LOOKS)
        raise AssertionError(f"waited in vain; {self.front.controls.text_shown()}")

    def rest(self) -> None:
        """Wait until the newest frames of all variants are shown, and rest."""

        def is_shown() -> bool:
            frames = [(variant.frame, variant.session.frame) for variant in self.page.variants]
            return all(shown is newest and not newest.report["running"] for shown, newest in frames)

        for variant in self.page.variants:
            variant.session.wait_until_rest(SAFETY)
        self.until(is_shown)

    def reset(self) -> None:
        """Return to the plain weave at its own size; the fabric moves there from its present state."""
        if not isinstance(self.app.page, SwatchPage):
            self.do(self.app.open_page, "Swatch")
        self.set("Compare two variants", False)
        self.choose("plain")
        self.do(self.page.change, PLAIN.design)
        self.set("Copies across", PLAIN.look.columns)
        self.set("Iterations per frame", PLAIN.iterations)
        self.press("Yarns", "Start")
        self.front.notices.clear()
        self.front.downloads.clear()

    def copies(self) -> list[Copies]:
        return [drawing for drawing in self.front.scene.drawings.values() if isinstance(drawing, Copies)]

    def text(self) -> str:
        return self.front.controls.text_shown()


@pytest.fixture(scope="module")
def shared_rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SwatchRig]:
    """One page for the tests of the file, on a project that keeps a plain weave."""
    folder = tmp_path_factory.mktemp("swatch") / "project"
    project = Project.create(folder)
    project.set_settings("Swatch", state_table(PLAIN))
    project.close()
    opened = SwatchRig(folder)
    yield opened
    opened.app.close()


@pytest.fixture
def rig(shared_rig: SwatchRig) -> SwatchRig:
    """The page with its plain weave, whatever the test before has left."""
    shared_rig.reset()
    return shared_rig


def rest_of(design: SwatchDesign) -> sm.YarnSet:
    """The relaxed yarns of a design, made by the library alone."""
    with sm.SwatchSession("stockinette", stopped=True, quality="draft") as session:
        session.set(**design.settings())
        session.start()
        return session.wait_until_rest(SAFETY).yarns


def test_a_kept_swatch_relaxes_to_what_the_library_gives(shared_rig):
    shared_rig.rest()
    frame = shared_rig.page.variant.frame
    assert np.array_equal(frame.yarns.points, rest_of(PLAIN.design).points)
    assert f"{frame.measures.gauge.stitches:.1f}" in shared_rig.text()
    assert "At rest after" in shared_rig.text()
    assert {len(drawing.offsets) for drawing in shared_rig.copies()} == {PLAIN.look.columns * PLAIN.look.rows}
    assert not shared_rig.front.notices


def test_another_pattern_is_shown_and_kept_and_dials_follow_its_kind(rig):
    def shown() -> set[str]:
        return {control.label for control in rig.front.controls.made if control.visible}

    rig.choose("garter")
    assert {"Loop length [cm]", "Tightness"} <= shown() and not {"Warp length", "Floats"} & shown()
    rig.choose("twill-2x1")
    assert {"Warp length", "Weft length", "Warp spacing [cm]"} <= shown() and "Loop length [cm]" not in shown()
    rig.rest()
    assert np.array_equal(rig.page.variant.frame.yarns.points, rest_of(rig.page.state.design).points)
    assert len(rig.copies()) == len(np.unique(rig.page.variant.frame.yarns.colour))
    assert rig.app.project.settings("Swatch") == state_table(rig.page.state)
    rig.choose("slip-stitch-honeycomb")
    assert {"Floats", "Held loops"} <= shown() and "Warp length" not in shown()


def test_a_dial_moves_the_fabric_from_its_present_state_and_is_set_back(rig):
    rig.rest()
    before = rig.page.variant.frame
    rig.set("Tightness", 1.3)
    rig.rest()
    after = rig.page.variant.frame
    assert after.number > before.number and after.report["at_rest"]
    assert after.size[1] < before.size[1]
    rig.press("Set all dials back")
    assert rig.page.state.design.dials == PLAIN.design.dials
    assert rig.front.controls.find("Tightness").value == 1.0


def test_a_fabric_at_rest_says_which_error_to_expect(rig):
    rig.rest()
    assert "Validated: the crimp is off measured ones by 0.7 %" in rig.text()
    rig.choose("garter")
    rig.rest()
    assert "Not validated" in rig.text() and "The size of garter with loops of" in rig.text()
    rig.set("Hold the width", True)
    rig.rest()
    assert "alidated" not in rig.text()


def test_a_held_width_is_that_of_the_fabric_until_another_is_typed_and_an_impossible_one_is_said(rig):
    rig.rest()
    width = rig.page.variant.frame.size[0]
    rig.set("Hold the width", True)
    # The number is rounded to a tenth of a millimetre, as it is shown.
    held = rig.page.state.design.dials.width
    assert held == pytest.approx(width, abs=0.005)
    rig.set("Width of a repeat [cm]", 1.05 * held)
    rig.rest()
    assert rig.page.variant.frame.size[0] == pytest.approx(1.05 * held, abs=1e-4)  # float32 periods on the device
    before = rig.page.variant.frame.yarns
    rig.set("Width of a repeat [cm]", 900.0)
    rig.until(lambda: rig.page.variant.frame.error is not None)
    assert "period width: got 900 cm; expected" in rig.notices()
    assert "Not possible" in rig.text()
    assert np.array_equal(rig.page.variant.frame.yarns.points, before.points)
    rig.set("Hold the width", False)
    assert rig.page.state.design.dials.width is None
    rig.until(lambda: rig.page.variant.frame.error is None)
    assert "Not possible" not in rig.text()


def test_a_stopped_fabric_steps_by_the_iterations_of_a_frame(rig):
    rig.until(lambda: rig.page.variant.frame is not None and rig.page.variant.frame.report["iteration"] > 0)
    rig.press("Yarns", "Stop")
    rig.press("Yarns", "From the start")
    rig.until(lambda: rig.page.variant.frame.report["iteration"] == 0)
    rig.set("Iterations per frame", 5)
    rig.press("Yarns", "Step")
    rig.until(lambda: rig.page.variant.frame.report["iteration"] == 5)
    assert "Stopped at iteration 5" in rig.text()
    rig.press("One step of the yarns")
    rig.until(lambda: rig.page.variant.frame.report["iteration"] == 10)
    rig.press("Start or stop the yarns")
    rig.until(lambda: rig.page.variant.frame.report["iteration"] > 10)


def test_two_variants_lie_beside_each_other_and_one_is_changed(rig):
    rig.rest()
    rig.set("Compare two variants", True)
    rig.set("Tightness", 1.1)
    rig.rest()
    first, second = rig.page.variants
    assert first.frame.report["gamma"] == 1.0 and second.frame.report["gamma"] == pytest.approx(1.1)
    ends = [np.concatenate([part.points[:, None] + part.offsets for part in [drawing]])[..., 0]
            for drawing in rig.copies()]  # fmt: skip
    assert ends[0].max() < 0.0 < ends[1].min()
    assert {label.texts for label in rig.front.scene.drawings.values() if isinstance(label, Labels)} == {("A", "B")}
    rig.set("Chart and dials of", "A")
    assert rig.front.controls.find("Tightness").value == 1.0
    rig.choose("twill-2x1")
    assert rig.page.state.designs[1].pattern.name != rig.page.state.designs[0].pattern.name
    rig.set("Compare two variants", False)
    rig.rest()
    assert len(rig.page.variants) == 1
    assert len(rig.copies()) == len(np.unique(rig.page.variant.frame.yarns.colour))
    assert rig.page.state.design.pattern == sm.read_weave("twill-2x1")


def test_colours_by_stitch_and_copies_are_only_a_matter_of_drawing(rig):
    rig.choose("garter")
    rig.until(lambda: rig.page.variant.frame is not None and rig.page.variant.frame.fabric is not None)
    rig.press("Yarns", "Stop")
    rig.until(lambda: not rig.page.variant.frame.report["running"])
    number = rig.page.variant.frame.number
    rig.set("Colour by", "stitch")
    assert len(rig.copies()) == 2  # knit and purl
    assert "knit" in rig.text() and "purl" in rig.text()
    rig.set("Copies across", 5)
    assert {len(drawing.offsets) for drawing in rig.copies()} == {5 * rig.page.state.look.rows}
    assert rig.page.variant.frame.number == number
    rig.set("Colour by", "yarn")
    assert len(rig.copies()) == 1


def test_a_chart_that_is_too_large_to_relax_live_is_refused_in_words(rig):
    large = sm.parse_pattern("\n".join(f"round {row}: k60" for row in range(1, 61)))
    rig.do(rig.page.change, SwatchDesign(large).turned(columns=8))
    assert "got a repeat of 28,800 stitches; expected at most 10,000" in rig.text()
    rig.choose("twill-2x1")
    rig.rest()
    assert "At rest" in rig.text()


def test_a_project_is_reopened_with_its_swatch(tmp_path):
    first = SwatchRig(tmp_path / "project")
    assert first.page.state == first_state()
    first.choose("twill-2x1")
    first.set("Warp length", 1.1)
    first.set("Copies across", 4)
    kept = state_table(first.page.state)
    first.app.close()
    again = SwatchRig(tmp_path / "project")
    assert state_table(again.page.state) == kept
    assert again.front.controls.find("Warp length").value == 1.1
    again.app.close()


def test_a_damaged_swatch_of_a_project_gives_a_new_one_and_a_notice(tmp_path):
    project = Project.open_or_create(tmp_path / "project")
    project.set_settings("Swatch", {"designs": [{"kind": "knit"}]})
    project.close()
    rig = SwatchRig(tmp_path / "project")
    assert "the saved swatch cannot be shown" in rig.notices()
    assert rig.page.state == first_state()
    rig.app.close()


def test_leaving_the_page_ends_its_threads_and_coming_back_shows_the_fabric(rig):
    rig.set("Tightness", 1.2)
    session = rig.page.variant.session
    rig.do(rig.app.open_page, "Project")
    rig.do(rig.app.open_page, "Swatch")
    with pytest.raises(ParameterError, match="closed"):
        session.start()
    rig.until(lambda: rig.page.variant.frame is not None and rig.page.variant.frame.report["gamma"] > 1.1)


def test_yarns_and_textures_are_sent_as_the_library_writes_them(rig, tmp_path):
    rig.rest()
    look = rig.page.state.look
    for name, tiles in (("one repeat, exact (.h5)", None), ("piece, curves (.usda)", (look.columns, look.rows))):
        rig.set("Yarns as", name)
        rig.press("Download the yarns")
        file, content = rig.front.downloads[-1]
        own = tmp_path / file
        sm.write_yarns(own, rig.page.variant.frame.yarns, tiles=tiles)
        assert own.read_bytes() == content
        assert file.startswith("plain-weave") and (rig.app.project.folder / "exports" / file).read_bytes() == content
    rig.set("Width of the textures [pixels]", 32)
    rig.press("Download the textures")
    rig.until(lambda: len(rig.front.downloads) == 3)
    name, content = rig.front.downloads[-1]
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert {"colour.png", "height.png", "normal.png", "textures.json"} <= set(archive.namelist())
    assert name.endswith(".zip")


def test_a_stretch_test_gives_the_curve_of_the_library(rig, monkeypatch):
    monkeypatch.setattr(stretch_panel, "STEPS", 2)
    rig.set("Strain [%]", 5)
    rig.press("Run the stretch test")
    rig.until(lambda: not rig.app.tasks.running)
    plot = next(control.figure for control in rig.front.controls.made if control.kind == "plot")
    design = rig.page.state.design
    options = {name: value for name, value in design.options().items() if name != "period"}
    curve = sm.stretch_test(design.pattern, sm.StretchPath(course=(0.0, 0.05), steps=2), quality="draft", **options)
    np.testing.assert_array_equal(plot.data[0].x, 100.0 * curve.column("strain"))
    np.testing.assert_array_equal(plot.data[0].y, 1e-3 * curve.tension)
    assert "Not validated" in rig.text() and "The tension of plain weave along the courses" in rig.text()
    rig.press("Download the curve (CSV)")
    assert rig.front.downloads[-1][0] == "plain-weave-A-course.csv"


def test_a_stretch_test_is_stopped_by_its_button_and_by_leaving_the_page(rig):
    rig.choose("honeycomb")
    rig.press("Run the stretch test")
    rig.press("Stop the test")
    rig.until(lambda: not rig.app.tasks.running)
    assert not rig.front.controls.find("Run the stretch test").disabled
    rig.press("Run the stretch test")
    rig.do(rig.app.open_page, "Project")
    rig.until(lambda: not rig.app.tasks.running)
    assert not rig.front.notices


def test_snaps_are_said_in_words():
    points = tuple(StretchPoint(0.1 * n, 1.0, 1.0, 1.0, 0.0, 5.0, 0.0, 0.0, True, 1 + (n > 1)) for n in range(4))
    curve = StretchCurve("course", "free", None, points, ())
    said = "etween 10 % and 20 % the fabric snapped from branch 1 to branch 2"
    assert [text.partition(",")[0] for text in snap_texts([("A", curve)])] == [f"B{said}"]
    assert snap_texts([("A", curve), ("B", curve)])[1].startswith(f"B: b{said}")


def test_a_yarn_sets_thickness_weight_and_loops(rig):
    rig.choose("garter")
    rig.set("Yarn", "worsted")
    dials, yarn = rig.page.state.design.dials, Yarn.named("worsted")
    found = dials.yarn_radius, dials.loop_length, dials.mass / 100.0
    # dials have 3 digits
    assert found == pytest.approx((yarn.core_radius, yarn.gauge.loop_length, yarn.grams_per_metre), abs=0.0005)
    rig.set("Loop length [cm]", 2.0)
    assert rig.front.controls.find("Yarn").value == OWN_YARN
    rig.choose("plain")  # a weave has no loops
    rig.set("Yarn", "lace")
    assert rig.front.controls.find("Yarn").value == "lace"


def test_a_size_that_is_not_held_is_hidden_at_every_moment(monkeypatch):
    """Each frame of a relaxation shows the dials again; a page that drew between two values would show a wrong one."""
    controls, seen = NullControls(), []
    panel = DialPanel(controls, SwatchDesign(sm.read_pattern("rib2x2")), lambda design: None)
    dial = controls._made[[one.label for one in controls._made].index("Width of a repeat [cm]")]
    plain = NullControl.__setattr__

    def watched(control: NullControl, name: str, value: object) -> None:
        plain(control, name, value)
        if control is dial and name == "visible":
            seen.append(value)

    monkeypatch.setattr(NullControl, "__setattr__", watched)
    panel.show(SwatchDesign(sm.read_pattern("rib2x2")))
    assert seen and not any(seen)
