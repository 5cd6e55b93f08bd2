# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The rig of the browser tests reaches every kind of control, and notices faults."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import numpy as np
import pytest

from stitchmesh.app.pages import all_pages
from stitchmesh.app.pages.page import Page
from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import ParameterError
from stitchmesh.markup import markup
from tests.gallery import tube
from tests.nightly import at_night


class Sampler(Page):
    """A page with one control of each kind, which remembers what it was given."""

    name: ClassVar[str] = "Project"
    hint: ClassVar[str] = "Try everything."

    def build(self) -> None:
        self.given: list[Any] = []
        controls, give = self.app.controls, self.given.append
        controls.button("Go", "Starts.", lambda: give("go"), main=True)
        self.width = controls.number("Width", "A width.", 0.8, give, least=0.1, most=5.0, step=0.1)
        controls.toggle("Arrows", "Whether arrows are shown.", False, give)
        controls.choice("Kind", "A kind.", ["plain", "purl"], "plain", give)
        controls.text("Name", "A name.", "abc", give)
        self.gamma = controls.slider("Gamma", "A dial.", 0.5, give, least=0.0, most=1.0, step=0.1)
        self.pixels = controls.number("Pixels", "A whole number.", 1600, give, least=64, most=4096, step=1)
        self.side = controls.buttons("Side", "A side.", ["Left", "Right"], give)
        controls.upload("Mesh", "A file.", [".obj"], lambda name, content: give((name, len(content))))
        controls.button("Save", "Sends a file.", lambda: self.app.download("a.txt", b"content"))
        controls.button("Fail", "Raises an error.", self._fail)
        turn = markup('<button data-action="turn" data-value="7">Turn</button>')
        controls.html(turn, lambda *words: give(words))
        controls.key("Undo", "Undoes.", "Z", "ctrl", lambda: give("undo"))
        points = tube(12, 4).vertices
        self.app.scene.look_at(points.min(axis=0), points.max(axis=0))

    def picked(self, pick: Pick) -> None:
        self.given.append(pick)

    def _fail(self) -> None:
        raise ParameterError("width: got 0; expected a positive number")


@pytest.fixture
def sampler(monkeypatch, app_in_browser):
    monkeypatch.setitem(all_pages.PAGES, "Project", Sampler)
    return lambda **options: app_in_browser(page="Project", **options)


@pytest.fixture(scope="module")
def shared_rig(browser, tmp_path_factory):
    """One page for all tests that leave no trace in it; to load a page takes longer than most tests."""
    from tests.app.browser import rig_on

    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(all_pages.PAGES, "Project", Sampler)
        with rig_on(browser, tmp_path_factory.mktemp("sampler") / "project", page="Project") as rig:
            yield rig


@pytest.fixture
def rig(shared_rig, capfd):
    """The shared page with the values of the start, and without notices."""
    page = shared_rig.app.page

    def reset() -> bool:
        page.width.value, page.gamma.value, page.pixels.value = 0.8, 0.5, 1600
        return True

    shared_rig.call(reset)
    shared_rig.close_notices()
    shared_rig.settle()
    page.given.clear()
    yield shared_rig
    printed = capfd.readouterr().err
    assert "Traceback" not in printed, printed


def test_each_control_is_reached(rig, tmp_path):
    (tmp_path / "a.obj").write_bytes(b"12345678")
    rig.press("Go")
    rig.type("Width", 1.2)
    rig.tick("Arrows")
    rig.choose("Kind", "purl")
    rig.type("Name", "xyz")
    rig.type("Gamma", 0.7)
    rig.press("Side", "Right")
    rig.upload(tmp_path / "a.obj")
    rig.wait_for(lambda: ("a.obj", 8) in rig.app.page.given)
    rig.act("turn", "7")
    rig.key("Control+z")
    rig.settle()
    assert rig.app.page.given == [
        "go", 1.2, True, "purl", "xyz", 0.7, "Right", ("a.obj", 8), ("turn", "7"), "undo"
    ]  # fmt: skip
    assert rig.downloaded(lambda: rig.press("Save")) == ("a.txt", b"content")


def send(rig, control, *values):
    """Send values of a control from the page, whatever they are."""
    script = """([uuid, values]) => {
      for (const value of values) {
        window.__viserMutable.sendMessage({ type: "GuiUpdateMessage", uuid, updates: { value } });
      }
    }"""
    rig.browser_page.evaluate(script, [control.handle._impl.uuid, list(values)])


def test_presses_keep_their_order(rig):
    presses = ["Left", "Right", "Right"] * 100
    send(rig, rig.app.page.side, *presses)
    rig.settle()
    assert rig.app.page.given == presses


@pytest.mark.parametrize(
    "values", [("<b>1</b>", float("nan"), 5.01), *at_night(["", None, float("inf"), True, [1], -0.01])]
)
def test_what_is_no_number_or_beyond_the_bounds_is_refused(rig, values):
    for value in values:
        rig.call(setattr, rig.app.page.width, "value", 2.5)
        send(rig, rig.app.page.width, value)
        rig.wait_for(lambda: any("Width: got" in notice for notice in rig.notices()), f"a notice of {value}")
        (notice,) = rig.notices()
        assert notice.endswith("; expected 0.1 to 5") and notice.count("\n") == 1  # The first line is the title.
        rig.settle()
        assert rig.row("Width").locator("input").input_value() == "2.5" and rig.app.page.given == []
        rig.close_notices()
    rig.type("Width", 1.2)
    rig.settle()
    assert rig.app.page.given == [1.2]


