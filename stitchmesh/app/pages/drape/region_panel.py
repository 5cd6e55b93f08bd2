# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of the region: kind, budget, brush, box, words, undo and redo."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import FieldPanel, Number, setting_field
from stitchmesh.app.controls.undo_row import UndoRow
from stitchmesh.app.pages.drape.cloth_drawing import ClothDrawing
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.app.pages.drape.loads_panel import entry_list
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.drape.paint_tool import PaintTool
from stitchmesh.app.pages.typed import selected_by_words, three_numbers
from stitchmesh.app.pages.view.thing_view import ClipBox
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup
from stitchmesh.mesh import IntArray
from stitchmesh.mixed.placement.chosen_region import triangles_of_faces, triangles_of_panels
from stitchmesh.mixed.scene.motion_section import AttachmentSection
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection, with_triangles, without_triangles
from stitchmesh.selection import parse_selection
from stitchmesh.selection.selected_faces import in_spans
from stitchmesh.selection.selection import Faces

Kind = Literal["none", "chosen", "all", "automatic"]
KINDS: dict[str, Kind] = {
    "nowhere": "none", "in the region": "chosen", "where triangles err": "automatic", "everywhere": "all",
}  # fmt: skip
"""The kinds of regions, by the words of the page."""
BUDGET = 1000
"""Initial limit of the number of yarn nodes, for an automatic region."""
NODES, SECONDS = "number of nodes", "time of a step"
"""The choices of a limit for an automatic region."""
BUDGETS = (
    setting_field(RegionSection, "nodes", "Most nodes", Number(1, 100_000_000, 1),
                  shown=lambda section: section.yarns == "automatic" and section.seconds is None),
    setting_field(RegionSection, "seconds", "Time of a step", Number(1e-3, 3600.0, 0.05),
                  shown=lambda section: section.yarns == "automatic" and section.seconds is not None),
)  # fmt: skip
"""The fields of the limits of an automatic region."""
WIDTHS = (
    setting_field(RegionSection, "adapt_every", "Change every", Number(0, 1_000_000, 1, without=None),
                  shown=lambda section: section.yarns == "automatic"),
    setting_field(RegionSection, "rings", "Hybrid rings", Number(1, 20, 1)),
)  # fmt: skip
"""Fields for the changes of a region, and for the width of the hybrid region."""
WORDS = "Such as hem 6 or rows 10-20 for stitches; names of panels, all, or faces 3, 10-20 for another cloth."
THIRDS = (1 / 3, 2 / 3)
"""Initial places of the left, right, lower and upper side of the box, over the box of the cloth."""
BESIDE = 1.0
"""Initial distance of the box from the front of the cloth, and from the back of a flat cloth [cm]."""


