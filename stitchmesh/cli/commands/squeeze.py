# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``squeeze``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from tyro.conf import Positional

from stitchmesh.cli.options import Device, Overwrite, QualityName, SwatchFabric, Threads
from stitchmesh.cli.output_folder import output_folder
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import MaterialSection

if TYPE_CHECKING:
    from stitchmesh.periodic.squeeze import SqueezePoint

TABLE, PLOT = "squeeze.csv", "squeeze.png"
"""Files in the output folder."""


@dataclass(frozen=True)
class SqueezeCommand:
    """Squeeze a swatch between two plates, and measure thickness against pressure."""

    pattern: Annotated[Positional[str], help_entry("PATTERN")]
    """pattern or weave: a name of `stitchmesh patterns`, or a file"""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for squeeze.csv and squeeze.png"""
    to: Annotated[float, help_entry("PART")] = 0.5
    """last thickness over the free thickness"""
    steps: int = 6
    """number of thicknesses below the free one"""
    compression: Literal["stiff", "van-wyk"] = "van-wyk"
    """how yarn resists: soft as a mass of fibres (van Wyk), or as usual; the transverse modulus is the same"""
    material: MaterialSection = field(default_factory=MaterialSection)
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    threads: Threads = None
    fabric: SwatchFabric = field(default_factory=SwatchFabric)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Compute the curve, and write its table and its plot."""
        if not (0.0 < self.to < 1.0 and 1 <= self.steps <= 1000):
            found = f"squeeze: got --to {self.to:g} and --steps {self.steps}"
            raise ParameterError(f"{found}; expected a part of the thickness below 1, and 1 to 1000 steps")
        from stitchmesh.periodic.resolve_pattern import resolve_pattern
        from stitchmesh.periodic.squeeze import squeeze_test, write_squeeze
        from stitchmesh.periodic.weave.weave import Weave
        from stitchmesh.render.plots.squeeze_plot import plot_squeeze
        from stitchmesh.run import Run

        pattern = resolve_pattern(self.pattern)
        options = self.fabric.options(woven=isinstance(pattern, Weave))
        yarn = self.fabric.yarn.yarn
        material = self.material.yarn_material(options["yarn_radius"], options["mass_per_length"], yarn)
        parts = np.linspace(1.0, self.to, self.steps + 1)[1:].tolist()
        with output_folder(self.output, (TABLE, PLOT)) as folder:
            run: Run[SqueezePoint] = Run(on_state=_print_state)
            curve = squeeze_test(
                pattern, parts, material=material.compressed_by(self.compression), quality=self.quality,
                device=self.device, run=run, **options,
            )  # fmt: skip
            write_squeeze(folder / TABLE, curve)
            plot_squeeze(curve, folder / PLOT)
        if (lost := curve.compressibility) is not None:
            say(f"From 0.5 to 50 gf/cm2 the fabric loses {lost:.1%} of its thickness.")
        say(str(curve.ranges))


def _print_state(point: SqueezePoint) -> None:
    """Print one state of the curve as a line."""
    convergence = "" if point.converged else ", not converged"
    flat = f"the flattest section is {point.flattening:.2f} as high as wide"
    say(f"{point.thickness:.4g} cm at {point.pressure * 1e-4:.4g} kPa, {flat}{convergence}", flush=True)
