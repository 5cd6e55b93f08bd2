# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The dials of a design as controls; those that do not act on the pattern are hidden."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.pages.gauge_panel import DIGITS, GROUP, add_yarn_choice, name_of
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.swatch_design import SwatchDesign, SwatchDials, acting_dials
from stitchmesh.yarn.yarn_presets import Yarn, yarn_names

GRAMS_OF_100_METRES = 100.0
"""1 g/m in g/100 m."""


@dataclass(frozen=True)
class Dial:
    """How a dial is shown."""

    name: str
    """Field of ``SwatchDials``."""
    label: str
    hint: str
    least: float
    most: float
    step: float
    is_slider: bool = True


FABRIC = (
    Dial("gamma", "Tightness", "Gamma: more than 1 shortens all yarn at the same thickness, for a tighter fabric",
         0.6, 2.0, 0.01),
    Dial("loop_length", "Loop length [cm]", "Yarn in one plain stitch; the size of the stitches follows from it",
         1.0, 10.0, 0.01),
    Dial("warp_spacing", "Warp spacing [cm]", "Distance between the warps, as drawn", 0.1, 2.0, 0.01),
    Dial("weft_spacing", "Weft spacing [cm]", "Distance between the wefts, as drawn", 0.1, 2.0, 0.01),
    Dial("yarn_radius", "Yarn radius [cm]", "Half the thickness of the yarn where it touches other yarn",
         0.02, 0.4, 0.001),
)  # fmt: skip
"""Dials of the fabric as a whole."""
LENGTHS = (
    Dial(
        "floats", "Floats", "Factor of yarn that passes slipped stitches or runs behind other colours", 0.1, 2.0, 0.01
    ),
    Dial("held", "Held loops", "Factor of loops that slips and tucks hold over several rows", 0.1, 2.0, 0.01),
    Dial("warp", "Warp length", "Factor of the length of the warps", 0.1, 2.0, 0.01),
    Dial("weft", "Weft length", "Factor of the length of the wefts", 0.1, 2.0, 0.01),
)
"""Dials of yarn lengths, as factors."""
STIFFNESSES = (
    Dial("k_bend", "Bending", "Factor of the resistance of the yarn to bending", 0.01, 100.0, 0.1, False),
    Dial("k_length", "Stretch", "Factor of the resistance of the yarn to a change of its length",
         0.01, 100.0, 0.1, False),
    Dial("k_len", "Even stretch", "Factor of the resistance to stretch that differs along a segment",
         0.01, 100.0, 0.1, False),
    Dial("k_contact", "Contact", "Factor of the resistance of touching yarns", 0.01, 100.0, 0.1, False),
    Dial("mass", "Yarn weight [g/100 m]", "Weight of 100 m of the yarn; it decides the weight per area",
         0.1, 10_000.0, 1.0, False),
)  # fmt: skip
"""Dials of the yarn itself."""
REPEATS = (
    Dial(
        "columns", "Repeats across", "Repeats that relax together side by side, so that they may differ", 1, 8, 1, False
    ),
    Dial("rows", "Repeats upwards", "Repeats that relax together one above another", 1, 8, 1, False),
)
"""Dials of the repeat."""
SIZES = (
    ("width", "Hold the width", "Width of a repeat [cm]"),
    ("height", "Hold the height", "Height of a repeat [cm]"),
)


def dials_of_yarn(yarn: Yarn, design: SwatchDesign) -> dict[str, float]:
    """Return the dials that a yarn sets: thickness where it touches, weight, and in a knit the loops of its gauge."""
    dials = {
        "yarn_radius": yarn.core_radius, "loop_length": yarn.gauge.loop_length,
        "mass": GRAMS_OF_100_METRES * yarn.grams_per_metre,
    }  # fmt: skip
    acting = acting_dials(design.pattern)
    return {name: round(value, DIGITS) for name, value in dials.items() if name in acting}


