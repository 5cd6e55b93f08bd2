# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tool that lays patterns; it first shows the pattern on the fabric."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.edit.edit_session import NO_FACES, EditSession
from stitchmesh.app.pages.edit.tool import Tool
from stitchmesh.app.scene.scene import Pick
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.io.atomic import temporary_file
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.picking import PickedPlace
from stitchmesh.patterns.capture.capture import capture_pattern, smallest_repeat
from stitchmesh.patterns.charts.chart_image import CHART_IMAGES
from stitchmesh.patterns.language.parse import parse_pattern
from stitchmesh.patterns.language.writing import format_pattern
from stitchmesh.patterns.library import read_pattern
from stitchmesh.patterns.moved import mirrored_pattern, possible_shifts, shifted_pattern
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.apply import lay_pattern
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, check_remainder
from stitchmesh.patterns.placement.laying import LaidPattern
from stitchmesh.periodic.charts.chart_picture import PATTERN_PICTURE, PATTERN_TEXT, pattern_content
from stitchmesh.selection import select

Area = Literal["Selection", "Around a click", "Whole fabric"]
AREAS: tuple[Area, ...] = get_args(Area)
REMAINDERS = {"leave them plain": "centre", "stretch the pattern": "stretch", "refuse": "refuse"}
"""The treatment of loops beside whole repeats, by the words of the page."""
MOVES: dict[str, Callable[[Pattern], Pattern]] = {
    "Left": lambda pattern: shifted_pattern(pattern, (0, *possible_shifts(pattern))[-1]),
    "Right": lambda pattern: shifted_pattern(pattern, (*possible_shifts(pattern), 0)[0]),
    "Up": lambda pattern: shifted_pattern(pattern, 0, 1),
    "Down": lambda pattern: shifted_pattern(pattern, 0, -1),
    "Mirror": mirrored_pattern,
}
"""The changes that the buttons make to the pattern, by the words of the page."""
SUFFIXES = (".knit", ".txt", ".leaf", *CHART_IMAGES)
SAVED = {"Text": PATTERN_TEXT, "Chart": PATTERN_PICTURE}
"""Suffix of the file of a pattern, by the words of the page."""
LARGEST_FILE = 4_000_000
"""Size of the largest file of a pattern [bytes]."""
MOST_REASONS = 3
"""Largest number of groups of left-out stitches that are described."""


