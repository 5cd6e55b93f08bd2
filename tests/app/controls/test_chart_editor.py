# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The chart editor without a browser: gestures, buttons and text change one chart, and each change can be undone."""

from __future__ import annotations

import base64
import html
import json
import re

import numpy as np
import pytest

from stitchmesh.app.controls import chart_board
from stitchmesh.app.controls.chart_editor import ChartEditor
from stitchmesh.errors import StitchMeshError
from stitchmesh.patterns import parse_pattern, read_pattern
from stitchmesh.patterns.charts.knit_chart import knit_chart
from stitchmesh.periodic.weave.library import read_weave
from stitchmesh.periodic.weave.weave_chart import WeaveChart
from tests.app.null_front import NullControls


class Desk:
    """An editor on controls without a panel, with what it gave."""

    def __init__(self, source, text=""):
        self.controls, self.given, self.texts, self.files = NullControls(), [], [], {}
        self.editor = ChartEditor(
            self.controls, source, self.given.append, text=text,
            download=self.files.__setitem__, edited=self.texts.append,
        )  # fmt: skip

    def gesture(self, action, **values):
        self.editor.act(action, json.dumps(values))

    def stroke(self, *places, word=None, yarn=None, **values):
        self.gesture("stroke", places=places, word=word, yarn=yarn, **values)

    def select(self, row, column, row_end, column_end):
        self.gesture("select", row=row, column=column, row_end=row_end, column_end=column_end)

    def data(self, name):
        """What the browser reads from the hidden element with this name."""
        for control in self.controls.made:
            found = re.search(rf'data-chart-{name}="[^"]*" data-json="([^"]*)"', control.content)
            if found:
                return json.loads(html.unescape(found[1]))
        raise AssertionError(name)

    def rows(self):
        chart = self.editor.chart
        rows, columns = map(range, chart.shape)
        return [" ".join(chart.word_at(row, column) for column in columns) for row in rows]


@pytest.fixture
def rib():
    return Desk(read_pattern("rib2x2"))


def test_a_stroke_paints_and_gives_the_pattern(rib):
    rib.stroke([0, 2], [1, 2], word="p")
    assert rib.rows() == ["p p p k"] * 2
    assert rib.given == [rib.editor.source]
    assert rib.editor.source.rows == parse_pattern("chart letters:\npppk\npppk").rows
    assert parse_pattern(rib.editor.text) == rib.editor.source
    assert rib.texts == [rib.editor.text]


def test_the_parts_of_a_stroke_are_one_step_and_what_changes_nothing_is_none(rib):
    rib.stroke([0, 2], word="p")
    rib.stroke([0, 3], word="p", goes_on=True)
    rib.stroke([0, 0], word="p")
    rib.stroke([1, 2], word="p", goes_on=True)  # The first part of this stroke changed nothing.
    rib.editor.undo()
    assert rib.rows() == ["p p p p", "p p k k"]
    rib.editor.undo()
    assert rib.rows() == ["p p k k"] * 2
    with pytest.raises(StitchMeshError, match="no step to undo"):
        rib.editor.undo()
    rib.editor.redo()
    assert rib.rows()[0] == "p p p p"


def test_an_invalid_chart_gives_nothing_and_says_why_at_its_row(rib):
    rib.stroke([1, 0], word="k2tog")
    assert not rib.given
    assert rib.editor.source == read_pattern("rib2x2")
    assert "row 2: its tile is worked on 5 loops, but the row below leaves 4" in rib.editor.fault
    assert rib.data("changes")["fault_row"] == 1
    line = rib.data("words")["fault_line"]
    assert rib.editor.text.splitlines()[line - 1] == "/pkk"
    assert "role=\"alert\"" in rib.controls.text_shown()
    rib.stroke([1, 0], word="p")
    assert not rib.editor.fault
    assert "role=\"alert\"" not in rib.controls.text_shown()


def test_text_changes_the_grid_and_keeps_its_form(rib):
    text = "row 1 RS: k p k p\nrow 2 WS: k4  # plain\n"
    rib.gesture("text", text=text)
    assert rib.rows() == ["p k p k", "p p p p"]
    assert rib.editor.text == text
    assert rib.given[-1].rows == parse_pattern(text).rows
    rib.stroke([1, 0], word="k")
    assert parse_pattern(rib.editor.text).rows == rib.editor.source.rows
    rib.editor.undo()
    assert rib.editor.text == text


