# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The chart editor in a real browser: what is painted, typed and pressed there is the chart here, in every window."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

from stitchmesh.app.controls.chart_editor import ChartEditor
from stitchmesh.app.pages import all_pages
from stitchmesh.app.pages.page import Page
from stitchmesh.patterns import parse_pattern, read_pattern
from stitchmesh.periodic.weave.library import read_weave

PLAIN = parse_pattern("chart letters:\n" + "\n".join(["k" * 12] * 10))
PLACE = """([row, column]) => {
  const chart = Object.values(stitchmeshCharts).find((each) => each.root);
  const box = chart.canvas.getBoundingClientRect(), line = chart.base.upwards ? chart.base.rows - 1 - row : row;
  return [box.left + chart.left - chart.across + (column + 0.5) * chart.cell,
          box.top + chart.top - chart.down + (line + 0.5) * chart.cell];
}"""
SHOWN = """() => {
  const chart = Object.values(stitchmeshCharts).find((each) => each.root);
  return Array.from(chart.squares, (number) => number === 65535 ? "" : chart.base.words[number]);
}"""
PENDING = "() => Object.values(stitchmeshCharts).every((chart) => chart.pending.length === 0 && chart.base !== null)"


class ChartPage(Page):
    """A page with a chart editor on the left."""

    name: ClassVar[str] = "Project"
    hint: ClassVar[str] = "Paint the chart."
    source: ClassVar[object] = PLAIN

    def build(self) -> None:
        self.given = []
        self.editor = ChartEditor(self.app.left_controls, self.source, self.given.append, download=self.app.download)


@pytest.fixture
def page_with(monkeypatch, app_in_browser):
    """A function that opens the page Project with a chart."""

    def opened(source):
        monkeypatch.setattr(ChartPage, "source", source)
        monkeypatch.setitem(all_pages.PAGES, "Project", ChartPage)
        return app_in_browser(page="Project")

    return opened


def at(window, row, column):
    return window.browser_page.evaluate(PLACE, [row, column])


def click(rig, row, column):
    rig.browser_page.mouse.click(*at(rig, row, column))


def drag(rig, *places, modifier=None):
    rig.drag_page([at(rig, *place) for place in places], modifier)
    rig.browser_page.wait_for_function(PENDING)


def settle(rig):
    rig.settle()
    rig.browser_page.wait_for_function(PENDING)


def shown(window):
    """The words on the canvas, the lowest row first."""
    return window.browser_page.evaluate(SHOWN)


def words(editor):
    chart = editor.chart
    return [
        "" if chart.squares[row, column] < 0 else chart.word_at(row, column)
        for row in range(chart.shape[0])
        for column in range(chart.shape[1])
    ]


def test_every_square_that_is_clicked_or_dragged_over_arrives(page_with):
    with page_with(PLAIN) as rig:
        editor = rig.app.page.editor
        generator, expected = np.random.default_rng(3), np.full((10, 12), "k", dtype=object)
        for row, column in {tuple(place) for place in generator.integers((10, 12), size=(6, 2)).tolist()}:
            click(rig, row, column)
            expected[row, column] = "p"
        settle(rig)
        assert words(editor) == expected.ravel().tolist() == shown(rig)
        rig.press("Undo")
        settle(rig)
        assert sum(word == "p" for word in shown(rig)) == (expected == "p").sum() - 1
        before = words(editor)
        drag(rig, (0, 0), (0, 11), (9, 11))
        assert words(editor)[:12] == ["p"] * 12
        assert words(editor)[11::12] == ["p"] * 10
        assert words(editor) == shown(rig)
        editor_given = len(rig.app.page.given)
        rig.press("Undo")
        settle(rig)
        assert words(editor) == before == shown(rig)  # a stroke is one step
        assert len(rig.app.page.given) == editor_given + 1


def test_text_and_grid_follow_one_another_and_a_fault_marks_its_line(page_with):
    with page_with(read_pattern("rib2x2")) as rig:
        editor, area = rig.app.page.editor, rig.browser_page.get_by_label("Text of the chart")
        assert area.input_value() == editor.text
        area.fill("chart letters:\nkkk\nkpk\n")
        rig.wait_for(lambda: words(editor) == ["k", "p", "k", "k", "k", "k"], "the chart follows the text")
        settle(rig)
        assert shown(rig) == words(editor)
        area.fill("chart letters:\nkkk\nkqk\n")
        rig.wait_for(lambda: "got 'q'" in editor.fault, "the fault is found")
        settle(rig)
        assert rig.browser_page.locator(".sm-lines b").inner_text() == "▶3"
        assert "line 3, column 2" in rig.browser_page.get_by_role("alert").first.inner_text()
        rig.press("Undo")
        settle(rig)
        assert area.input_value() == "chart letters:\nkkk\nkpk\n"
        click(rig, 1, 0)
        settle(rig)
        assert area.input_value() == editor.text
        assert parse_pattern(editor.text).rows == editor.source.rows


