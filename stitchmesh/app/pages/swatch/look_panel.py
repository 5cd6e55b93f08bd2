# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the fabric is shown: numbers of repeats, and what the colours mean."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.legend import legend_of_key
from stitchmesh.app.pages.swatch.state import COLOURINGS, MOST_TILES, Look
from stitchmesh.markup import Markup, joined
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.swatch_design import SwatchDesign
from stitchmesh.render.lettering import Colour


class LookPanel:
    """Controls of the look."""

    def __init__(self, controls: Controls, look: Look, design: SwatchDesign, looked: Callable[[Look], object]) -> None:
        """Make the controls; ``looked`` is called with another look."""
        self._look, self._design, self._looked = look, design, looked
        with controls.group("Look"):
            self._columns = controls.number(
                "Copies across", "Copies of the repeat side by side; they cost no computation", look.columns,
                lambda count: self._set(columns=int(count)), least=1, most=MOST_TILES, step=1,
            )  # fmt: skip
            self._rows = controls.number(
                "Copies upwards", "Copies of the repeat one above another; they cost no computation", look.rows,
                lambda count: self._set(rows=int(count)), least=1, most=MOST_TILES, step=1,
            )  # fmt: skip
            self._by = controls.choice(
                "Colour by", "Colours of the yarns, of their stitches or rows, or of stretch", COLOURINGS,
                look.colour_by, lambda name: self._set(colour_by=name),
            )  # fmt: skip
            self._blend = controls.slider(
                "Strength", "How much these colours cover those of the yarns; 0 shows the yarns alone", look.blend,
                lambda part: self._set(blend=part), least=0.0, most=1.0, step=0.05,
            )  # fmt: skip
            self._legend = controls.html(Markup())
        self.show(design, look)

    def show_legends(self, legends: Sequence[tuple[str, Sequence[tuple[str, Colour]]]]) -> None:
        """Show what the colours of each variant mean; without a legend, nothing.

        Args:
            legends: name of each variant, with the names and colours of its legend.
        """
        several = len(legends) > 1
        self._legend.content = joined(
            legend_of_key(entries, f"Colours of {name}" if several else "") for name, entries in legends if entries
        )

    def show(self, design: SwatchDesign, look: Look) -> None:
        """Show a look, with the controls that apply to a design."""
        self._design, self._look = design, look
        self._columns.value, self._rows.value = look.columns, look.rows
        self._by.visible = isinstance(design.pattern, Pattern)
        self._blend.visible = self._by.visible and self._look.colour_by in ("stitch", "row")

    def _set(self, **changes: object) -> None:
        look = replace(self._look, **changes)  # type: ignore[arg-type]
        self.show(self._design, look)
        self._looked(look)
