# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page Label says of a labeling, as HTML: numbers, legend, reasons of faults, and borders to start at."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.html_pieces import PLAIN_TEXT, action_button
from stitchmesh.app.controls.legend import LegendEntry
from stitchmesh.app.scene.drawing import Colour
from stitchmesh.labeling import LabelingFault, PartialLabeling
from stitchmesh.labeling.faults import triangles_message
from stitchmesh.labeling.pointed_step import free_border_sides
from stitchmesh.labeling.seeds import candidate_seeds
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import Mesh
from stitchmesh.render.labeling_drawing import FAULT_COLOUR, MISMATCH_COLOUR, UNLABELED_COLOUR
from stitchmesh.yarn.colours import row_colours

INK: Colour = (58, 54, 50)
"""Colour of edges and arrows."""
START_COLOUR: Colour = (232, 140, 20)
"""Colour of borders at which a row can start."""
MOST_FAULTS = 5
"""Number of faults that are listed."""
MOST_STARTS = 8
"""Number of borders that are listed."""
BUTTON = (
    "font:inherit;font-size:.95em;display:block;width:100%;text-align:left;margin:.15em 0;padding:.3em .4em;"
    "border-radius:6px;cursor:pointer;background:transparent;color:inherit;border:1px solid"
)
"""Style of a button of a list, up to the colour of its border."""


def list_button(
    action: str, value: object, words: str, border: str = "var(--mantine-color-default-border)", *, hint: str = "",
    pressed: bool | None = None,
) -> Markup:  # fmt: skip
    """Return a button as wide as its list, with a border of a colour; the other arguments are of ``action_button``."""
    return action_button(action, value, words, hint=hint, pressed=pressed, style=f"{BUTTON} {border}")


def labeling_status(labeling: PartialLabeling, inside_out: bool) -> Markup:
    """The numbers in one or two lines."""
    done, faces = int(labeling.labeled.sum()), labeling.mesh.face_count
    rows = labeling.row_count
    first = markup("<strong>{} row{}</strong>, {} of {} faces labeled", rows, "s" * (rows != 1), done, faces)
    lines: list[str] = [first]
    seams = len(labeling.mismatched_sides())
    if seams:
        lines.append(
            f"At {seams} edge{'s' * (seams != 1)} the arrows of two rows do not match. Flip one of the rows, or keep "
            "it: small rings of yarn will join them."
        )
    if triangles_message(labeling.mesh):
        lines.append(triangles_message(labeling.mesh))
    if inside_out:
        hint = "The mesh seems to be inside out: its purl side would be outside. See <em>Whole mesh</em>."
        lines.append(markup(hint))
    return joined(markup('<p role="status" style="margin:0 0 .3em;font-size:.92em">{}</p>', line) for line in lines)


def legend_entries(labeling: PartialLabeling) -> list[LegendEntry]:
    """What can be seen."""
    entries = []
    if labeling.row_count:
        rows = [tuple(colour) for colour in row_colours(np.arange(6)).tolist()]
        entries.append(LegendEntry("rows; arrows along the wales", tuple(rows)))
    if not labeling.labeled.all():
        entries.append(LegendEntry("no row yet", (UNLABELED_COLOUR,)))
    if len(free_border_sides(labeling)):
        entries.append(LegendEntry("border: click it to start a row", (START_COLOUR,), line=True))
    if labeling.row_count:
        entries.append(LegendEntry("course edge, between rows", (INK,), line=True))
    if len(labeling.mismatched_sides()):
        entries.append(LegendEntry("seam where arrows do not match", (MISMATCH_COLOUR,), line=True))
    if labeling.faults:
        entries.append(LegendEntry("cannot be labeled: crossed out, with a number", (FAULT_COLOUR,)))
    return entries


def fault_list(faults: tuple[LabelingFault, ...]) -> Markup:
    """The reasons why faces cannot be labeled; each reason is a button that shows its faces."""
    if not faults:
        return Markup()
    items = joined(
        markup("<li>{}</li>", list_button("fault", number, fault.reason, f"rgb{FAULT_COLOUR!r}", hint="Show the faces"))
        for number, fault in enumerate(faults[:MOST_FAULTS])
    )
    more = len(faults) - MOST_FAULTS
    rest = markup('<p style="{}">and {} more</p>', PLAIN_TEXT, more) if more > 0 else Markup()
    return (
        markup(
            '<p style="margin:.3em 0 0;font-size:.92em"><strong>Faces that cannot be labeled</strong></p>'
            '<ol style="margin:0;padding-left:1.4em;font-size:.86em">{}</ol>{}',
            items, rest,
        )
    )


def start_list(mesh: Mesh) -> Markup:
    """Buttons for the borders from which rows may start, best first."""
    buttons = []
    for chain in candidate_seeds(mesh)[:MOST_STARTS]:
        length = float(mesh.side_length[chain].sum())
        height = float(mesh.corner_position[chain, 1].mean() - mesh.vertices[:, 1].min())
        words = f"Border of {length:.0f} cm at height {height:.0f} cm"
        buttons.append(list_button("start", chain[0], words))
    heading = markup('<p style="{}">Start the next row at a border:</p>', PLAIN_TEXT)
    without = markup("<p>The mesh has no border. Choose that a click starts at an inner edge.</p>")
    return heading + joined(buttons) if buttons else without
