# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The group Yarn and gauge, the same on all pages where the user chooses a yarn or the size of its stitches.

A project has one yarn. The choice of a yarn sets its usual gauge; the user can then change the size of the stitches,
and the yarn stays. Without a named yarn the size is the user's own.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.controls.field_panel import setting_field
from stitchmesh.app.controls.html_pieces import figures, paragraph, range_html
from stitchmesh.app.project.project import Project
from stitchmesh.markup import Markup
from stitchmesh.mesh.shaping_stitches import Increase
from stitchmesh.periodic.validated_range import gauge_verdict
from stitchmesh.recipe.sections import StitchesSection
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.yarn.yarn_description import LIBRARY
from stitchmesh.yarn.yarn_presets import CENTIMETRES_PER_INCH, GAUGE_LENGTH, Gauge, Yarn, yarn_names
from stitchmesh.yarnrelax.yarn_figures import yarn_figures

GROUP = "Yarn and gauge"
"""Name of the group, and of the project's settings that hold the yarn."""
OWN_YARN = "no named yarn"
"""The entry of the list of yarns if the user gives only sizes."""
SMALLEST, LARGEST = 0.1, 5.0
"""Bounds of the stitch width and of the stitch height [cm]."""
DIGITS = 3
"""Number of decimal digits of the sizes."""
INCREASES: dict[str, Increase] = {
    "make one (m1l, m1r)": "m1", "knit front and back": "kfb", "lifted, from the loop below": "lifted",
    "yarn over, with a hole": "yo",
}  # fmt: skip
"""Forms of increases, by the words of the user."""
INCREASE = setting_field(StitchesSection, "increase", "Increases", INCREASES)
"""Field for the form of increases, on the pages that make stitches."""
FOUR_INCHES = 4.0 * CENTIMETRES_PER_INCH / 10.0
"""Number of stitches in 4 inches over the number in 10 cm."""


def yarn_of(project: Project) -> Yarn | None:
    """Return the yarn of a project; None without a named yarn."""
    name = project.settings(GROUP).get("yarn")
    return Yarn.named(name) if name in yarn_names() or name in LIBRARY else None


def name_of(yarn: Yarn | None) -> str:
    """Return the entry of the list of yarns for a yarn, or for None."""
    return OWN_YARN if yarn is None else yarn.name


def add_yarn_choice(controls: Controls, yarn: Yarn | None, changed: Callable[[Yarn | None], object]) -> Control:
    """Add the list of yarns and the figures of the chosen one; ``changed`` is called with the yarn, or None."""

    def take(name: str) -> None:
        taken = None if name == OWN_YARN else Yarn.named(name)
        table.content = _figures(taken)
        changed(taken)

    choice = controls.choice(
        "Yarn", "A yarn, at its usual gauge.", (OWN_YARN, *yarn_names(), *LIBRARY), name_of(yarn), take
    )  # fmt: skip
    table = controls.html(_figures(yarn))
    return choice


def _figures(yarn: Yarn | None) -> Markup:
    """Return the table of a yarn in all units, and what follows from it; nothing without a yarn."""
    return Markup() if yarn is None else figures((figure.name, figure.value) for figure in yarn_figures(yarn))


def take_yarn(project: Project, yarn: Yarn | None) -> None:
    """Give a yarn to a project, or leave the project without one."""
    project.set_settings(GROUP, {} if yarn is None else {"yarn": yarn.name})


Taken = Callable[[float, float | None, str], object]
"""Function that takes the width of a stitch [cm], its height [cm] or None for the usual height, and what changed."""


