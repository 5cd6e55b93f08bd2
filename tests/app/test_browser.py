# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The rig of the browser tests reaches every kind of control, and notices faults."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest

from stitchmesh.app.pages import all_pages
from stitchmesh.app.pages.page import Page
from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import ParameterError
from stitchmesh.markup import markup
from tests.gallery import tube


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
def rig(monkeypatch, app_in_browser):
    """A page of the browser that shows the controls."""
    monkeypatch.setitem(all_pages.PAGES, "Project", Sampler)
    with app_in_browser(page="Project") as rig:
        yield rig


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


def test_what_is_no_number_or_beyond_the_bounds_is_refused_and_the_last_good_value_is_shown_again(rig):
    rig.call(setattr, rig.app.page.width, "value", 2.5)
    send(rig, rig.app.page.width, "<b>1</b>")
    send(rig, rig.app.page.gamma, 1.1)
    rig.wait_for_text("Width: got '<b>1</b>'; expected 0.1 to 5")
    rig.wait_for_text("Gamma: got 1.1; expected 0 to 1")
    assert all(notice.count("\n") == 1 for notice in rig.notices())  # The first line is the title.
    rig.settle()
    assert rig.row("Width").locator("input").input_value() == "2.5"
    assert rig.app.page.given == [] and rig.app.page.gamma.value == 0.5
    rig.type("Width", 1.2)
    rig.settle()
    assert rig.app.page.given == [1.2]


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
    rig.type("Pixels", 5)
    rig.settle()
    assert rig.app.page.given == [300, 64] and rig.app.page.pixels.value == 64  # the nearest bound


def test_a_click_arrives_at_the_point_where_the_scene_is_drawn(rig):
    point = np.array([0.5, 2.0, 2.9])
    rig.click_at(point)
    (pick,) = rig.app.page.given
    across = point - pick.ray_origin
    off = np.linalg.norm(np.cross(across, pick.ray_direction))
    assert off < 0.02  # A pixel is 0.01 cm wide at this distance.


def test_what_a_script_of_the_page_reports_as_an_error_is_a_fault_and_a_refusal_is_none(rig):
    rig.press("Fail")
    rig.wait_for_text("width: got 0; expected a positive number")
    assert rig.faults == []
    rig.browser_page.evaluate("() => console.error('broken')")
    rig.wait_for(lambda: rig.faults, "the fault is noticed")
    assert rig.faults == ["console: broken"]
    rig.faults.clear()


def test_a_turned_camera_stays_while_pages_show_the_same_thing_and_a_named_view_places_it(rig):
    points = tube(12, 4).vertices
    low, high = points.min(axis=0), points.max(axis=0)
    rig.browser_page.mouse.move(300, 350)
    rig.browser_page.mouse.down()
    rig.browser_page.mouse.move(600, 470, steps=6)
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


def test_settings_that_serve_no_user_are_hidden(rig):
    rig.browser_page.locator("svg.tabler-icon-adjustments").first.click()
    rig.browser_page.get_by_text("Orbit Origin Tool").wait_for()
    rig.browser_page.get_by_text("Dev Settings").wait_for(state="hidden")
    rig.browser_page.locator("svg.tabler-icon-arrow-back").first.click()
