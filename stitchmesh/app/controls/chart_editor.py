# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The chart editor: a grid to paint, with its text beside it, for a knit or a weave; both show the same chart.

The browser draws the chart on a canvas and paints strokes at once (``browser/chart.js``). It sends each action of the
user, and the editor answers with the new state of the chart. The library decides what a chart allows.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from stitchmesh.app.controls.chart_board import NEW_CHARTS, open_board
from stitchmesh.app.controls.chart_html import (
    STITCHES,
    TOOLS,
    base_values,
    colour_buttons,
    data_element,
    layer_buttons,
    stitch_buttons,
    tool_buttons,
)
from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.markup import Markup, markup
from stitchmesh.mesh.palette import check_yarn_number
from stitchmesh.patterns.charts.grid import LONGEST_SIDE, Box, Brush
from stitchmesh.periodic.charts.chart_drawing import ChartDrawing, draw_chart, palette_of
from stitchmesh.periodic.charts.chart_files import (
    CHART_SUFFIXES,
    Chart,
    chart_image,
    chart_of,
    read_chart,
    write_chart,
)
from stitchmesh.periodic.charts.chart_picture import PICTURE_SUFFIX, chart_picture
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.weave.weave_chart import WeaveChart

if TYPE_CHECKING:
    from stitchmesh.app.controls.controls import Control, Controls

LONGEST_TEXT = 4 * LONGEST_SIDE * LONGEST_SIDE
"""Largest number of characters of a text."""


