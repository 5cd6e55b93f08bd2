# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of the direction upwards and of how many stitches a row has."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.increase_choice import WORDS, increase_choice
from stitchmesh.app.project.shaping import Point, Shaping
from stitchmesh.shaping.options import UP, Placement

UPWARDS: dict[str, Point] = {
    "+y": UP, "+z": (0.0, 0.0, 1.0), "+x": (1.0, 0.0, 0.0), "-y": (0.0, -1.0, 0.0), "-z": (0.0, 0.0, -1.0),
    "-x": (-1.0, 0.0, 0.0),
}  # fmt: skip
"""Directions upwards, by the axis along which they point."""
OTHER = "another"
"""Word for a direction, or a largest part of increases and decreases, that a project has from elsewhere."""
AS_ASKED = "as many as the mesh asks"
SHAPING_PARTS: dict[str, float | None] = {AS_ASKED: None, **{f"1 in {count}": 1.0 / count for count in (2, 3, 4, 6, 8)}}
"""Largest parts of the stitches of a row that are increases or decreases, in words."""

PLACEMENTS: dict[str, Placement] = {"spread over the row": "spread", "at seams and edges": "seams"}
"""Where increases and decreases stand, in words."""


class SizePanel:
    """Controls of all that is neither a mark nor the size of a stitch."""

    def __init__(self, shaping: Shaping, controls: Controls, change: Callable[..., object]) -> None:
        """Make the controls; ``change`` takes values of the shaping by name, as ``RowsState.with_sizes`` does."""
        self._change = change
        self._up = controls.choice(
            "Knitted towards", "Direction in which the garment is knitted, where no mark says it.",
            _directions(shaping), "+y", self._set_up,
        )  # fmt: skip
        self._multiple = controls.number(
            "Multiple of", "The stitches of each round are a multiple of this number, for a pattern that repeats.", 1,
            lambda value: change("multiple", multiple=int(value)), least=1, most=1000, step=1,
        )  # fmt: skip
        self._short_rows = controls.toggle(
            "Short rows", "The yarn turns back and comes again where rows are far too high, as at a heel.",
            shaping.short_rows, lambda value: change(short_rows=value),
        )  # fmt: skip
        self._most_shaping = controls.choice(
            "Increases in a row", "Largest part of the stitches of a row that are increases or decreases; rows that "
            "would need more are stretched.", _shaping_parts(shaping), AS_ASKED, self._set_most_shaping,
        )  # fmt: skip
        self._placement = controls.choice(
            "Shaping", "Increases and decreases are spread over the row, or stacked at the sides of a tube, at raglan "
            "lines and at both edges of flat rows, in a steady rhythm.", tuple(PLACEMENTS), next(iter(PLACEMENTS)),
            lambda words: change(shaping=PLACEMENTS[words]),
        )  # fmt: skip
        self._increase = increase_choice(
            controls, shaping.increase, lambda increase: change(increase=increase)
        )  # fmt: skip
        self.show(shaping)

    def show(self, shaping: Shaping) -> None:
        """Show the values of a shaping."""
        self._up.value = next((name for name, up in UPWARDS.items() if up == shaping.up), OTHER)
        self._multiple.value, self._short_rows.value = shaping.multiple, shaping.short_rows
        self._placement.value = next(words for words, where in PLACEMENTS.items() if where == shaping.shaping)
        self._increase.value = WORDS[shaping.increase]
        parts = SHAPING_PARTS.items()
        self._most_shaping.value = next((name for name, part in parts if part == shaping.most_shaping), OTHER)

    def _set_up(self, name: str) -> None:
        if name in UPWARDS:
            self._change(up=UPWARDS[name])

    def _set_most_shaping(self, name: str) -> None:
        if name in SHAPING_PARTS:
            self._change(most_shaping=SHAPING_PARTS[name])


def _directions(shaping: Shaping) -> tuple[str, ...]:
    """The directions to choose from; one that a project has from elsewhere too."""
    return tuple(UPWARDS) if shaping.up in UPWARDS.values() else (*UPWARDS, OTHER)


def _shaping_parts(shaping: Shaping) -> tuple[str, ...]:
    """The largest parts to choose from; one that a project has from elsewhere too."""
    known = shaping.most_shaping in SHAPING_PARTS.values()
    return tuple(SHAPING_PARTS) if known else (*SHAPING_PARTS, OTHER)
