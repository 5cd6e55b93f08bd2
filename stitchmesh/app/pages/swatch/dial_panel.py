# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The dials of a design as controls; dials without effect on the pattern are hidden."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TypeAlias

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.field_panel import Field, FieldPanel, Number, TickBox, setting_field
from stitchmesh.app.pages.gauge_panel import GROUP, add_yarn_choice, name_of
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.swatch_design import SwatchDesign, SwatchDials, acting_dials, dials_of_yarn
from stitchmesh.yarn.yarn_description import LIBRARY
from stitchmesh.yarn.yarn_presets import Yarn, yarn_names

OPENED = ("Fabric", "Yarn lengths (factors)")
"""Groups that are open at first."""
LENGTH = Number(0.1, 2.0, 0.01, slider=True)
"""Factor of a length."""
STIFFNESS = Number(0.001, 1000.0, 0.1)
"""Factor of a stiffness."""
Dial: TypeAlias = tuple[str, str, Number]
"""Field of ``SwatchDials``, label and useful values of a dial."""
FABRIC: tuple[Dial, ...] = (
    ("gamma", "Tightness", Number(0.6, 2.0, 0.01, slider=True)),
    ("loop_length", "Loop length", Number(0.1, 10.0, 0.01, slider=True)),
    ("warp_spacing", "Warp spacing", LENGTH),
    ("weft_spacing", "Weft spacing", LENGTH),
    ("yarn_radius", "Yarn radius", Number(0.005, 0.4, 0.001, slider=True)),
)
"""Dials of the fabric as a whole."""
LENGTHS: tuple[Dial, ...] = (
    ("floats", "Floats", LENGTH), ("held", "Held loops", LENGTH), ("warp", "Warp length", LENGTH),
    ("weft", "Weft length", LENGTH),
)  # fmt: skip
"""Dials of yarn lengths, as factors."""
STIFFNESSES: tuple[Dial, ...] = (
    ("k_bend", "Bending", STIFFNESS), ("k_length", "Stretch", STIFFNESS), ("k_len", "Even stretch", STIFFNESS),
    ("k_contact", "Contact", STIFFNESS), ("mass", "Yarn weight", Number(0.1, 10_000.0, 1.0)),
)  # fmt: skip
"""Dials of the yarn itself."""
REPEATS: tuple[Dial, ...] = (
    ("columns", "Repeats across", Number(1, 8, 1)),
    ("rows", "Repeats upwards", Number(1, 8, 1)),
)
"""Dials of the repeat."""
SIZES = (
    ("width", "Hold the width", "Width of a repeat"),
    ("height", "Hold the height", "Height of a repeat"),
)
"""Field of ``SwatchDials``, the box that holds a size of the repeat, and the number of the held size."""


def yarn_of_dials(design: SwatchDesign) -> Yarn | None:
    """Return the yarn to which the dials of a design are set; None if they match no yarn."""
    for yarn in map(Yarn.named, (*yarn_names(), *LIBRARY)):
        if all(getattr(design.dials, name) == value for name, value in dials_of_yarn(yarn, design.pattern).items()):
            return yarn
    return None


class DialPanel:
    """The dials of the edited design."""

    def __init__(
        self, controls: Controls, design: SwatchDesign, changed: Callable[[SwatchDesign], object]
    ) -> None:  # fmt: skip
        """Make the controls; ``changed`` is called with the design that the user wants."""
        self._changed, self._design = changed, design
        self._acting = acting_dials(design.pattern)
        self._frame: Frame | None = None
        with controls.group(GROUP):
            self._yarn = add_yarn_choice(controls, yarn_of_dials(design), self._take_yarn)
        groups = {
            "Fabric": [*map(self._field, FABRIC), *self._sizes()],
            "Yarn lengths (factors)": [*map(self._field, LENGTHS)],
            "Stiffness and weight of the yarn": [*map(self._field, STIFFNESSES)],
            "Repeats that relax together": [*map(self._field, REPEATS)],
        }
        self._panels = [
            FieldPanel(
                controls, fields, lambda: self._design, lambda wanted, name: changed(wanted), group=group,
                opened=group in OPENED,
            )
            for group, fields in groups.items()
        ]  # fmt: skip
        self.show(design)

    def show(self, design: SwatchDesign, frame: Frame | None = None) -> None:
        """Show the dials of a design; a frame gives the size at which a hold begins."""
        self._frame = frame or self._frame
        if design.pattern is not self._design.pattern:
            self._acting = acting_dials(design.pattern)
        self._design = design
        self._yarn.value = name_of(yarn_of_dials(design))
        for panel in self._panels:
            panel.show()

    def _field(self, dial: Dial) -> Field:
        name, label, form = dial
        shown = lambda design: name in self._acting  # noqa: E731
        return setting_field(SwatchDials, name, label, form, at=f"dials.{name}", shown=shown)

    def _sizes(self) -> Iterator[Field]:
        for axis, (name, hold, label) in enumerate(SIZES):
            box = TickBox(
                hold, "Keep this size of the repeat; otherwise the fabric finds its own", partial(self._size, axis),
                ticked_without=False,
            )  # fmt: skip
            yield self._field((name, label, Number(0.01, 1000.0, 0.01, without=None, box=box)))

    def _size(self, axis: int, design: SwatchDesign) -> float:
        """Return the present width or height of the repeat, at which a hold begins."""
        return 1.0 if self._frame is None else round(self._frame.size[axis], 2)

    def _take_yarn(self, yarn: Yarn | None) -> None:
        if yarn is not None:
            self._changed(self._design.turned(**dials_of_yarn(yarn, self._design.pattern)))