class ChartEditor:
    """A chart in a panel.

    A page makes an editor in ``build`` and keeps it. The event thread calls ``changed`` each time the chart becomes
    another valid pattern or weave. While the chart is invalid, ``source`` stays as it was and ``fault`` says why.

    >>> editor = ChartEditor(app.left_controls, read_pattern("rib2x2"), pattern_changed, download=app.download)
    >>> editor.show(read_weave("plain"))      # another chart, as a step that can be undone
    >>> settings["chart"] = editor.text       # what to keep in a project
    >>> editor = ChartEditor(app.left_controls, editor.source, pattern_changed, text=settings["chart"])
    """

    def __init__(
        self, controls: Controls, source: Source | str, changed: Callable[[Source], object], *,
        download: Callable[[str, bytes], object] = lambda _name, _content: None,
        edited: Callable[[str], object] = lambda _text: None, text: str = "",
        opened: Callable[[Source], object] = lambda _source: None,
    ) -> None:  # fmt: skip
        """Build the controls of an editor.

        Args:
            controls: the place of the editor.
            source: a pattern, a weave, or the text of one.
            changed: takes each new valid pattern or weave.
            download: takes the name and the content of a file for the user, such as ``app.download``.
            edited: takes the text after every change, valid or not, such as a function that saves it.
            text: a text that ``text`` returned, readable or not; if it is unreadable, ``source`` is the last valid
                pattern.
            opened: takes each pattern or weave that the user opens from a file.

        Raises:
            StitchMeshError: the chart of ``source`` is larger than 500 x 500, or its text cannot be read.
        """
        self._board = open_board(source)
        if text:
            self._board.restore(text)
        self._changed, self._edited, self._download, self._opened = changed, edited, download, opened
        self._told, self._told_text = self._board.source, self._board.text
        self._name = f"chart-{secrets.token_hex(6)}"  # unlike names of an earlier server, whose page may be open
        self._tool = "Paint"
        self._words: tuple[str, ...] = STITCHES
        self._yarn_count = 2
        self._base: ChartDrawing | None = None
        self._version, self._read = 0, dict[str, int]()
        self._build(controls)
        self._show()

    @property
    def source(self) -> Source | None:
        """The pattern or weave of the last valid state; None if there was none."""
        return self._board.source

    @property
    def chart(self) -> Chart:
        """The present chart, valid or not."""
        return self._board.chart

    @property
    def text(self) -> str:
        """The text beside the grid, from which another editor can be made."""
        return self._board.text

    @property
    def fault(self) -> str:
        """Why the present chart describes no fabric; empty if it does."""
        return self._board.fault

    def show(self, source: Source) -> None:
        """Show another pattern or weave, as a step that can be undone; calls ``changed``.

        Raises:
            ParameterError: the chart is larger than 500 x 500.
        """
        self._do(self._board.show, write_chart(chart_of(source)))

    def undo(self) -> None:
        """Undo the last step.

        Raises:
            ParameterError: there is none.
        """
        self._do(self._board.undo)

    def redo(self) -> None:
        """Make the last undone step again.

        Raises:
            ParameterError: there is none.
        """
        self._do(self._board.redo)

    # The actions of the user; ``browser/chart.js`` uses the same names.

    def act(self, action: str, value: str) -> None:
        """Do the action of an element in the browser.

        Args:
            action: the name of the action of a button, or of a gesture on the canvas such as ``stroke``.
            value: the value of the button, or the values of the gesture as JSON.

        Raises:
            StitchMeshError: the message is unreadable, or the library refuses the action; the chart stays as it is.
        """
        simple = self._simple_actions()
        if action in simple:
            self._do(simple[action])
        elif action in ("tool", "stitch", "yarn", "layer"):
            self._do(self._choose, action, value)
        else:
            self._do(self._gesture, action, _values(value))

    def _simple_actions(self) -> dict[str, Callable[[], object]]:
        board = self._board
        return {
            "undo": board.undo, "redo": board.redo, "copy": board.copy, "paste": board.paste, "cut": self._cut,
            "clear": board.clear_selection, "add-yarn": self._add_yarn,
            "previous-stitch": lambda: self._next_stitch(-1), "next-stitch": lambda: self._next_stitch(1),
        }  # fmt: skip

    def _choose(self, action: str, value: str) -> None:
        if action == "tool":
            self._tool = value if value in TOOLS else self._tool
        elif action == "stitch":
            self._board.choose_word(value)
        elif action == "yarn":
            self._board.choose_yarn(_whole(value))
        else:
            self._board.show_layer(_whole(value) if value else None)

    def _gesture(self, action: str, values: dict[str, Any]) -> None:
        """Do a gesture of the pointer or the keyboard on the canvas."""
        board = self._board
        self._confirm(values)
        if action == "stroke":
            board.paint(_pairs(values.get("places")), self._brush_of(values), merge=bool(values.get("goes_on")))
        elif action == "fill":
            row, column = _integers(values, "row", "column")
            board.fill(row, column, self._brush_of(values))
        elif action == "box":
            board.paint_box(_box(values), self._brush_of(values))
        elif action == "select":
            board.select(_box(values) if "row_end" in values else None)
        elif action == "move":
            rows, columns = _integers(values, "rows", "columns")
            board.move_selection(rows, columns, keep=bool(values.get("keep")))
        elif action == "pick":
            row, column = _integers(values, "row", "column")
            board.pick(row, column)
        elif action == "thread":
            board.dye("wefts" if values.get("kind") == "wefts" else "warps", _integers(values, "thread"))
        elif action == "text":
            board.edit_text(_short_enough(str(values.get("text", ""))))

    def _brush_of(self, values: dict[str, Any]) -> Brush:
        """Return the brush with which the browser painted; the brush of the board may have changed since."""
        word, yarn = values.get("word"), values.get("yarn")
        return Brush(None if word is None else str(word), None if yarn is None else check_yarn_number(_whole(yarn)))

    def _confirm(self, values: dict[str, Any]) -> None:
        """Remember the last message of a browser, so that the answer confirms it."""
        if "browser" in values:
            self._read.pop(str(values["browser"]), None)
            self._read[str(values["browser"])] = _whole(values.get("number", 0))
            while len(self._read) > 16:  # It remembers the last message of so many browsers.
                self._read.pop(next(iter(self._read)))

    def _cut(self) -> None:
        self._board.copy()
        self._board.clear_selection()

    def _add_yarn(self) -> None:
        count = len(palette_of(self.chart, self._yarn_count))
        self._board.choose_yarn(count)
        self._yarn_count = count + 1

    def _next_stitch(self, step: int) -> None:
        words = WeaveChart.words if isinstance(self.chart, WeaveChart) else self._words
        word = self._board.brush.word
        place = words.index(word) if word in words else 0
        self._board.choose_word(words[(place + step) % len(words)])

    def _add_word(self, word: str) -> None:
        text = word.strip().lower()
        if text:
            self._board.choose_word(text)
            self._words = tuple(dict.fromkeys((*self._words, text)))

    def _use(self, operation: str) -> None:
        """Do the operation of a button for the selection or the size."""
        board = self._board
        self._do({
            "Copy": board.copy, "Cut": self._cut, "Paste": board.paste, "Clear": board.clear_selection,
            "Mirror ↔": lambda: board.mirror(upwards=False), "Mirror ↕": lambda: board.mirror(upwards=True),
            "Fill chart": board.repeat_selection, "Repeat box": board.set_repeat, "Crop": board.crop,
            "Add row": lambda: board.insert("rows"), "Add column": lambda: board.insert("columns"),
            "Drop rows": lambda: board.remove("rows"), "Drop columns": lambda: board.remove("columns"),
        }[operation])  # fmt: skip

    def _resize(self) -> None:
        self._do(self._board.resize, int(self._rows.value), int(self._columns.value))

    def _begin(self, kind: str) -> None:
        chosen = next(known for known in NEW_CHARTS if known == kind)
        self._do(self._board.begin, chosen, int(self._rows.value), int(self._columns.value))

    def _receive(self, name: str, content: bytes) -> None:
        self._do(self._board.show, read_chart(name, content))
        if self.source is not None and not self.fault:
            self._opened(self.source)

    def _give_text(self) -> None:
        suffix = ".weave" if isinstance(self.chart, WeaveChart) else ".knit"
        self._download(_file_name(self.chart.name) + suffix, self.text.encode())

    def _give_picture(self) -> None:
        self._download(_file_name(self.chart.name) + PICTURE_SUFFIX, chart_picture(self.chart))

    def _give_image(self) -> None:
        suffix, content = chart_image(self.chart)
        self._download(_file_name(self.chart.name) + suffix, content)

    def _do(self, operation: Callable[..., object], *arguments: object) -> None:
        """Do something to the chart, show the result, even of a refusal, and tell the page about a new pattern."""
        try:
            operation(*arguments)
        finally:
            self._show()
        if self._board.text != self._told_text:
            self._told_text = self._board.text
            self._edited(self._told_text)
        source = self._board.source
        if source is not None and not self._board.fault and source != self._told:
            self._told = source
            self._changed(source)

    # The controls.

    def _build(self, controls: Controls) -> None:
        self._tools = controls.html(Markup(), self.act)
        controls.html(_canvas(self._name), self.act)
        self._data, self._changes = controls.html(Markup()), controls.html(Markup())
        self._fault = controls.html(Markup())
        self._stitches = controls.html(Markup(), self.act)
        self._yarns = controls.html(Markup(), self.act)
        self._colour = controls.colour("Yarn colour", "Colour of the chosen yarn", "#ece2ce", self._set_colour)
        self._other = controls.text(
            "Other stitch", "A word of the pattern language to paint with, such as k3tog or c8f", "", self._other_stitch
        )
        self._layers = controls.html(Markup(), self.act)
        self._build_operations(controls)
        self._build_text(controls)

    def _build_operations(self, controls: Controls) -> None:
        with controls.group("Selection and size", opened=False):
            rows: tuple[tuple[str, str, tuple[str, ...]], ...] = (
                ("Selection", "Copy, cut, paste or clear the selected box", ("Copy", "Cut", "Paste", "Clear")),
                ("Mirror", "Mirror the selection or the whole chart", ("Mirror ↔", "Mirror ↕")),
                ("Repeat", "Fill the chart with the box, let its columns repeat, or keep it alone",
                 ("Fill chart", "Repeat box", "Crop")),
                ("Insert", "Add a row or column before the selection", ("Add row", "Add column")),
                ("Remove", "Remove the rows or columns of the selection", ("Drop rows", "Drop columns")),
            )  # fmt: skip
            for label, hint, options in rows:
                controls.buttons(label, hint, options, self._use)
            self._rows = _size(controls, "Rows", self.chart.shape[0])
            self._columns = _size(controls, "Columns", self.chart.shape[1])
            controls.button("Resize", "Give the chart these numbers of rows and columns", self._resize)
            hint = "Begin a chart of these numbers of rows and columns; Undo brings the present chart back"
            controls.buttons("New chart", hint, NEW_CHARTS, self._begin)

    def _build_text(self, controls: Controls) -> None:
        with controls.group("Text and files"):
            controls.html(_text_area(self._name), self.act)
            self._words_data = controls.html(Markup())
            hint = "Read a chart from a text or an image of one pixel a stitch"
            controls.upload("Open a chart", hint, CHART_SUFFIXES, self._receive)
            controls.button("Save the text", "Download the text of the chart", self._give_text)
            controls.button("Save the image", "Download the chart as an image, one pixel a stitch", self._give_image)
            hint = "Download the chart with its symbols, to print it; it can be opened again"
            controls.button("Save the picture", hint, self._give_picture)

    def _set_colour(self, colour: str) -> None:
        self._do(self._board.set_colour, self._board.yarn, colour)

    def _other_stitch(self, word: str) -> None:
        """Take a word once it is readable; a half-typed word is no fault."""
        try:
            self._do(self._add_word, word)
        except PatternError:
            return

    def _show(self) -> None:
        """Bring all controls to the state of the board; unchanged contents are not sent again."""
        board = self._board
        self._tools.content = tool_buttons(self._tool, can_undo=board.can_undo, can_redo=bool(board.history.future))
        self._stitches.content = stitch_buttons(self.chart, self._words, board.brush.word or "")
        self._yarns.content = colour_buttons(self.chart, self._yarn_count, board.painted_yarn)
        self._colour.value = palette_of(self.chart, max(self._yarn_count, board.yarn + 1))[board.yarn]
        self._rows.value, self._columns.value = self.chart.shape
        self._other.visible = not isinstance(self.chart, WeaveChart)
        self._layers.content = layer_buttons(board.layers(), board.layer)
        self._show_data()
        self._fault.content = _fault_message(board.fault)

    def _show_data(self) -> None:
        """Send the changes of the drawing since it was sent as a whole, or the whole if the changes are too many."""
        board = self._board
        drawing = draw_chart(board.view, self._words, max(self._yarn_count, board.yarn + 1))
        changes = None if self._base is None else drawing.changes_from(self._base)
        if changes is None:
            self._base, changes = drawing, []
            self._version += 1
            self._data.content = data_element("base", self._name, base_values(drawing, self._version))
        self._changes.content = data_element("changes", self._name, {
            "version": self._version, "squares": changes, "tool": self._tool, "word": board.brush.word,
            "yarn": board.brush.yarn, "selection": _corners(board.selection), "fault_row": board.fault_row,
            "read": self._read,
        })  # fmt: skip
        self._words_data.content = data_element("words", self._name, {
            "text": board.text, "fault_line": board.fault_line, "read": self._read,
        })  # fmt: skip