def yarn_of_dials(design: SwatchDesign) -> Yarn | None:
    """Return the yarn to which the dials of a design are set; None if they are set to none."""
    for yarn in map(Yarn.named, yarn_names()):
        if all(getattr(design.dials, name) == value for name, value in dials_of_yarn(yarn, design).items()):
            return yarn
    return None


class DialPanel:
    """The dials of the edited design."""

    def __init__(self, controls: Controls, design: SwatchDesign, turned: Callable[..., object]) -> None:
        """Make the controls; ``turned`` is called with the name and the new value of a dial as a keyword."""
        self._turned, self._design = turned, design
        self._frame: Frame | None = None
        self._dials: dict[str, Control] = {}
        self._holds: dict[str, Control] = {}
        self._groups: dict[str, tuple[Control, tuple[Dial, ...]]] = {}
        with controls.group(GROUP):
            self._yarn = add_yarn_choice(controls, yarn_of_dials(design), self._take_yarn)
        self._group(controls, "Fabric", FABRIC, design, opened=True)
        self._group(controls, "Yarn lengths (factors)", LENGTHS, design, opened=True)
        self._group(controls, "Stiffness and weight of the yarn", STIFFNESSES, design, opened=False)
        self._group(controls, "Repeats that relax together", REPEATS, design, opened=False)
        self.show(design)

    def show(self, design: SwatchDesign, frame: Frame | None = None) -> None:
        """Show the dials of a design; a frame tells the size that a hold takes."""
        self._frame = frame or self._frame
        self._design = design
        self._yarn.value = name_of(yarn_of_dials(design))
        acting = acting_dials(design.pattern)
        for name, control in self._dials.items():
            # One value only, so that no frame of a page shows another.
            control.visible = name in acting and (name not in self._holds or getattr(design.dials, name) is not None)
            value = getattr(design.dials, name)
            if value is not None:
                control.value = value
        for name, control in self._holds.items():
            control.value = getattr(design.dials, name) is not None
        for group, dials in self._groups.values():
            group.visible = any(dial.name in acting for dial in dials)

    def _group(
        self, controls: Controls, label: str, dials: tuple[Dial, ...], design: SwatchDesign, *, opened: bool
    ) -> None:
        """Add a group of dials."""
        with controls.group(label, opened) as group:
            for dial in dials:
                self._add(controls, dial, design.dials)
            if dials is FABRIC:
                for size in SIZES:
                    self._add_size(controls, *size, design.dials)
        self._groups[label] = group, dials

    def _add(self, controls: Controls, dial: Dial, dials: SwatchDials) -> None:
        value = min(max(getattr(dials, dial.name), dial.least), dial.most)
        make = controls.slider if dial.is_slider else controls.number
        self._dials[dial.name] = make(
            dial.label, dial.hint, value, lambda given: self._turned(**{dial.name: given}),
            least=dial.least, most=dial.most, step=dial.step,
        )  # fmt: skip

    def _add_size(self, controls: Controls, name: str, hold: str, label: str, dials: SwatchDials) -> None:
        """Add a box that holds a size of the repeat, and the number that it is held at."""
        size = getattr(dials, name)
        self._holds[name] = controls.toggle(
            hold, "Keep this size of the repeat; otherwise the fabric finds its own", size is not None,
            lambda held: self._hold(name, held),
        )  # fmt: skip
        self._dials[name] = controls.number(
            label, "The fabric is stretched or compressed to this size in small steps", size or 1.0,
            lambda given: self._turned(**{name: given}), least=0.01, most=1000.0, step=0.01,
        )  # fmt: skip

    def _take_yarn(self, yarn: Yarn | None) -> None:
        """Take thickness, weight and loops of a yarn."""
        if yarn is not None:
            self._turned(**dials_of_yarn(yarn, self._design))

    def _hold(self, name: str, held: bool) -> None:
        """Hold the present size, or let it free."""
        now = 1.0 if self._frame is None else self._frame.size[0 if name == "width" else 1]
        self._turned(**{name: round(now, 2) if held else None})
