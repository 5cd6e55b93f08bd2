# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the fabric is shown: numbers of repeats, and what the colours mean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.swatch.state import COLOURINGS, MOST_TILES, Look
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.swatch_design import SwatchDesign


class LookPanel:
    """Controls of the look."""

    def __init__(
        self, controls: Controls, look: Look, design: SwatchDesign, looked: Callable[[Look], object]
    ) -> None:
        """Make the controls; ``looked`` is called with another look."""
        self._look, self._design, self._looked = look, design, looked
        with controls.group("Look"):
            controls.number("Repeats shown across", "Copies of the repeat side by side; they cost no computation",
                            look.columns, lambda n: self._set(columns=int(n)), least=1, most=MOST_TILES, step=1)
            controls.number("Repeats shown upwards", "Copies of the repeat one above another",
                            look.rows, lambda n: self._set(rows=int(n)), least=1, most=MOST_TILES, step=1)
            self._by = controls.choice("Colour by", "Colours of the yarns, of their stitches or rows, or of stretch",
                                       COLOURINGS, look.colour_by, lambda name: self._set(colour_by=name))
            self._blend = controls.slider(
                "Strength of these colours", "0 shows the colours of the yarns alone", look.blend,
                lambda part: self._set(blend=part), least=0.0, most=1.0, step=0.05,
            )
        self.show(design)

    def show(self, design: SwatchDesign) -> None:
        """Show the controls that apply to a design."""
        self._design = design
        self._by.visible = isinstance(design.pattern, Pattern)
        self._blend.visible = self._by.visible and self._look.colour_by in ("stitch", "row")

    def _set(self, **changes: object) -> None:
        self._look = replace(self._look, **changes)  # type: ignore[arg-type]
        self.show(self._design)
        self._looked(self._look)