def _canvas(name: str) -> Markup:
    label = (
        "Chart. Arrow keys move, Space paints, Shift with arrows selects, P, F, B and S choose a tool, "
        "W and E dye the weft and the warp, plus and minus change the size"
    )
    return markup(
        '<div data-chart="{}"><canvas tabindex="0" role="application" aria-label="{}"></canvas>'
        '<div role="status" aria-live="polite" class="sm-status"></div></div>',
        name, label,
    )


def _text_area(name: str) -> Markup:
    return markup(
        '<div data-chart-text="{}" class="sm-text"><div class="sm-lines" aria-hidden="true"></div>'
        '<textarea aria-label="Text of the chart" spellcheck="false" wrap="off" rows="10"></textarea></div>',
        name,
    )


def _fault_message(fault: str) -> Markup:
    if not fault:
        return Markup()
    return markup('<div role="alert" class="sm-fault">{}</div>', fault)


def _size(controls: Controls, label: str, value: int) -> Control:
    hint = f"Number of {label.lower()} after Resize, 1 to {LONGEST_SIDE}"
    return controls.number(label, hint, value, least=1, most=LONGEST_SIDE, step=1)


def _file_name(name: str) -> str:
    """Return a name for a file, of letters, digits and hyphens."""
    kept = "".join(letter if letter.isalnum() else "-" for letter in name.lower()).strip("-")
    return kept[:60] or "chart"