def test_an_unreadable_text_stays_with_its_line_and_undo_drops_it(rib):
    good = rib.editor.text
    rib.gesture("text", text=good.replace("ppkk\nppkk", "ppkk\nppqk"))
    assert "got 'q'" in rib.editor.fault
    words = rib.data("words")
    assert "ppqk" in words["text"]
    assert words["text"].splitlines()[words["fault_line"] - 1] == "ppqk"
    assert rib.rows() == ["p p k k"] * 2
    rib.editor.undo()
    assert (rib.editor.text, rib.editor.fault) == (good, "")


def test_an_editor_comes_back_from_its_text_even_if_it_cannot_be_read(rib):
    rib.stroke([0, 2], word="p", yarn=3)
    again = Desk(rib.editor.text)
    assert (again.rows(), again.editor.text) == (rib.rows(), rib.editor.text)
    rib.gesture("text", text="chart letters:\nkq")
    again = Desk(rib.editor.source, rib.editor.text)
    assert (again.editor.text, again.editor.fault) == (rib.editor.text, rib.editor.fault)
    assert again.editor.source == rib.editor.source
    assert again.rows() == rib.rows()
    again.editor.undo()
    assert not again.editor.fault


def test_digits_of_a_weave_come_back_as_a_weave():
    desk = Desk(read_weave("plain"))
    desk.gesture("text", text="0110\n1001\n")
    again = Desk(desk.editor.source, desk.editor.text)
    assert again.editor.source == desk.editor.source
    assert isinstance(again.editor.chart, WeaveChart)
    with pytest.raises(StitchMeshError, match="no step to undo"):
        again.editor.undo()


def test_the_buttons_of_the_selection(rib):
    rib.stroke([0, 0], word="yo")
    rib.select(0, 0, 1, 2)
    rib.controls.press("Mirror", "Mirror ↔")
    assert rib.rows() == ["p yo k k", "p p k k"]
    rib.controls.press("Selection", "Copy")
    rib.select(1, 2, 2, 4)
    rib.controls.press("Selection", "Paste")
    assert rib.rows()[1] == "p p p yo"
    rib.controls.press("Selection", "Clear")
    assert rib.rows()[1] == "p p k k"
    rib.select(0, 0, 2, 2)
    rib.controls.press("Repeat", "Fill chart")
    assert rib.rows() == ["p yo p yo", "p p p p"]
    rib.controls.press("Repeat", "Repeat box")
    assert (rib.editor.chart.left, rib.editor.chart.right) == (0, 2)
    rib.controls.press("Repeat", "Crop")
    assert rib.rows() == ["p yo", "p p"]
    for _ in range(3):
        rib.controls.act("undo")
    assert rib.rows()[0] == "p yo k k"


def test_a_selection_moves_and_is_copied(rib):
    rib.select(0, 0, 2, 1)
    rib.gesture("move", rows=0, columns=2)
    assert rib.rows() == ["k p p k"] * 2
    assert rib.data("changes")["selection"] == [0, 2, 2, 3]
    rib.gesture("move", rows=0, columns=1, keep=True)
    assert rib.rows() == ["k p p p"] * 2


def test_size_rows_and_columns(rib):
    rib.controls.set("Rows", 4)
    rib.controls.set("Columns", 6)
    rib.controls.press("Resize")
    assert rib.editor.chart.shape == (4, 6)
    rib.controls.press("Insert", "Add row")
    rib.controls.press("Insert", "Add column")
    assert rib.editor.chart.shape == (5, 7)
    rib.select(0, 0, 3, 2)
    rib.controls.press("Remove", "Drop rows")
    assert rib.editor.chart.shape == (2, 7)
    assert rib.controls.find("Rows").value == 2


def test_a_refused_size_leaves_the_chart(rib):
    for action in (("Resize",), ("New chart", "Weave")):
        rib.controls.find("Columns").value = 501
        with pytest.raises(StitchMeshError, match="expected 1 to 500 rows"):
            rib.controls.press(*action)
        assert rib.editor.chart.shape == (2, 4)
    assert rib.controls.find("Columns").value == 4


