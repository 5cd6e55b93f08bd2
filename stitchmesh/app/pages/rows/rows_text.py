# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The texts of the page Rows as HTML: figures, the colours of the time, and the lists of marks and borders."""

from __future__ import annotations

from stitchmesh.app.controls.html_pieces import BUTTON, PLAIN_TEXT, action_button, colour_bar, figures, list_button
from stitchmesh.app.controls.legend import LegendEntry, legend
from stitchmesh.app.pages.rows.rows_finder import FoundRows
from stitchmesh.app.pages.rows.rows_state import Marks, MeshBorders
from stitchmesh.app.pages.rows.rows_view import ROLE_COLOURS, TIME_COLOURS, lines_every
from stitchmesh.app.project.shaping import Shaping
from stitchmesh.app.scene.mesh_drawing import INK
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.shaping.report import ShapingReport

KIND_WORDS = {"border": "border", "point": "tip", "stroke": "line"}
"""Words for the kinds of marks."""
ROLE_WORDS = {
    "begin": "knitting begins here", "end": "knitting ends here", "row": "a row runs along this line",
    "side": "rows end at this border", "plain": "no increases or decreases near here",
}  # fmt: skip
"""The meaning of each role, in words."""


def text_line(text: str) -> Markup:
    """Return a line of text that a screen reader reads out after each change."""
    return markup('<p role="status" style="{}">{}</p>', PLAIN_TEXT, text)


def preview_figures(found: FoundRows, shaping: Shaping) -> Markup:
    """Return the figures that are known before there are stitches."""
    stitches = found.area / (shaping.stitch_width * shaping.height)
    return figures([
        ("Rows, one above the other", f"{found.rows:,}"),
        ("Stitches", f"about {stitches:,.0f}"),
    ])  # fmt: skip


def report_figures(report: ShapingReport) -> Markup:
    """Return the figures of the stitches."""
    return figures([
        ("Stitches", f"{report.stitches:,} in {report.rows:,} rows"),
        ("Increases and decreases", f"{report.irregular_per_thousand:.1f} in 1,000 stitches"),
        ("Short rows", f"{report.short_rows:,}"),
        ("Edges at grafts", f"{report.mismatched_edges:,}"),
        ("Distance from the mesh", f"{report.rms_distance:.3f} stitches, at most {report.largest_distance:.2f}"),
        ("Time to find them", f"{report.seconds:.1f} s"),
        *([("Lost", report.lost)] if report.lost else []),
    ])  # fmt: skip


def time_legend(found: FoundRows) -> Markup:
    """Return the legend of the colours and lines of the rows."""
    low, high = float(found.time.min()), float(found.time.max())
    marks = [f"{low:.0f} cm", f"{0.5 * (low + high):.0f}", f"{high:.0f} cm"]
    every = lines_every(found)
    entries = [LegendEntry("each row" if every == 1 else f"every {every} rows", (INK,), line=True)]
    roles = {place.role for place in found.places} | ({"side"} if len(found.side_edges) else set())
    entries += [LegendEntry(ROLE_WORDS[role], (colour,), line=True)
                for role, colour in ROLE_COLOURS.items() if role in roles]  # fmt: skip
    bar = colour_bar(TIME_COLOURS, marks, "Time: length of the fabric from where knitting begins")
    return bar + legend(entries)


def mark_list(marks: Marks, chosen: int | None, borders: MeshBorders) -> Markup:
    """Return for each mark a button that chooses it, and a button that removes it."""
    if not marks:
        return text_line("There are no marks: begins and ends are found automatically.")
    items = joined(_mark_item(number, mark, number == chosen, borders) for number, mark in enumerate(marks))
    return markup('<ul aria-label="Marks" style="list-style:none;margin:0;padding:0">{}</ul>', items)


def _mark_item(number: int, mark: TimeMark, chosen: bool, borders: MeshBorders) -> Markup:
    words = f"{number}: {mark_words(mark, borders)}"
    colour = "rgb(232,140,20)" if chosen else "var(--mantine-color-default-border)"
    narrow = f"{BUTTON} var(--mantine-color-default-border);width:2.2em;flex:none;text-align:center"
    return markup(
        '<li style="display:flex;gap:4px;align-items:stretch">{}{}</li>',
        list_button("choose", number, words, colour, hint="Choose this mark", pressed=chosen),
        action_button("remove", number, "✕", name=f"Remove mark {number}", hint="Remove this mark", style=narrow),
    )


def mark_words(mark: TimeMark, borders: MeshBorders) -> str:
    """Describe a mark by its kind, its role and its time."""
    what = KIND_WORDS[mark.kind]
    if mark.kind == "border":
        number = borders.nearest(mark.points[0])
        what = what if number is None else borders.words(number)
    elif mark.kind == "stroke":
        what = f"line of {len(mark.points)} points"
    time = "" if mark.time is None else f", {mark.time:g} cm"
    radius = "" if mark.radius is None else f", up to {mark.radius:g} cm"
    return f"{mark.role}, {what}{time}{radius}"


def border_list(borders: MeshBorders, marks: Marks) -> Markup:
    """Return for each border a button that gives it the next role."""
    if not borders.loops:
        return text_line("The mesh has no border.")
    heading = markup('<p style="{}">Give a border its next role:</p>', PLAIN_TEXT)
    buttons = joined(
        list_button("border", number, f"{borders.words(number)}: {borders.role_of(marks, number)}")
        for number in range(len(borders.loops))
    )
    return heading + buttons
