# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls for the choices of the page Yarns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.pages.yarns.settings import AUTOMATIC, YarnSettings
from stitchmesh.compute.device import device_names
from stitchmesh.io.units import CENTIMETRES
from stitchmesh.quality import PRESETS
from stitchmesh.yarngen.finish import BIND_OFFS, CAST_ONS
from stitchmesh.yarnrelax.model.material import NAMED

DEFAULT_MOST = 1000
"""Iterations that are proposed where the user limits them."""


class Choices:
    """Controls that call a function with the fields of ``YarnSettings`` that change."""

    def __init__(self, controls: Controls, settings: YarnSettings, changed: Callable[..., None]) -> None:
        """Make the functions; ``yarn_group`` and the others make the controls."""
        self._controls, self._settings, self._changed = controls, settings, changed
        self.made: list[Control] = []
        """All controls, which the page disables while a relaxation runs."""

    def yarn_group(self, usual_radius: float) -> None:
        """Make the controls of the generation; the usual radius of the yarn [cm] is shown where none was given."""
        settings = self._settings
        with self._controls.group("Accuracy and edges", opened=False):
            self._choice("Quality", "quality", "Accuracy and cost: draft is fast, reference is exact", PRESETS)
            self._automatic(
                "Automatic yarn radius", "Take the radius of the yarn, or an eighth of the width of a stitch",
                "Yarn radius [cm]", "yarn_radius", "Radius of the yarn where it touches", usual_radius,
                least=0.001, most=5.0, step=0.005,
            )  # fmt: skip
            self._choice("Cast-on", "cast_on", "First rows: backward loops cannot unravel, open loops can", CAST_ONS)
            self._choice("Bind-off", "bind_off", "Last rows: a chain of loops, or a yarn drawn through", BIND_OFFS)
            self._choice("Material", "material", "Stiffness of the yarn: that of stitchmesh, or a published one", NAMED)
            devices = [AUTOMATIC, *device_names()]
            if settings.device not in devices:  # The project comes from another machine.
                self._changed(device=AUTOMATIC)
            self._choice("Device", "device", "Processor that relaxes; automatic takes a GPU if there is one", devices)
            self._automatic(
                "Automatic end", "End at rest, or after the iterations of the quality",
                "Most iterations", "most_iterations", "Iterations after which it ends", DEFAULT_MOST,
                least=1, most=1_000_000, step=100,
            )  # fmt: skip

    def force_group(self) -> None:
        """Make the controls of lengths and forces."""
        with self._controls.group("Lengths and forces", opened=False):
            self._toggle("Keep the shape", "keep_shape", "Hold the borders and the shape of the garment")
            self._number(
                "Yarn length", "rest_length", "Factor of the length of all yarn: less than 1 makes the fabric tighter",
                least=0.5, most=1.5, step=0.01,
            )  # fmt: skip
            self._number(
                "Gravity", "gravity", "Weight of the yarn over that on Earth; 0 is none", least=0.0, most=10.0, step=0.1
            )
            self._number(
                "Friction", "friction", "Coefficient of friction of yarns; 0 is none", least=0.0, most=2.0, step=0.05
            )
            self._choice("Unit of the body", "body_unit", "Unit of a body file that states no unit", CENTIMETRES)

    def set_disabled(self, disabled: bool) -> None:
        """Let all controls take input, or none of them."""
        for control in self.made:
            control.disabled = disabled

    def _choice(self, label: str, field: str, hint: str, options: Any) -> None:
        names = list(options)
        value = getattr(self._settings, field)
        value = value if value in names else names[0]
        self.made.append(self._controls.choice(label, hint, names, value, lambda new: self._changed(**{field: new})))

    def _toggle(self, label: str, field: str, hint: str) -> None:
        value = getattr(self._settings, field)
        self.made.append(self._controls.toggle(label, hint, value, lambda new: self._changed(**{field: new})))

    def _automatic(
        self, toggle: str, toggle_hint: str, label: str, field: str, hint: str, usual: float, *,
        least: float, most: float, step: float,
    ) -> None:  # fmt: skip
        """Make a box that leaves a number to the program, and the number, which is hidden while the box is ticked."""
        given = getattr(self._settings, field)
        kind = type(given)
        number = self._controls.number(
            label, hint, given or usual, lambda new: self._changed(**{field: kind(new)}), least=least, most=most,
            step=step,
        )  # fmt: skip
        number.visible = bool(given)

        def choose(automatic: bool) -> None:
            number.visible = not automatic
            self._changed(**{field: kind(0 if automatic else number.value)})

        self.made += [self._controls.toggle(toggle, toggle_hint, not given, choose), number]

    def _number(self, label: str, field: str, hint: str, *, least: float, most: float, step: float) -> None:
        value = getattr(self._settings, field)
        kind = type(value)
        control = self._controls.number(
            label, hint, value, lambda new: self._changed(**{field: kind(new)}), least=least, most=most, step=step
        )
        self.made.append(control)