def test_a_new_chart_is_a_step(rib):
    rib.controls.set("Rows", 4)
    rib.controls.set("Columns", 6)
    rib.controls.press("New chart", "Weave")
    assert rib.given[-1].matrix == ((0, 1, 0, 1, 0, 1), (1, 0, 1, 0, 1, 0)) * 2
    rib.controls.press("New chart", "Colours")
    assert rib.rows() == ["k k k k k k"] * 4
    assert (rib.data("changes")["word"], rib.data("changes")["yarn"]) == (None, 1)
    rib.controls.press("New chart", "Knit")
    assert rib.data("changes")["word"] == "p"
    for _ in range(3):
        rib.controls.act("undo")
    assert rib.rows() == ["p p k k"] * 2


def test_the_steps_of_a_large_chart_hold_a_bounded_number_of_squares(rib, monkeypatch):
    monkeypatch.setattr(chart_board, "MOST_SQUARES", 15 * 8)
    for place in range(20):
        rib.stroke([0, 0], word=("yo", "p")[place % 2])
    for _ in range(15):
        rib.editor.undo()
    with pytest.raises(StitchMeshError, match="no step to undo"):
        rib.editor.undo()


def test_the_brush_is_chosen_by_buttons(rib):
    rib.controls.act("stitch", "yo")
    assert rib.data("changes")["word"] == "yo"
    rib.controls.act("yarn", "1")
    assert (rib.data("changes")["word"], rib.data("changes")["yarn"]) == ("yo", 1)
    rib.controls.act("stitch", "yo")  # once more: the yarn alone
    assert (rib.data("changes")["word"], rib.data("changes")["yarn"]) == (None, 1)
    rib.controls.act("stitch", "k")
    rib.controls.act("yarn", "1")
    assert (rib.data("changes")["word"], rib.data("changes")["yarn"]) == ("k", None)
    rib.controls.act("tool", "Fill")
    assert rib.data("changes")["tool"] == "Fill"
    rib.gesture("pick", row=0, column=0)
    assert rib.data("changes")["word"] == "p"


def test_words_and_colours_are_added_to_those_that_can_be_painted(rib):
    for typed in ("k", "k3", "k3t", "k3tog"):
        rib.controls.set("Other stitch", typed)
    assert rib.data("changes")["word"] == "k3tog"
    assert "k3tog" in rib.data("base")["words"]
    rib.controls.act("stitch", "k3tog")
    rib.controls.act("add-yarn")
    rib.controls.set("Yarn colour", "#102030")
    rib.stroke([0, 0], word="p", yarn=2)
    assert rib.editor.source.palette[2] == (16, 32, 48)
    assert rib.data("base")["colours"][2] == "#102030"


def test_a_chart_of_colours_is_painted_with_yarns_at_first():
    desk = Desk(read_pattern("peerie"))
    changes = desk.data("changes")
    assert (changes["word"], changes["yarn"]) == (None, 1)
    desk.gesture("fill", row=0, column=0, word=None, yarn=1)
    assert (desk.editor.chart.yarns == 1).sum() > (knit_chart(read_pattern("peerie")).yarns == 1).sum()


def test_the_changes_and_the_base_give_the_chart(rib):
    for place, word in (([0, 0], "yo"), ([1, 3], "p"), ([0, 0], "k")):
        rib.stroke(place, word=word)
        base, changes = rib.data("base"), rib.data("changes")
        assert base["version"] == changes["version"]
        squares = np.frombuffer(base64.b64decode(base["squares"]), dtype="<u2").copy()
        for index, number, _ in zip(*[iter(changes["squares"])] * 3, strict=True):
            squares[index] = number
        words = [base["words"][number] for number in squares]
        assert words == " ".join(rib.rows()).split()


def test_the_last_message_of_each_browser_is_confirmed(rib):
    rib.stroke([0, 0], word="yo", browser="a", number=4)
    rib.gesture("text", text="kp", browser="b", number=9)
    assert rib.data("changes")["read"] == {"a": 4, "b": 9}