def _corners(box: Box | None) -> list[int] | None:
    return None if box is None else [box.row, box.column, box.row_end, box.column_end]


def _values(message: str) -> dict[str, Any]:
    try:
        return check_value(parse_json(message), dict[str, Any])
    except ParameterError as error:
        raise ParameterError("chart: got a message of the browser that cannot be read; reload the page") from error


def _integers(values: dict[str, Any], *names: str) -> list[int]:
    return [_whole(values.get(name)) for name in names]


def _whole(value: object) -> int:
    try:
        return int(str(value))
    except ValueError:
        raise ParameterError(f"chart: got {value!r}; expected a whole number") from None


def _pairs(places: object) -> Sequence[Sequence[int]]:
    if not isinstance(places, list) or any(not isinstance(place, list) or len(place) != 2 for place in places):
        raise ParameterError("chart: got a stroke without squares; expected rows and columns")
    return [[_whole(part) for part in place] for place in places]


def _short_enough(text: str) -> str:
    if len(text) > LONGEST_TEXT:
        found = f"got {len(text)} characters; expected at most {LONGEST_TEXT}"
        raise ParameterError(f"text of the chart: {found}, a chart has at most {LONGEST_SIDE} rows and columns")
    return text


def _box(values: dict[str, Any]) -> Box:
    return Box(*_integers(values, "row", "column", "row_end", "column_end"))
