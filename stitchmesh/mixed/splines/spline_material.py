# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The material of B-spline yarns in the mixed system: stiffnesses for their radius, and the density of samples."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL, YarnMaterial


@dataclass(frozen=True)
class SplineMaterial:
    """Stiffnesses and sampling.

    Raises:
        ParameterError: the yarn has no mass, or a count is below 1.
    """

    yarn: YarnMaterial
    """Stiffness and mass of the yarn, for its radius."""
    quadrature_points: int = 3
    """Gauss points for each segment."""
    contact_samples: int = 4
    """Contact samples for each segment; long segments have more. A segment may become 2.6 radii long for each
    sample."""

    def __post_init__(self) -> None:
        if not self.yarn.mass_per_length > 0.0:
            raise ParameterError(f"spline yarns: got a mass of {self.yarn.mass_per_length} g/cm; expected more than 0")
        for name in ("quadrature_points", "contact_samples"):
            if getattr(self, name) < 1:
                raise ParameterError(f"spline yarns: {name}: got {getattr(self, name)}; expected at least 1")

    @staticmethod
    def named(name: str = DEFAULT_MATERIAL, *, radius: float) -> SplineMaterial:
        """A named material of ``YarnMaterial`` for yarn of a radius [cm].

        Raises:
            ParameterError: there is no material of that name, or the radius is not positive.
        """
        return SplineMaterial(YarnMaterial.named(name).of_radius(radius))

    @property
    def density(self) -> float:
        """Mass per length of yarn [g/cm]."""
        return self.yarn.mass_per_length