class LayPatterns(Tool):
    """Lays a pattern from the library or a file on the selection, around a click, or on the whole fabric."""

    name, key = "Lay a pattern", "T"
    hint = "Choose a pattern on the left and where it goes; the fabric shows it before you lay it."
    takes_strokes = False

    def __init__(self, session: EditSession) -> None:
        """Begin without a pattern."""
        super().__init__(session)
        self.pattern = ""
        """Name of the pattern in the library, or its text; empty if the user has chosen none."""
        self.area: Area = "Around a click"
        self.remainder: str = DEFAULT_REMAINDER
        self.ground: str | None = None
        """Colour of the pattern for stitches left over; None for the commonest one."""
        self.centre = False
        """Whether the middle of a repeat lies in the middle of the front."""
        self.laid: LaidPattern | None = None
        """The fabric with the pattern, as the preview shows it; None without a preview."""
        self._face: int | None = None
        self._on = False

    def build(self, controls: Controls) -> None:
        """Make the controls."""
        self._area = controls.choice("Where", "Which stitches take the pattern", AREAS, self.area, self._set_area)
        words = next(words for words, name in REMAINDERS.items() if name == self.remainder)
        controls.choice("Stitches left over", "What happens to stitches beside whole repeats of the pattern",
                        tuple(REMAINDERS), words, self._set_remainder)  # fmt: skip
        self._ground = controls.text("Ground", "Colour of the pattern that stitches left over take, such as cream; "
                                     "empty for the commonest one", "", self._set_ground)  # fmt: skip
        controls.toggle("In the middle of the front", "Put the middle of a repeat in the middle of the front of "
                        "rounds, and in the middle of flat rows", self.centre, self._set_centre)  # fmt: skip
        hint = "Move the repeat sideways to its next place, or by one row, or exchange left and right"
        controls.buttons("Move the pattern", hint, tuple(MOVES), self._move)
        controls.upload("Pattern from a file", "Read a pattern from a text or an image of a chart", SUFFIXES,
                        self.read_file)  # fmt: skip
        controls.button("Capture the selection", "Take the selected stitches as the pattern, to lay them elsewhere",
                        self.capture)  # fmt: skip
        controls.buttons("Save the pattern", "Keep the chosen pattern as a text, or as a picture of its chart",
                         tuple(SAVED), self._save)  # fmt: skip
        self._lay = controls.button("Lay the pattern", "Replace the stitches by those of the pattern", self.lay,
                                    main=True)  # fmt: skip
        self._discard = controls.button("Discard the preview", "Show the fabric as it is", self.discard)
        self._words = controls.html(Markup())
        self._say(Markup())

    def taken_up(self) -> None:
        """Show the pattern at the place where it would go."""
        self._on = True
        if len(self.session.state.selection.faces) and self._face is None:
            self.area = self._area.value = "Selection"
        self._preview()

    def laid_down(self) -> None:
        """Show the fabric without the pattern."""
        self._on = False
        self.discard()

    def refresh(self) -> None:
        """Forget the preview if the fabric has changed."""
        self._face, self.laid = None, None
        self._say(Markup())

    def choose(self, pattern: str) -> None:
        """Take a pattern: the name of one in the library, or a text."""
        self.pattern = pattern
        self._preview()

    def read_file(self, name: str, content: bytes) -> None:
        """Take the pattern of a file.

        Raises:
            StitchMeshError: the file is too large or holds no pattern.
        """
        if len(content) > LARGEST_FILE:
            limit = f"at most {LARGEST_FILE / 1e6:.0f} MB"
            raise ParameterError(f"{Path(name).name}: got {len(content) / 1e6:.1f} MB; expected {limit}")
        with temporary_file(name, content) as path:
            pattern = read_pattern(path)
        self.session.patterns.keep(pattern)
        self.choose(format_pattern(pattern))

    def capture(self) -> None:
        """Take one repeat of the selected stitches as the pattern; a click then lays it elsewhere.

        Raises:
            ParameterError: nothing is selected.
        """
        faces = self.session.state.selection.faces
        self.session.on_selection()
        try:
            pattern = smallest_repeat(capture_pattern(self.session.fabric, faces))
        except StitchMeshError as error:
            self.session.refuse(faces, str(error))
            return
        self.session.patterns.keep(pattern)
        self.pattern, self.area, self._face = format_pattern(pattern), "Around a click", None
        self._area.value = self.area
        self.discard()
        captured = markup("<b>Captured</b> {} stitches by {} rows.", pattern.width, pattern.height)
        self._say(markup("{} Next: {}.", captured, self._missing()))

    def clicked(self, place: PickedPlace, pick: Pick) -> None:
        """Show the pattern on the plain stitches around a click."""
        self.area = self._area.value = "Around a click"
        self._face = place.face
        self._preview()

    def boxed(self, faces: IntArray) -> None:
        """Select the faces, and show the pattern on them."""
        self.session.choose(faces)
        self.area = self._area.value = "Selection"
        self._preview()

    def lay(self) -> None:
        """Make the edit."""
        where = self._where()
        if not self.pattern or where is None:
            raise ParameterError(f"pattern: {self._missing()}")
        arguments: dict[str, object] = {"pattern": self.pattern, **where, "remainder": self.remainder}
        arguments |= {} if self.ground is None else {"ground": self.ground}
        arguments |= {"centre": True} if self.centre else {}
        if self.session.edit("paste_pattern", arguments, self._at()):
            self._say(markup("<b>{}</b> is laid.", self._read().name))

    def discard(self) -> None:
        """Show the fabric without the pattern."""
        if self.laid is not None:
            self.laid = None
            self.session.view.unmark()
            self.session.show_fabric()
        self._say(Markup())

    def _where(self) -> dict[str, object] | None:
        """Return the argument that says where the pattern goes; None before the user has chosen this."""
        if self.area == "Whole fabric":
            return {}
        if self.area == "Around a click":
            return None if self._face is None else {"face": self._face}
        return self.session.on_selection() if len(self.session.state.selection.faces) else None

    def _at(self) -> IntArray:
        if self.area == "Selection":
            return self.session.state.selection.faces
        return NO_FACES if self._face is None or self.area == "Whole fabric" else np.array([self._face])

    def _missing(self) -> str:
        if not self.pattern:
            return "choose one on the left, or read one from a file"
        if self.area == "Whole fabric":
            return "choose another pattern, or another place"
        return "select stitches first" if self.area == "Selection" else "click a stitch of the fabric"

    def _preview(self) -> None:
        """Show the pattern on the fabric, if the pattern and its place are chosen."""
        if not self._on:
            return
        where = self._where()
        if not self.pattern or where is None:
            self.discard()
            self._say(Markup())
            return
        fabric = self.session.fabric
        faces = select(fabric, str(where["on"])) if "on" in where else None
        try:
            self.laid = lay_pattern(
                fabric, self._read(), face=self._face if "face" in where else None, faces=faces,
                remainder=check_remainder(self.remainder), ground=self.ground, centre=self.centre,
            )  # fmt: skip
        except StitchMeshError as error:
            self.laid = None
            self.session.refuse(self._at(), str(error))
            self._say(Markup())
            return
        self._show(self.laid)

    def _show(self, laid: LaidPattern) -> None:
        view = self.session.view
        view.unmark()
        self.session.colour_by("yarn" if self._read().yarn_count > 1 else "stitch")
        view.select(laid.fabric, NO_FACES)
        view.show(laid.fabric)
        view.mark_left_out(laid.fabric, np.flatnonzero(laid.reason >= 0))
        left_out, more = [*map(str, laid.left_out[:MOST_REASONS])], len(laid.left_out) - MOST_REASONS
        left_out += [f"and {more} more groups"] if more > 0 else []
        items = joined(markup("<li>{}</li>", part) for part in left_out)
        name, count = self._read().name, laid.faces_laid
        title = markup("<b>Preview of {}</b>: {} stitches in the pattern.", name, count)
        rest = markup("<br>Not in the pattern, marked:<ul>{}</ul>", items) if left_out else Markup()
        if laid.breaks_rounds:
            width = self._read().width
            rest += markup("Rounds of a multiple of {} stitches leave none over: page Rows makes such rounds.", width)
        self._say(title + rest)

    def _read(self) -> Pattern:
        return parse_pattern(self.pattern) if "\n" in self.pattern else read_pattern(self.pattern)

    def _say(self, text: Markup) -> None:
        self._words.content = paragraph(text or f"Next: {self._missing()}.")
        self._lay.disabled = self._discard.disabled = self.laid is None

    def _save(self, kind: str) -> None:
        if not self.pattern:
            raise ParameterError(f"pattern: {self._missing()}")
        suffix = SAVED[kind]
        self.session.app.download(f"pattern{suffix}", pattern_content(self._read(), suffix))

    def _move(self, how: str) -> None:
        """Take the moved pattern as a text."""
        if not self.pattern:
            raise ParameterError(f"pattern: {self._missing()}")
        self.choose(format_pattern(MOVES[how](self._read())))

    def _set_area(self, area: str) -> None:
        self.area = next(known for known in AREAS if known == area)
        self._preview()

    def _set_centre(self, centre: bool) -> None:
        self.centre = centre
        self._preview()

    def _set_ground(self, colour: str) -> None:
        self.ground = colour.strip() or None
        self._preview()

    def _set_remainder(self, words: str) -> None:
        self.remainder = REMAINDERS[words]
        self._preview()
