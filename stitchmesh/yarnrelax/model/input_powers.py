# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The dependence of the constants on the device on the inputs of a relaxation, for derivatives by the inputs.

Each constant is a product of powers of the inputs. A factor of one input therefore changes the constant in its place,
by a power of this factor. The topology does not change, and neither do the numbers of contact samples nor the
neighbours of a segment along its yarn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.model.constants import Model

INPUTS = ("loop_length", "radius", "planes", "k_len", "k_length", "k_bend", "k_contact")
"""All rest lengths together, all radii, the distance between the planes of a confinement, and stiffnesses."""


@dataclass(frozen=True, eq=False)
class InputPowers:
    """Constants that are proportional to powers of inputs."""

    constants: wp.array[Any]
    """Scalars, or vectors, on the device."""
    powers: Sequence[Mapping[str, float]]
    """The powers of the inputs in a scalar, or in each component of a vector; 0 for an input that is missing."""

    def factors(self, name: str, factor: float) -> Any:
        """Return the factors of the components that result from a factor of an input, shape (1,) or (k,)."""
        return np.array([factor ** own.get(name, 0.0) for own in self.powers])


def powers_of_model(model: Model) -> list[InputPowers]:
    """Return the dependence of the constants of a model on the inputs."""
    constants = model.constants
    of_segments = [{"k_len": 1.0}, {"k_length": 1.0}, {"k_bend": 1.0}]
    return [
        InputPowers(constants.segment_rest_length, [{"loop_length": 1.0}]),
        InputPowers(constants.segment_stiffness, of_segments),
        InputPowers(constants.sample_weight, [{"loop_length": 1.0}]),
        InputPowers(constants.sample_stiffness, [{"loop_length": 1.0, "k_contact": 1.0}]),
        InputPowers(constants.yarn_radius, [{"radius": 1.0}]),
    ]
