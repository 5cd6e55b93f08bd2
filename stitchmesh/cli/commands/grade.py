# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``grade``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction

from stitchmesh.cli.options import Device, Overwrite
from stitchmesh.cli.output_folder import draw_if_possible, output_folder
from stitchmesh.cli.summary import AsJson, print_result
from stitchmesh.cli.words import Flag, help_entry

if TYPE_CHECKING:
    from pathlib import Path

    from stitchmesh.recipe.grade import Graded, GradedSize

PICTURE = "sizes.png"
"""Name of the picture of all sizes."""
WIDTH, HEIGHTS = 1600, (400, 1200)
"""Width of the picture, and bounds of its height, which follows from the garments [pixels]."""
VIEW = (0.0, 6.0)
"""Azimuth and elevation of the camera [degrees]: from the front, so that all sizes are equally far away."""


@dataclass(frozen=True)
class GradeCommand:
    """Make a recipe in several sizes, with one text of instructions for all."""

    recipe: Annotated[Positional[str], help_entry("RECIPE")]
    """recipe (.toml) of a garment whose mesh is modelled in rows"""
    sizes: Annotated[str, help_entry("FILE|TABLE")]
    """sizes: a CSV file with a head such as 'size,chest [cm],length [in]', or standard sizes of bodies: women:S,M,L,
    men, children, heads, feet (docs/how-to/grade.md)"""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for the instructions, a report, a picture, and mesh, recipe and stitches of each size"""
    ease: Annotated[UseAppendAction[tuple[str, ...]], help_entry("MEASURE=LENGTH|PART%", "none")] = ()
    """addition to a measure of all sizes, such as chest=8 [cm], chest=3in or head=-6%%; may be repeated"""
    device: Device = None
    no_picture: Flag = False
    """do not write sizes.png"""
    json: AsJson = False
    overwrite: Overwrite = False

    def run(self) -> None:
        """Make all sizes, write them, draw them beside each other, and print a summary."""
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.recipe.grade import grade, output_names, write_graded
        from stitchmesh.recipe.recipe_file import read_recipe
        from stitchmesh.recipe.sizes import names_of_sizes_in, parse_ease

        ease = [parse_ease(text) for text in self.ease]
        outputs = [*output_names(names_of_sizes_in(self.sizes)), *([] if self.no_picture else [PICTURE])]
        with output_folder(self.output, outputs) as folder:
            with show_progress() as progress:
                recipe = read_recipe(self.recipe)
                recipe = replace(recipe, device=self.device or recipe.device)
                made = grade(recipe, self.sizes, ease=ease, progress=progress)
            write_graded(folder, made)
            drawn = not self.no_picture and draw_if_possible(lambda: _draw(made, folder))
        print_result(made.report(), [*_lines(made), _open(folder, drawn)], as_json=self.json)


def _draw(made: Graded, folder: Path) -> None:
    from stitchmesh.render import PictureOptions, render_yarns
    from stitchmesh.yarn.beside import yarns_beside

    beside = yarns_beside([one.yarns for one in made.sizes])
    wide, high, _ = beside.points.max(axis=0) - beside.points.min(axis=0)
    height = min(max(round(1.2 * WIDTH * high / wide), HEIGHTS[0]), HEIGHTS[1])
    render_yarns(beside, folder / PICTURE, PictureOptions(size=(WIDTH, height), view=VIEW, inset=False))


def _lines(made: Graded) -> list[str]:
    """Return a line for each size, and warnings."""
    lines = [f"Knitted at {made.gauge}, with {made.yarn}."]
    lines += [f"{one.size.name}: {_measures(one)}; {_amount(one)}." for one in made.sizes]
    for one in made.sizes:
        if one.cut:
            lines.append(f"{one.size.name}: shaping cuts repeats of {', '.join(one.cut)}.")
    return lines


def _measures(one: GradedSize) -> str:
    return ", ".join(
        f"{name} {one.finished[name]:.1f} cm (asked {asked:.4g})" for name, asked in one.size.measures.items()
    )


def _amount(one: GradedSize) -> str:
    metres, grams = (sum(getattr(amount, part) for amount in one.amounts) for part in ("metres", "grams"))
    rows = int(one.fabric.row.max()) + 1
    return f"{one.fabric.face_count:,} stitches in {rows:,} rows, {metres:.0f} m of yarn, about {grams:.0f} g"


def _open(folder: Path, drawn: bool) -> str:
    from stitchmesh.recipe.grade import INSTRUCTIONS

    picture = f", and {folder / PICTURE} the picture" if drawn else ""
    return f"{folder / INSTRUCTIONS} holds the instructions{picture}."
