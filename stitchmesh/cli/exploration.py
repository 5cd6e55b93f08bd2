# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The files and the lines that ``swatch --explore`` writes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from stitchmesh.cli.output_folder import draw_if_possible

if TYPE_CHECKING:
    from stitchmesh.periodic.explore import Exploration

HEAD = "state  starts  erg/stitch    wales x courses [cm]  thickness [cm]  shape     posture   lean"
OWN = "  (the state of a swatch)"


def exploration_report(found: Exploration) -> dict[str, Any]:
    """Return the figures of the starts and of the states of rest."""
    counts = {"starts": found.starts, "not_at_rest": found.not_at_rest, "spread": found.spread}
    return counts | {"rests": found.table()}


def write_exploration(folder: Path, found: Exploration, report: dict[str, Any], *, draw: bool) -> bool:
    """Write rests.json, a file with the yarns of each state, and a sheet of pictures.

    Args:
        folder: the output folder.
        found: the states of rest.
        report: what rests.json holds.
        draw: whether to draw the sheet.

    Returns:
        Whether the sheet was drawn.

    Raises:
        FileError: a file cannot be written.
    """
    from stitchmesh.io.atomic import write_json
    from stitchmesh.io.yarns import write_yarns
    from stitchmesh.render.thumbnails.rest_sheet import draw_rests

    for number, rest in enumerate(found.rests, 1):
        write_yarns(folder / f"rest-{number}.h5", rest.swatch.yarns)
    write_json(folder / "rests.json", report)
    return draw and bool(found.rests) and draw_if_possible(lambda: draw_rests(found, folder / "rests.png"))


def exploration_lines(found: Exploration, folder: Path, *, drawn: bool) -> list[str]:
    """Return the table of the states as lines of text, and the files to open."""
    lines = [HEAD] if found.rests else []
    for number, row in enumerate(found.table(), 1):
        size = f"{row['wale_spacing']:10.3f} x {row['course_spacing']:.3f}"
        lines.append(
            f"{number:5d}  {row['count']:6d}  {row['energy_per_stitch']:10.2f}  {size:>24}  {row['thickness']:14.2f}  "
            f"{row['shape']:8}  {row['posture']:8}  {row['lean']:+.2f}{OWN if row['usual'] else ''}"
        )
    states = "1 state" if len(found.rests) == 1 else f"{len(found.rests)} states"
    resting = f"Found {states} of rest from {found.starts} starts"
    missing = f"; {found.not_at_rest} did not come to rest (raise --max-iterations)" if found.not_at_rest else ""
    picture = f"Open {folder / 'rests.png'}" if drawn else "No picture was drawn"
    if lines:
        width, height = (100.0 * part for part in found.spread)
        lines.append(f"The starts differ by {width:.2g} % in width and {height:.2g} % in height.")
    return [*lines, f"{resting}{missing}.", f"{picture}; {folder / 'rests.json'} holds all numbers."]
