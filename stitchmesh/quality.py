# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Accuracy as a dial: how finely yarns are sampled and how far they are relaxed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

from stitchmesh.errors import ParameterError

Precision = Literal["float32", "float64"]
Solver = Literal["quasistatic", "dynamics"]


@dataclass(frozen=True)
class Quality:
    """What a relaxation may cost."""

    precision: Precision
    """Floating-point type of the solver."""
    quadrature_points: int
    """Gauss points a segment for stretch, length and bending."""
    contact_samples: int
    """Contact spheres a segment."""
    control_points_per_stitch: int
    """Control points of a plain stitch."""
    step_fraction: float
    """Largest move of a control point in one iteration, as a part of the yarn radius."""
    tolerance: float
    """Relative force residual at which a relaxation has converged (``yarnrelax.convergence``)."""
    max_iterations: int
    """Iterations after which a relaxation stops without having converged."""
    solver: Solver = "quasistatic"
    """How it comes to rest: "quasistatic", or "dynamics" as in L, Algorithm 1."""


PRESETS: dict[str, Quality] = {
    "draft": Quality("float32", 3, 3, 12, 0.2, 0.01, 6000),
    "standard": Quality("float32", 3, 3, 20, 0.2, 0.005, 20_000),
    "reference": Quality("float64", 11, 11, 24, 0.1, 1e-4, 200_000),
}
"""The presets of the command line."""
DEFAULT_QUALITY = "standard"
"""The preset where no quality is given."""


def quality_named(name: str | Quality) -> Quality:
    """The preset of that name, or the value itself.

    Raises:
        ParameterError: there is no preset of that name.
    """
    if isinstance(name, Quality):
        return name
    if name not in PRESETS:
        raise ParameterError(f"quality: got {name!r}; expected one of {', '.join(PRESETS)}")
    return PRESETS[name]


def quality_with(
    name: str | Quality, *, solver: Solver | None = None, max_iterations: int | None = None
) -> str | Quality:
    """The preset of that name, with another solver or limit of iterations where given.

    Raises:
        ParameterError: there is no preset of that name, or the limit is not positive.
    """
    if max_iterations is not None and max_iterations < 1:
        raise ParameterError(f"max iterations: got {max_iterations}; expected at least 1")
    changes = {"solver": solver, "max_iterations": max_iterations}
    given: dict[str, Any] = {field: value for field, value in changes.items() if value is not None}
    return replace(quality_named(name), **given) if given else name