class RegionPanel:
    """The group of the region."""

    def __init__(
        self, session: DrapeSession, drawing: ClothDrawing, paint: PaintTool, controls: Controls,
        find: Callable[[], None],
    ) -> None:  # fmt: skip
        """Make the controls; ``find`` finds the region that a run would choose."""
        self._session, self._drawing, self._paint = session, drawing, paint
        self._cloth: object = None
        with controls.group("Region of yarns") as self._group:
            self._kind = controls.choice(
                "Yarns", "Where yarns are simulated; elsewhere the cloth is triangles.", tuple(KINDS), "nowhere",
                self._set_kind,
            )  # fmt: skip
            self._budget = controls.choice(
                "Budget", "What limits the region: a number of yarn nodes, or the time of a step.", (NODES, SECONDS),
                NODES, self._set_budget,
            )  # fmt: skip
            budgets = FieldPanel(controls, BUDGETS, self._section, self._take)
            self._find = controls.button(
                "Find the region now", "Run the triangles alone, and take the triangles with the largest errors.", find
            )
            self._numbers = budgets, FieldPanel(controls, WIDTHS, self._section, self._take)
            controls.button("Clear the region", "No yarns anywhere, and no boxes.", self._clear)
        with controls.group("Brush and changes") as self._brush_group:
            paint.build(controls)
            self._changes = UndoRow(controls, session.undo, session.redo)
        with controls.group("Box and selection", opened=False) as self._other_group:
            self._low = controls.text("Box from", "Smallest x, y, z [cm].", "", lambda _: self._draw_box())
            self._high = controls.text("Box to", "Largest x, y, z [cm].", "", lambda _: self._draw_box())
            controls.buttons("Box", "Add or take out its triangles, hold what lies in it, or hide it.",
                             ("Add box", "Take out", "Hold", "Hide"), self._use_box)  # fmt: skip
            self._words = controls.text("By words", WORDS, "")
            controls.buttons("These", "The triangles that the words name.", ("Add", "Remove", "Only"), self._use_words)
            self._list = controls.html(Markup(), self._drop_box)

    def refresh(self) -> None:
        """Show the region of the scene."""
        opened = self._session.opened
        self._group.visible = self._brush_group.visible = self._other_group.visible = opened is not None
        if opened is None:
            return
        section = opened.scene.region
        self._kind.value = next(words for words, kind in KINDS.items() if kind == section.yarns)
        for panel in self._numbers:
            panel.show()
        self._changes.show(self._session.history)
        automatic = section.yarns == "automatic"
        self._budget.value = NODES if section.seconds is None else SECONDS
        self._budget.visible = automatic
        self._find.visible = automatic
        self._list.content = box_list(section)
        if self._cloth is not opened.mesh:
            self._cloth = opened.mesh
            self._propose_box()
        self._paint.refresh()

    def _set_kind(self, words: str) -> None:
        kind = KINDS[words]

        def change(section: RegionSection) -> RegionSection:
            needs = kind == "automatic" and section.seconds is None
            return replace(section, yarns=kind, nodes=(section.nodes or BUDGET) if needs else None)

        self._change(change)

    def _set_budget(self, which: str) -> None:
        if which == NODES:
            self._set(nodes=BUDGET, seconds=None)
        else:
            self._set(nodes=None, seconds=0.5)

    def _section(self) -> RegionSection | None:
        return None if self._session.scene is None else self._session.scene.region

    def _take(self, section: RegionSection, name: str) -> None:
        self._change(lambda before: section)

    def _set(self, **values: Any) -> None:
        self._change(lambda section: replace(section, **values))

    def _change(self, change: Callable[[RegionSection], RegionSection]) -> None:
        try:
            self._session.change_region(lambda section, cloth: change(section))
        finally:
            self.refresh()  # A refused change leaves the controls as they were.

    def _clear(self) -> None:
        self._set(yarns="chosen", nodes=None, seconds=None, boxes=(), faces=())

    def _propose_box(self) -> None:
        """Fill in a box around the middle of the front of the cloth."""
        opened = self._session.opened
        assert opened is not None
        low, high = opened.mesh.vertices.min(axis=0), opened.mesh.vertices.max(axis=0)
        first, last = low + THIRDS[0] * (high - low), low + THIRDS[1] * (high - low)
        first[2], last[2] = 0.5 * (low[2] + high[2]), high[2] + BESIDE
        first[2] -= BESIDE if high[2] - low[2] < BESIDE else 0.0
        self._low.value, self._high.value = (", ".join(f"{x:.3g}" for x in corner) for corner in (first, last))

    def _box(self) -> BoxSection:
        """Return the typed box.

        Raises:
            ParameterError: the box does not have three numbers at each end, or it is empty.
        """
        low, high = three_numbers("box from", self._low.value), three_numbers("box to", self._high.value)
        return BoxSection(low=low, high=high)

    def _draw_box(self) -> None:
        """Draw the box as soon as its numbers are valid."""
        try:
            low, high = three_numbers("box from", self._low.value), three_numbers("box to", self._high.value)
        except ParameterError:
            self._drawing.show_box(None)
        else:
            self._drawing.show_box(ClipBox(low, high))

    def _use_box(self, which: str) -> None:
        if which == "Hide":
            self._drawing.show_box(None)
            return
        box = self._box()
        opened = self._session.opened_for("box")
        self._draw_box()
        if which == "Hold":
            held = AttachmentSection(boxes=(box,))
            self._session.change(replace(opened.scene, attachments=(*opened.scene.attachments, held)))
            return
        inside = RegionSection(boxes=(box,)).named_triangles(opened.cloth)
        if which == "Take out":
            self._session.change_region(lambda section, cloth: without_triangles(section, cloth, inside))
            return
        no_triangles = np.zeros(0, dtype=np.int64)

        def add(section: RegionSection, cloth: object) -> RegionSection:
            chosen = with_triangles(section, opened.cloth, no_triangles)
            return chosen if box in chosen.boxes else replace(chosen, boxes=(*chosen.boxes, box))

        self._session.change_region(add)

    def _use_words(self, which: str) -> None:
        opened = self._session.opened_for("selection")
        found: IntArray = triangles_named(opened, str(self._words.value))
        if which == "Remove":
            self._session.change_region(lambda section, cloth: without_triangles(section, cloth, found))
            return

        def add(section: RegionSection, cloth: object) -> RegionSection:
            kind: Kind = "automatic" if section.yarns == "automatic" else "chosen"
            start = replace(section, yarns=kind, boxes=(), faces=()) if which == "Only" else section
            return with_triangles(start, opened.cloth, found)

        self._session.change_region(add)

    def _drop_box(self, action: str, value: str) -> None:
        section = self._section()
        boxes = () if section is None else section.boxes
        if action != "drop-box" or not value.isdecimal() or int(value) >= len(boxes):
            raise ParameterError("box: the list of boxes has changed; look at it again")
        kept = tuple(box for number, box in enumerate(boxes) if number != int(value))
        self._set(boxes=kept)


def triangles_named(opened: OpenedScene, text: str) -> IntArray:
    """Return the triangles that a text names, ascending.

    For a cloth of stitches the text is a selection, such as ``hem 6``. For any other cloth it holds names of panels,
    separated by commas, or is ``all``, or names triangles by their numbers, such as ``faces 3, 10-20``.

    Raises:
        ParameterError: the text names nothing that the cloth has.
    """
    words = text.strip()
    if not words:
        raise ParameterError("selection: got nothing; expected words such as hem 6, a panel, or faces 3, 10-20")
    if opened.fabric is not None:
        return triangles_of_faces(opened.fabric, selected_by_words(opened.fabric, words))
    if words == "all":
        return np.arange(len(opened.cloth.triangles))
    if words.startswith("faces "):
        return _numbered(parse_selection(words), len(opened.cloth.triangles))
    return triangles_of_panels(opened.cloth, *(name.strip() for name in words.split(",")))


def _numbered(selection: object, count: int) -> IntArray:
    if not isinstance(selection, Faces):
        raise ParameterError("selection: got more than numbers; expected numbers alone, such as faces 3, 10-20")
    beyond = [number for span in selection.spans for number in (span.first, span.last or 0) if number >= count]
    if beyond:
        raise ParameterError(f"selection: got triangle {beyond[0]}; expected 0 to {count - 1}")
    return np.flatnonzero(in_spans(np.arange(count), selection.spans))


def box_list(section: RegionSection) -> Markup:
    """Return the boxes as a list, each with a button that removes it, and the number of single triangles."""
    single = f"{len(section.faces):,} single triangles" if section.faces else ""
    return entry_list("box", (str(box) for box in section.boxes), rest=single)