def test_no_two_editors_have_one_name_in_the_browser():
    """A window of a server that ended never mixes its strokes into another chart."""
    names = {re.search('data-chart="([^"]+)"', Desk(read_pattern("seed")).controls.text_shown())[1] for _ in range(3)}
    assert len(names) == 3


MISUNDERSTOOD = [
    ("stroke", "no json"), ("stroke", "[]"), ("stroke", '{"places": 3}'), ("stroke", '{"places": [[0]]}'),
    ("stroke", '{"places": [["a", 0]], "word": "k"}'), ("stroke", '{"places": [[0, 0]], "word": "q"}'),
    ("stroke", '{"places": [[0, 0]], "yarn": 999999}'), ("fill", '{"row": "1e9"}'),
    ("fill", '{"row": 99, "column": 0}'),
    ("select", '{"row": 5, "row_end": 2, "column": 0, "column_end": 1}'), ("box", "{}"), ("pick", "{}"),
    ("text", json.dumps({"text": "k" * 1_000_001})),
    ("yarn", "x"), ("yarn", "256"), ("layer", "7x"), ("move", '{"rows": 1, "columns": 1}'),
    ("paste", ""), ("copy", ""),
]  # fmt: skip


def test_what_cannot_be_understood_is_refused_and_changes_nothing(rib):
    before = rib.editor.text
    for action, value in MISUNDERSTOOD:
        with pytest.raises(StitchMeshError):
            rib.editor.act(action, value)
        assert rib.editor.text == before


def test_a_weave_is_painted_dyed_and_undone_and_one_that_falls_apart_is_said_at_its_weft():
    desk = Desk(read_weave("twill-3x2"))
    weave = desk.editor.source
    desk.stroke([0, 0], [0, 0], word="0")
    assert isinstance(desk.editor.chart, WeaveChart)
    assert desk.editor.chart.squares[0, 0] == 0
    desk.editor.undo()
    desk.controls.act("yarn", "1")
    desk.gesture("thread", kind="warps", thread=2)
    assert [thread.colour for thread in desk.editor.source.warps] == [0, 0, 1, 0, 0]
    desk.editor.undo()
    assert desk.editor.source == weave
    desk = Desk(read_weave("plain"))
    desk.stroke([0, 0], [0, 1], word="1")
    assert "falls apart" in desk.editor.fault
    assert desk.data("changes")["fault_row"] == 0
    assert not desk.given


def test_the_layers_of_a_double_weave_are_painted_one_by_one():
    desk = Desk(read_weave("double-plain-stitched"))
    desk.controls.act("layer", "1")
    assert (desk.data("base")["rows"], desk.data("base")["columns"]) == (4, 4)
    square = int(desk.editor.chart.layer_chart(1).squares[0, 0])
    desk.stroke([0, 0], word=str(1 - square))
    assert desk.editor.chart.layer_chart(1).squares[0, 0] == 1 - square
    desk.controls.set("Rows", 5)
    with pytest.raises(StitchMeshError, match="one layer keeps its size"):
        desk.controls.press("Resize")
    desk.controls.act("layer", "")
    assert desk.data("base")["rows"] == 8


def test_another_source_is_a_step_and_brings_its_brush(rib):
    rib.editor.show(read_weave("plain"))
    assert rib.data("changes")["word"] == "0"
    assert rib.given == [read_weave("plain")]
    rib.editor.undo()
    assert rib.data("changes")["word"] == "p"
    assert rib.given[-1] == read_pattern("rib2x2")


def test_files_come_in_and_go_out(rib):
    rib.controls.press("Save the text")
    rib.controls.press("Save the image")
    rib.controls.press("Save the picture")
    assert set(rib.files) == {"2-x-2-rib.knit", "2-x-2-rib.leaf.png", "2-x-2-rib.chart.png"}
    rib.editor.show(read_weave("plain"))
    for name, content in rib.files.items():
        rib.controls.send("Open a chart", name, content)
        assert rib.editor.source.rows == read_pattern("rib2x2").rows
    before = rib.editor.text
    with pytest.raises(StitchMeshError, match="is not a whole PNG"):
        rib.controls.send("Open a chart", "a.png", b"no picture")
    assert rib.editor.text == before