@pytest.mark.nightly
def test_a_slider_refuses_the_same_values(rig):
    send(rig, rig.app.page.gamma, "hot")
    rig.wait_for_text("Gamma: got 'hot'; expected 0 to 1")
    send(rig, rig.app.page.gamma, 1.1)
    rig.wait_for_text("Gamma: got 1.1; expected 0 to 1")
    assert rig.app.page.given == [] and rig.app.page.gamma.value == 0.5


def test_a_number_is_typed_digit_by_digit_and_letters_are_none(rig):
    field = rig.row("Pixels").locator("input")
    field.select_text()
    field.press_sequentially("3x0y0", delay=100)
    rig.settle()
    assert field.input_value() == "300" and rig.app.page.given == [300] and not rig.notices()
    field.select_text()
    field.press_sequentially("letters")
    field.press("Tab")
    rig.settle()
    assert rig.app.page.given == [300] and rig.app.page.pixels.value == 300


def test_a_number_that_is_left_beyond_its_bounds_becomes_the_nearest_bound(rig):
    rig.type("Pixels", 5)
    rig.settle()
    assert rig.app.page.given == [64] and rig.app.page.pixels.value == 64


def test_only_values_are_set_by_a_page(rig):
    script = """(uuid) => window.__viserMutable.sendMessage(
      { type: "GuiUpdateMessage", uuid, updates: { update_cb: 3, removed: true } })"""
    rig.browser_page.evaluate(script, rig.app.page.width.handle._impl.uuid)
    rig.settle()
    rig.type("Width", 1.2)
    rig.settle()
    assert rig.app.page.given == [1.2] and not rig.app.page.width.removed


def test_a_click_arrives_at_the_point_where_the_scene_is_drawn(rig):
    point = np.array([0.5, 2.0, 2.9])
    rig.click_at(point)
    (pick,) = rig.app.page.given
    across = point - pick.ray_origin
    off = np.linalg.norm(np.cross(across, pick.ray_direction))
    assert off < 0.02  # A pixel is 0.01 cm wide at this distance.


def test_an_error_becomes_a_notice_and_no_fault(rig):
    rig.press("Fail")
    rig.wait_for_text("width: got 0; expected a positive number")
    assert any("expected a positive number" in notice for notice in rig.notices())


def test_a_fault_in_the_page_fails_the_test(sampler):
    with pytest.raises(AssertionError, match=re.escape("console: broken")), sampler() as rig:
        rig.browser_page.evaluate("() => console.error('broken')")


def test_a_turned_camera_stays_while_pages_show_the_same_thing_and_a_named_view_places_it(sampler):
    with sampler() as rig:
        points = tube(12, 4).vertices
        low, high = points.min(axis=0), points.max(axis=0)
        width, height = 300.0, 120.0
        rig.browser_page.mouse.move(300, 350)
        rig.browser_page.mouse.down()
        rig.browser_page.mouse.move(300 + width, 350 + height, steps=6)
        rig.browser_page.mouse.up()
        rig.wait_for(lambda: abs(front_of(rig)) < 0.9)
        turned = resting_camera(rig)
        rig.app.post(rig.app.scene.look_at, 1.01 * low, high)
        rig.settle()
        np.testing.assert_allclose(rig.app.scene.cameras()[0].position, turned, rtol=1e-6)
        rig.app.post(rig.app.scene.look_at, low, high, "front")
        rig.wait_for(lambda: front_of(rig) > 0.99)
        rig.app.post(rig.app.scene.look_at, 2.0 * low, 2.0 * high)
        rig.wait_for(lambda: np.linalg.norm(rig.app.scene.cameras()[0].position - turned) > 1.0)


def resting_camera(rig):
    """The position of the camera when it has come to rest; viser lets a turned camera swing out."""
    seen = [np.full(3, np.nan)]

    def rests():
        rig.browser_page.wait_for_timeout(300)
        seen.append(rig.app.scene.cameras()[0].position)
        return np.array_equal(seen[-1], seen[-2])

    rig.wait_for(rests)
    return seen[-1]


def front_of(rig):
    """The cosine of the angle between the front and the direction from the thing to the camera."""
    points = tube(12, 4).vertices
    away = rig.app.scene.cameras()[0].position - 0.5 * (points.min(axis=0) + points.max(axis=0))
    return float(away[2] / np.linalg.norm(away))


@pytest.mark.nightly
def test_settings_that_serve_no_user_are_hidden(app_in_browser):
    with app_in_browser(page="Project") as rig:
        rig.browser_page.locator("svg.tabler-icon-adjustments").first.click()
        rig.browser_page.get_by_text("Orbit Origin Tool").wait_for()
        rig.browser_page.get_by_text("Dev Settings").wait_for(state="hidden")
