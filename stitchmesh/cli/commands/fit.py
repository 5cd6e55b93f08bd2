# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``fit``."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.options import Device, Overwrite, QualityName, Threads
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.fit_settings import FitSettings
from stitchmesh.quality import DEFAULT_QUALITY

if TYPE_CHECKING:
    from stitchmesh.periodic.yarn_fit import YarnFit

SUFFIX = ".toml"


@dataclass(frozen=True)
class FitCommand:
    """Fit a yarn to measured load-extension curves and the gauge of a swatch."""

    pattern: Annotated[str, help_entry("PATTERN")]
    """pattern of the swatch: a name of `stitchmesh patterns`, or a file"""
    output: Annotated[str, help_entry("FILE", short="-o")]
    """description of the fitted yarn (.toml), for --yarn; the curves are written beside it (.csv, .png)"""
    curves: Annotated[Positional[tuple[str, ...]], help_entry("CURVES", "none, only the gauge")] = ()
    """tables (.csv) with the columns direction, strain [%] and load [N/m], or others (docs/how-to/fit.md)"""
    yarn: Annotated[str | None, help_entry("NAME|FILE", "the default material, for loops of 16.67 diameters")] = None
    """yarn from which the fit starts, and whose other properties stay"""
    settings: Annotated[FitSettings, arg(name="")] = field(default_factory=FitSettings)
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    threads: Threads = None
    overwrite: Overwrite = False

    def run(self) -> None:
        """Fit the yarn, and write its description, the curves and their plot.

        Raises:
            ParameterError: the output is no TOML file.
        """
        from stitchmesh.io.measured_curves import read_measured_curves
        from stitchmesh.io.outputs import plan_outputs
        from stitchmesh.io.yarn_files import write_yarn
        from stitchmesh.periodic.yarn_fit import fit_yarn, write_fit

        path = Path(self.output)
        if path.suffix.lower() != SUFFIX:
            raise ParameterError(f"output: got {self.output}; expected the name of a description, such as yarn{SUFFIX}")
        table, plot = path.with_suffix(".csv"), path.with_suffix(".png")
        curves = [curve for name in self.curves for curve in read_measured_curves(name)]
        plan_outputs([path, *((table, plot) if curves else ())])
        fit = fit_yarn(
            curves, self.pattern, yarn=self.yarn, quality=self.quality, device=self.device, **vars(self.settings)
        )  # fmt: skip
        write_yarn(path, fit.yarn)
        if curves:
            from stitchmesh.render.plots.fit_plot import plot_fit

            write_fit(table, fit)
            plot_fit(fit, plot)
        for line in _lines(fit):
            say(line)
        say(f"Wrote {self.output}; knit with it: --yarn {self.output}")


def _lines(fit: YarnFit) -> list[str]:
    """Return the lines that say what was found."""
    lines = [f"  {each.name:18} {each.text}" for each in fit.values]
    lines += [
        f"  {f'curve, {each.measured.direction}':18} {100.0 * each.error:.3g} % rms, the other size "
        f"{each.measured.other}" for each in fit.curves
    ]  # fmt: skip
    measured = "" if fit.measured_gauge is None else f"; measured {fit.measured_gauge}"
    lines.append(f"  {'gauge':18} {fit.gauge}{measured}")
    lines += [f"Cannot be told: {clause}." for clause in fit.cannot_tell]
    if not fit.converged:
        lines.append("Not good: the search did not settle; see the plot, give fewer values (--fit) or a finer quality.")
    return lines
