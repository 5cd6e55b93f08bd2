# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the fabric is shown: numbers of repeats, what the colours mean, and the colours of the yarns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.pages.swatch.state import COLOURINGS, MOST_TILES, Look
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.swatch_design import SwatchDesign, recoloured, yarn_colours

MOST_YARNS = 8
"""Number of yarns whose colours have a control here; the chart has the others."""


class LookPanel:
    """Controls of the look."""

    def __init__(
        self, controls: Controls, look: Look, design: SwatchDesign, looked: Callable[[Look], object],
        dyed: Callable[[SwatchDesign], object],
    ) -> None:  # fmt: skip
        """Make the controls; ``looked`` is called with another look, ``dyed`` with other colours of the yarns."""
        self._look, self._design, self._looked, self._dyed = look, design, looked, dyed
        with controls.group("Look"):
            controls.number("Repeats shown across", "Copies of the repeat side by side; they cost no computation",
                            look.columns, lambda n: self._set(columns=int(n)), least=1, most=MOST_TILES, step=1)
            controls.number("Repeats shown upwards", "Copies of the repeat one above another",
                            look.rows, lambda n: self._set(rows=int(n)), least=1, most=MOST_TILES, step=1)
            self._by = controls.choice("Colour by", "Colours of the yarns, of their stitches or rows, or of their stretch",
                                       COLOURINGS, look.colour_by, lambda name: self._set(colour_by=name))
            self._blend = controls.slider("Strength of these colours", "0 shows the colours of the yarns alone",
                                          look.blend, lambda part: self._set(blend=part), least=0.0, most=1.0, step=0.05)
            self._yarns = [self._add_yarn(controls, number) for number in range(MOST_YARNS)]
        self.show(design)

    def show(self, design: SwatchDesign) -> None:
        """Show the colours of the yarns of a design."""
        self._design = design
        colours = yarn_colours(design.pattern)
        for number, control in enumerate(self._yarns):
            control.visible = number < len(colours)
            if number < len(colours):
                control.value = colours[number]
        self._by.visible = isinstance(design.pattern, Pattern)
        self._blend.visible = self._by.visible and self._look.colour_by in ("stitch", "row")

    def _add_yarn(self, controls: Controls, number: int) -> Control:
        return controls.colour(
            f"Yarn {number}", "Colour of the yarn with this number in the chart", "#ffffff",
            lambda colour: self._dye(number, colour),
        )  # fmt: skip

    def _set(self, **changes: object) -> None:
        self._look = replace(self._look, **changes)  # type: ignore[arg-type]
        self.show(self._design)
        self._looked(self._look)

    def _dye(self, number: int, colour: str) -> None:
        self._dyed(replace(self._design, pattern=recoloured(self._design.pattern, number, colour)))