class GaugePanel:
    """The yarn, and the size of its stitches."""

    def __init__(
        self, project: Project, controls: Controls, width: float, height: float | None, changed: Taken
    ) -> None:  # fmt: skip
        """Make the controls.

        Args:
            project: the project that keeps the yarn.
            controls: where the controls are added.
            width: width of a stitch [cm].
            height: height of a stitch [cm]; None for the usual one.
            changed: called with another size, and with ``width`` or ``height`` if the user set only that.
        """
        self._project, self._changed = project, changed
        with controls.group(GROUP):
            add_yarn_choice(controls, yarn_of(project), self._take_yarn)
            self._width = controls.slider(
                "Stitch width [cm]", "Distance from one stitch to the next; type it for an exact one.", width,
                lambda width: self._take(width, self._size[1], "width"),
                least=min(SMALLEST, width), most=max(LARGEST, width), step=0.01,
            )  # fmt: skip
            self._usual = controls.toggle(
                "Usual height", "The height of a stitch is 0.77 of its width, as in relaxed stockinette.",
                height is None, self._set_usual,
            )  # fmt: skip
            shown = drawn_height(width, height)
            self._height = controls.slider(
                "Stitch height [cm]", "Distance from one row to the next.", shown,
                lambda height: self._take(self._size[0], height, "height"),
                least=min(SMALLEST, shown) / 2.0, most=max(LARGEST, shown), step=0.01,
            )  # fmt: skip
            self._text = controls.html(Markup())
        self.show(width, height)

    def show(self, width: float, height: float | None) -> None:
        """Show a size [cm]."""
        self._size = width, height
        self._width.value, self._height.value = round(width, DIGITS), round(drawn_height(width, height), DIGITS)
        self._usual.value, self._height.visible = height is None, height is not None
        gauge = gauge_words(Gauge.of_stitch(width, drawn_height(width, height)))
        yarn = yarn_of(self._project)
        self._text.content = paragraph(f"{gauge}{_yarn_words(yarn)}") + _loops_html(yarn, width)

    def _take(self, width: float, height: float | None, what: str = "") -> None:
        self.show(width, height)
        self._changed(width, height, what)

    def _take_yarn(self, yarn: Yarn | None) -> None:
        take_yarn(self._project, yarn)
        self._take(*self._size if yarn is None else (yarn.stitch_width, yarn.stitch_height))

    def _set_usual(self, usual: bool) -> None:
        width, height = self._size
        self._take(width, None if usual else round(drawn_height(width, height), DIGITS))


def _loops_html(yarn: Yarn | None, width: float) -> Markup:
    """Return a box if stockinette of a yarn was not compared with measurements at this stitch width [cm]."""
    if yarn is None:
        return Markup()
    loops = Gauge(GAUGE_LENGTH / width).loop_length / (2.0 * yarn.core_radius)
    verdict = gauge_verdict("stockinette", loops, "wet")
    return Markup() if verdict.good else range_html(verdict)


def drawn_height(width: float, height: float | None) -> float:
    """Return the height of a stitch [cm]; None means the usual height for its width."""
    return COURSE_OVER_WALE_SPACING * width if height is None else height


def gauge_words(gauge: Gauge) -> str:
    """Return a gauge as knitters write it, in centimetres and in inches."""
    stitches, rows = gauge.stitches * FOUR_INCHES, gauge.rows * FOUR_INCHES
    return f"{gauge} ({stitches:.3g} and {rows:.3g} in 4 inches)."


def length_words(centimetres: float) -> str:
    """Return a length in centimetres and in inches."""
    return f"{centimetres:.3g} cm ({centimetres / CENTIMETRES_PER_INCH:.2g} in)"


def _yarn_words(yarn: Yarn | None) -> str:
    """Return how thick a yarn is and which needle fits it; nothing without a yarn."""
    if yarn is None:
        return ""
    thin, thick = yarn.needle
    needle = f", needle {thin:g} to {thick:g} mm" if math.isfinite(thin) else ""
    usual = f"{yarn.gauge.stitches:.3g} stitches in 10 cm"
    return f" {yarn.name}: {length_words(2.0 * yarn.apparent_radius)} thick, usually {usual}{needle}."