def test_the_keyboard_does_what_the_mouse_does_and_the_focus_stays_on_a_pressed_button(page_with):
    with page_with(PLAIN) as rig:
        editor, keyboard = rig.app.page.editor, rig.browser_page.keyboard
        rig.browser_page.locator("[data-chart] canvas").focus()
        for key in ("ArrowUp", "ArrowRight", "ArrowRight", "Space"):
            keyboard.press(key)
        settle(rig)
        assert editor.chart.word_at(1, 2) == "p"
        assert "row 2, column 3" in rig.browser_page.locator(".sm-status").inner_text()
        for key in ("s", "Shift+ArrowRight", "Control+c", "ArrowUp", "ArrowUp", "Enter", "Control+v"):
            keyboard.press(key)
            settle(rig)
        assert editor.chart.word_at(3, 3) == "p"
        keyboard.press("Control+z")
        settle(rig)
        assert editor.chart.word_at(3, 3) == "k"
        keyboard.press("Control+y")
        keyboard.press("Delete")
        settle(rig)
        assert editor.chart.word_at(3, 3) == "k"
        for key in ("]", "p", "Space"):
            keyboard.press(key)
            settle(rig)
        assert editor.chart.word_at(3, 3) == "yo"
        focused = "() => [document.activeElement.dataset.action, document.activeElement.dataset.value].join(' ')"
        rig.button("Paint").focus()
        for key, expected in (("Tab", "tool Fill"), ("Enter", "tool Fill"), ("Tab", "tool Box"), ("Space", "tool Box")):
            keyboard.press(key)
            settle(rig)
            assert rig.browser_page.evaluate(focused) == expected
        assert rig.button("Box").get_attribute("aria-pressed") == "true"


def test_boxes_are_selected_moved_and_filled_and_cables_are_painted_as_a_whole(page_with):
    with page_with(PLAIN) as rig:
        editor = rig.app.page.editor
        rig.act("tool", "Box")
        settle(rig)
        drag(rig, (1, 1), (2, 3))
        assert [editor.chart.word_at(1, column) for column in range(5)] == ["k", "p", "p", "p", "k"]
        rig.act("tool", "Select")
        settle(rig)
        drag(rig, (1, 1), (2, 3))
        drag(rig, (1, 2), (5, 4))
        assert [editor.chart.word_at(1, column) for column in range(5)] == ["k"] * 5
        assert [editor.chart.word_at(6, column) for column in range(3, 6)] == ["p"] * 3
        rig.act("tool", "Fill")
        rig.act("stitch", "k")
        rig.act("yarn", "1")
        settle(rig)
        click(rig, 5, 4)
        settle(rig)
        assert editor.chart.yarns.sum() == 6
        assert set(words(editor)) == {"k"}
        rig.act("tool", "Paint")
        rig.act("stitch", "c4f")
        settle(rig)
        drag(rig, (2, 1), (2, 9))
        assert words(editor)[24:36] == ["k", "c4f", "", "", "", "c4f", "", "", "", "k", "k", "k"]
        assert shown(rig) == words(editor)


@pytest.mark.nightly
def test_a_second_window_and_a_window_that_is_loaded_again_show_the_same_chart(page_with):
    with page_with(PLAIN) as rig:
        other = rig.another_window()
        drag(rig, (0, 0), (4, 4))
        expected = words(rig.app.page.editor)
        same = f"(words) => JSON.stringify(({SHOWN})()) === JSON.stringify(words)"
        other.browser_page.wait_for_function(same, arg=expected)
        other.browser_page.mouse.click(*at(other, 9, 0))
        rig.wait_for(lambda: words(rig.app.page.editor) != expected, "the click in the other window")
        settle(rig)
        assert shown(rig) == words(rig.app.page.editor)
        rig.browser_page.reload()
        rig.wait_until_ready()
        rig.browser_page.wait_for_function(PENDING)
        assert shown(rig) == words(rig.app.page.editor)
        area = rig.browser_page.get_by_label("Text of the chart")
        assert area.input_value() == rig.app.page.editor.text
        click(rig, 8, 8)
        rig.wait_for(lambda: rig.app.page.editor.chart.word_at(8, 8) == "p", "a click after loading again")
        other.close()


@pytest.mark.nightly
def test_a_page_that_is_left_in_the_middle_of_a_stroke_and_opened_again_goes_on(page_with):
    with page_with(PLAIN) as rig:
        left = rig.app.page.editor
        rig.browser_page.mouse.move(*at(rig, 0, 0))
        rig.browser_page.mouse.down()
        rig.browser_page.mouse.move(*at(rig, 0, 3), steps=3)
        rig.call(rig.app.open_page, "View")
        rig.app.post(left.act, "stroke", '{"places": [[9, 9]], "word": "p", "yarn": null}')
        rig.browser_page.mouse.up()
        rig.settle()
        assert not rig.notices()
        rig.call(rig.app.open_page, "Project")
        settle(rig)
        assert shown(rig) == words(rig.app.page.editor)
        click(rig, 5, 5)
        settle(rig)
        assert rig.app.page.editor.chart.word_at(5, 5) == "p"


def test_threads_of_a_weave_are_dyed_in_the_margins(page_with):
    with page_with(read_weave("satin-2x3")) as rig:
        editor = rig.app.page.editor
        rig.act("yarn", "1")
        settle(rig)
        left, top = at(rig, 2, 0)
        first = at(rig, 0, 0)
        rig.browser_page.mouse.click(left - 0.5 * (at(rig, 0, 1)[0] - first[0]) - 5, top)
        rig.browser_page.mouse.click(at(rig, 0, 3)[0], first[1] - 0.5 * (at(rig, 1, 0)[1] - first[1]) - 5)
        settle(rig)
        assert [thread.colour for thread in editor.source.wefts] == [0, 0, 1, 0, 0]
        assert [thread.colour for thread in editor.source.warps] == [0, 0, 0, 1, 0]
        rig.browser_page.locator("[data-chart] canvas").focus()
        for key in ("ArrowDown", "w", "e"):
            rig.browser_page.keyboard.press(key)
        settle(rig)
        assert [thread.colour for thread in editor.source.wefts] == [0, 1, 1, 0, 0]
        assert [thread.colour for thread in editor.source.warps] == [1, 0, 0, 1, 0]
