# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Presets of accuracy: how finely yarns are sampled, and the residual to which they are relaxed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

from stitchmesh.errors import ParameterError, described

Precision = Literal["float32", "float64"]
Solver = Literal["quasistatic", "dynamics"]

SLIDE = 10.0 / 3.0
"""The least remaining relative change of the spacing, over the residual (``yarnrelax.settling``); ``largest_change``
leaves room for its spread."""

FEWEST = 3
"""Smallest number of contact samples, and of quadrature points, to which refinement reduces a segment."""
ROUNDING = 1e-9
"""Relative rounding error of a number of samples."""


@dataclass(frozen=True)
class Quality:
    """Accuracy of a relaxation, and with it the cost of the relaxation."""

    precision: Precision
    """Floating-point type of the solver."""
    quadrature_points: int
    """Gauss points per segment for stretch, length and bending."""
    contact_samples: int
    """Contact spheres per segment."""
    control_points_per_stitch: int
    """Control points of a plain stitch."""
    step_fraction: float
    """Largest displacement of a control point in one iteration, divided by the yarn radius."""
    tolerance: float
    """Relative force residual at which a relaxation has converged (``yarnrelax.convergence``)."""
    max_iterations: int
    """Iterations after which a relaxation stops without having converged."""
    solver: Solver = "quasistatic"
    """Method of the relaxation: "quasistatic", or "dynamics" (Leaf et al. 2018, Algorithm 1)."""
    largest_change: float = 0.004
    """Largest estimate of the remaining relative change of the spacing at rest. It is only a part of the error that the
    preset promises, because coarse sampling changes the spacing too."""
    refinement: float = 1.0
    """Factor by which a swatch whose size relaxes has more control points in a plain stitch (``periodic.sampling``)."""

    @property
    def resting_residual(self) -> float:
        """The residual near which yarns come to rest: the tolerance, or less where the largest change asks for less."""
        return min(self.tolerance, self.largest_change / SLIDE)

    def refined(self, count: int) -> int:
        """Number of samples of a segment, in place of ``count``, if the segments are shorter by the refinement."""
        return min(count, max(FEWEST, math.ceil(count / self.refinement * (1.0 - ROUNDING))))


PRESETS: dict[str, Quality] = {
    "draft": Quality("float32", 3, 3, 12, 0.2, 0.01, 20_000, largest_change=0.02, refinement=4 / 3),
    "standard": Quality("float32", 3, 3, 20, 0.2, 0.005, 20_000, refinement=1.3),
    "reference": Quality("float64", 11, 11, 24, 0.1, 1e-4, 200_000, largest_change=4e-4, refinement=2.0),
}
"""The presets of the command line, by name."""
DEFAULT_QUALITY = "standard"
"""Name of the preset that applies if no quality is given."""
MORE_DIGITS = "take quality reference (float64), or smaller stiffnesses"
"""Advice for a precision whose digits do not suffice."""


def quality_named(name: str | Quality) -> Quality:
    """Return the preset of a name; a ``Quality`` is returned unchanged.

    Raises:
        ParameterError: there is no preset of that name.
    """
    if isinstance(name, Quality):
        return name
    if not isinstance(name, str):
        raise ParameterError(f"quality: got {described(name)}; expected a Quality, or one of {', '.join(PRESETS)}")
    if name not in PRESETS:
        raise ParameterError(f"quality: got {name!r}; expected one of {', '.join(PRESETS)}")
    return PRESETS[name]


def quality_with(
    name: str | Quality, *, solver: Solver | None = None, max_iterations: int | None = None
) -> str | Quality:
    """Return a preset with another solver or another limit of iterations.

    Args:
        name: name of a preset, or a ``Quality``.
        solver: the other solver; the preset's solver if None.
        max_iterations: the other limit of iterations; the preset's limit if None.

    Returns:
        The changed ``Quality``, or ``name`` itself if nothing is changed.

    Raises:
        ParameterError: there is no preset of that name, or the limit is not positive.
    """
    if max_iterations is not None and max_iterations < 1:
        raise ParameterError(f"max iterations: got {max_iterations}; expected at least 1")
    changes = {"solver": solver, "max_iterations": max_iterations}
    given: dict[str, Any] = {field: value for field, value in changes.items() if value is not None}
    return replace(quality_named(name), **given) if given else name
