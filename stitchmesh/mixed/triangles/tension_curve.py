# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stress over strain along one axis of a cloth: a curve through given points whose slope is continuous.

Between the points, the stress S is a cubic function of the Green strain E that never falls (Fritsch and Butland 1984).
At an inner point its slope is the harmonic mean of the slopes of the two chords that meet there, weighted by their
lengths; at an end it is the slope of the chord. Beyond the ends the curve continues as a straight line. The energy
density is the integral of the stress from strain 0. A stiffness that depends on the strain therefore still follows from
an energy, and the second derivative of this energy is continuous. One point with a slope is a linear law.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TensionCurve:
    """A stress that rises with the strain, and its energy.

    Raises:
        ParameterError: the strains or the stresses do not rise, or the curve does not pass through the origin.
    """

    strain: FloatArray
    """Green strain of each node, ascending, shape (n,)."""
    stress: FloatArray
    """Second Piola-Kirchhoff stress of each node [dyn / cm], ascending, shape (n,)."""
    slope: FloatArray
    """Slope of the stress at each node [dyn / cm], shape (n,)."""

    @staticmethod
    def linear(modulus: float) -> TensionCurve:
        """The law S = modulus E."""
        return TensionCurve(np.zeros(1), np.zeros(1), np.array([float(modulus)]))

    @staticmethod
    def through(strain: FloatArray, stress: FloatArray, place: str) -> TensionCurve:
        """The curve through points.

        Args:
            strain: Green strain of each point, ascending, shape (n,) with n at least 2.
            stress: stress of each point [dyn / cm], shape (n,).
            place: name of the table, for messages.

        Raises:
            ParameterError: the strains or the stresses do not rise, or no point is (0, 0).
        """
        strain, stress = np.asarray(strain, dtype=np.float64), np.asarray(stress, dtype=np.float64)
        if len(strain) < 2 or not np.isfinite([strain, stress]).all():
            raise ParameterError(f"{place}: got {len(strain)} points; expected at least two points of finite numbers")
        falls = np.flatnonzero((np.diff(strain) <= 0.0) | (np.diff(stress) <= 0.0))
        if len(falls):
            raise ParameterError(
                f"{place}: point {int(falls[0]) + 1} is not above point {int(falls[0])}; expected strains and "
                "tensions that rise from point to point (a tension over 1 + strain too)"
            )
        if not ((strain == 0.0) & (stress == 0.0)).any():
            raise ParameterError(f"{place}: no point is (0, 0); expected one, because the rest shape has no tension")
        return TensionCurve(strain, stress, _slopes(strain, stress))

    def at(self, strain: FloatArray) -> FloatArray:
        """Stress at the given Green strains [dyn / cm], of the same shape; beyond its ends the curve is straight."""
        from scipy.interpolate import CubicHermiteSpline

        inside = np.clip(strain, self.strain[0], self.strain[-1])
        if len(self.strain) > 1:
            stress = CubicHermiteSpline(self.strain, self.stress, self.slope)(inside)
        else:
            stress = np.full(strain.shape, self.stress[0])
        beyond: FloatArray = np.where(strain < inside, self.slope[0], self.slope[-1]) * (strain - inside)
        return stress + beyond

    def without(self, other: TensionCurve, place: str) -> TensionCurve:
        """The curve whose stress at the strains of both curves is the difference of their stresses.

        Raises:
            ParameterError: the difference does not rise; the message begins with ``place``.
        """
        strain = np.union1d(self.strain, other.strain)
        return TensionCurve.through(strain, self.at(strain) - other.at(strain), place)

    @property
    def energy(self) -> FloatArray:
        """Energy density at each node [erg / cm^2], zero at strain 0; shape (n,)."""
        step, mean = np.diff(self.strain), (self.stress[1:] + self.stress[:-1]) / 2.0
        whole = np.concatenate([[0.0], np.cumsum(step * (mean - step * np.diff(self.slope) / 12.0))])
        energies: FloatArray = whole - whole[np.flatnonzero(self.strain == 0.0)[0]]
        return energies

    @property
    def least_slope(self) -> float:
        """Smallest slope anywhere on the curve [dyn / cm]."""
        slopes = [float(self.slope.min())]
        for k in range(len(self.strain) - 1):
            chord = (self.stress[k + 1] - self.stress[k]) / (self.strain[k + 1] - self.strain[k])
            a, b = self.slope[k], self.slope[k + 1]
            curvature = 3.0 * (a + b - 2.0 * chord)  # of the slope, a parabola over the interval from 0 to 1
            rise = 2.0 * (3.0 * chord - 2.0 * a - b)
            at = -rise / (2.0 * curvature) if curvature > 0.0 else -1.0
            if 0.0 < at < 1.0:
                slopes.append(float(a + rise * at + curvature * at * at))
        return min(slopes)

    @property
    def nodes(self) -> FloatArray:
        """Strain, stress, slope and energy density of each node, shape (n, 4); the rows that the kernels read."""
        return np.column_stack([self.strain, self.stress, self.slope, self.energy])


def _slopes(strain: FloatArray, stress: FloatArray) -> FloatArray:
    """Slopes at the nodes with which the cubic curve rises everywhere."""
    step = np.diff(strain)
    chord = np.diff(stress) / step
    before, after = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
    inner = (before + after) / (before / chord[:-1] + after / chord[1:])
    return np.concatenate([chord[:1], inner, chord[-1:]])
