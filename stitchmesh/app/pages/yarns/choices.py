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


class Choices:
    """Controls that call a function with the fields of ``YarnSettings`` that change."""

    def __init__(self, controls: Controls, settings: YarnSettings, changed: Callable[..., None]) -> None:
        """Make the functions; ``yarn_group`` and the others make the controls."""
        self._controls, self._settings, self._changed = controls, settings, changed
        self.made: list[Control] = []
        """All controls, which the page disables while a relaxation runs."""

    def yarn_group(self) -> None:
        """Make the controls of the generation."""
        settings = self._settings
        with self._controls.group("Yarn and accuracy", opened=False):
            self._choice("Quality", "quality", "Accuracy and cost: draft is fast, reference is exact", PRESETS)
            self._number(
                "Yarn radius [cm]", "yarn_radius", "Radius of the yarn where it touches; 0 takes an eighth of a stitch",
                least=0.0, most=5.0, step=0.005,
            )  # fmt: skip
            self._choice("Cast-on", "cast_on", "First rows: backward loops cannot unravel, open loops can", CAST_ONS)
            self._choice("Bind-off", "bind_off", "Last rows: a yarn drawn through loops, or a chain", BIND_OFFS)
            self._choice("Material", "material", "Stiffness of the yarn: that of stitchmesh, or a published one", NAMED)
            devices = [AUTOMATIC, *device_names()]
            if settings.device not in devices:  # The project comes from another machine.
                self._changed(device=AUTOMATIC)
            self._choice("Device", "device", "Processor that relaxes; automatic takes a GPU if there is one", devices)
            self._number(
                "Most iterations", "most_iterations", "Iterations after which it ends; 0 takes those of the quality",
                least=0, most=1_000_000, step=100,
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

    def _number(self, label: str, field: str, hint: str, *, least: float, most: float, step: float) -> None:
        value = getattr(self._settings, field)
        kind = type(value)
        control = self._controls.number(
            label, hint, value, lambda new: self._changed(**{field: kind(new)}), least=least, most=most, step=step
        )
        self.made.append(control)
