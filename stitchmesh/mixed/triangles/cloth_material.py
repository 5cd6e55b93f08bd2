# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of cloth: orthotropic moduli along courses and wales (wefts and warps).

Axis 1 runs along the courses of a knit or the wefts of a weave, axis 2 along the wales or the warps. The moduli of a
material belong to a strip that is pulled along an axis with free sides. With the Green strains e = (E_11, E_22, 2 E_12)
and the Poisson ratio nu, the geometric mean of the ratios of both directions,

    C_11 = Y_1 / (1 - nu^2),   C_22 = Y_2 / (1 - nu^2),   C_12 = nu sqrt(Y_1 Y_2) / (1 - nu^2),   C_33 = shear

A strip that is pulled along axis 1 contracts by nu sqrt(Y_1 / Y_2) times its strain. The matrix is positive definite
exactly if the moduli are positive and |nu| < 1. Bending has the same form in the curvatures
(kappa_11, kappa_22, 2 kappa_12), with the rigidities of a strip and a stiffness against twist. An isotropic plate of
flexural rigidity D and ratio nu has the rigidities D (1 - nu^2) and the twist D (1 - nu) / 2; an isotropic membrane has
the shear Y / (2 + 2 nu).

Moments with which the flat cloth curls, as a knit does at its borders, give bending a rest state that is not flat: the
moments are the rigidities times the curvatures of this state.

A table of tensions replaces the linear law along an axis, C_11 E_11 or C_22 E_22. It gives the tension [dyn per cm of
cloth at rest] over the strain (length over rest length - 1) of a strip that keeps its width. A table of coupling
replaces C_12 by a stress over E_11 + E_22 that acts along both axes; this stress is therefore the tension across a
strip that keeps its width. The coupling of a knit that stiffens may then exceed the bound of C_12 at rest.
``material_file`` holds named materials.

*Tables.* A ``TensionCurve`` is the stress over the strain along one axis: a curve through given points whose slope is
continuous. Between the points, the stress S is a cubic function of the Green strain E that never falls (Fritsch and
Butland 1984). At an inner point its slope is the harmonic mean of the slopes of the two chords that meet there,
weighted by their lengths; at an end it is the slope of the chord. Beyond the ends the curve continues as a straight
line. The energy density is the integral of the stress from strain 0. A stiffness that depends on the strain therefore
still follows from an energy, and the second derivative of this energy is continuous. One point with a slope is a linear
law.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError

Table = tuple[tuple[float, float], ...]
"""Pairs of strain and tension [dyn / cm], ascending, through (0, 0)."""


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


POSITIVE = ("stretch_course", "stretch_wale", "shear", "bending_course", "bending_wale", "density")
NOT_NEGATIVE = ("damping", "mass_damping")


@dataclass(frozen=True)
class ClothMaterial:
    """A material of cloth.

    Raises:
        ParameterError: a modulus, a rigidity or the density is not positive, a Poisson ratio is not between -1 and 1, a
            damping is negative, or a table of tensions does not rise or is too flat for the coupling of both axes.
    """

    name: str
    """Name of the material."""
    stretch_course: float
    """Young's modulus times thickness along the courses or wefts [dyn / cm]."""
    stretch_wale: float
    """Young's modulus times thickness along the wales or warps [dyn / cm]."""
    shear: float
    """Shear modulus times thickness [dyn / cm]."""
    poisson: float
    """Geometric mean of the Poisson ratios of both directions."""
    bending_course: float
    """Bending rigidity of a strip along the courses or wefts [dyn cm]."""
    bending_wale: float
    """Bending rigidity of a strip along the wales or warps [dyn cm]."""
    density: float
    """Mass per area [g / cm^2]."""
    bending_poisson: float = 0.0
    """Geometric mean of the Poisson ratios of bending."""
    twist: float | None = None
    """Rigidity against twist [dyn cm], the energy per area over half the square of 2 kappa_12; by default the twist of
    an isotropic plate, (B_1 B_2)^(1/2) / (2 + 2 nu) with the Poisson ratio nu of bending."""
    moment_course: float = 0.0
    """Moment with which the flat cloth curls its courses or wefts towards the side of the normals [dyn]."""
    moment_wale: float = 0.0
    """The same moment for the wales or warps [dyn]."""
    damping: float = 0.0
    """Rayleigh damping proportional to stiffness [s]."""
    mass_damping: float = 0.0
    """Rayleigh damping proportional to mass [1 / s]."""
    tension_course: Table = ()
    """Strain and tension [dyn / cm] along the courses or wefts; none for the linear law."""
    tension_wale: Table = ()
    """Strain and tension [dyn / cm] along the wales or warps; none for the linear law."""
    shear_table: Table = ()
    """Strain 2 E_12 and shear stress S_12 [dyn / cm] from (0, 0) upwards, the same for both signs; none for the linear
    law. Yarns of constant length that have the strain 2 E_12 between them turn towards each other by its arc sine."""
    coupling_table: Table = ()
    """Sum of strains E_11 + E_22 and the stress that it adds along both axes [dyn / cm]; none for the linear law."""
    source: str = ""
    """Where the numbers come from."""

    def __post_init__(self) -> None:
        for name in POSITIVE + NOT_NEGATIVE + (("twist",) if self.twist is not None else ()):
            value, least = getattr(self, name), "not negative" if name in NOT_NEGATIVE else "positive"
            if not (np.isfinite(value) and (value > 0.0 or (value == 0.0 and name in NOT_NEGATIVE))):
                raise ParameterError(f"material {self.name!r}: {name} is {value}; expected a {least} number")
        for name in ("poisson", "bending_poisson"):
            if not abs(getattr(self, name)) < 1.0:
                found = f"{name} is {getattr(self, name)}"
                raise ParameterError(f"material {self.name!r}: {found}; expected between -1 and 1, for a stable cloth")
        for name in ("moment_course", "moment_wale"):
            if not np.isfinite(getattr(self, name)):
                found = f"{name} is {getattr(self, name)}"
                raise ParameterError(f"material {self.name!r}: {found}; expected a finite number")
        for name in ("tension_course", "tension_wale", "shear_table", "coupling_table"):
            object.__setattr__(self, name, tuple(tuple(map(float, point)) for point in getattr(self, name)))
        self._check_tables()

    @staticmethod
    def isotropic(name: str, stretch: float, poisson: float, rigidity: float, density: float) -> ClothMaterial:
        """An isotropic cloth.

        Args:
            name: name of the material.
            stretch: Young's modulus times thickness [dyn / cm].
            poisson: Poisson ratio of stretch and of bending.
            rigidity: flexural rigidity D of a plate [dyn cm].
            density: mass per area [g / cm^2].
        """
        strip = rigidity * (1.0 - poisson**2)
        shear = stretch / (2.0 + 2.0 * poisson)
        return ClothMaterial(name, stretch, stretch, shear, poisson, strip, strip, density, bending_poisson=poisson)

    def moduli(self) -> NDArray[np.float64]:
        """Moduli C of the linear law [dyn / cm], shape (3, 3), for E_11, E_22, 2 E_12."""
        return _orthotropic(self.stretch_course, self.stretch_wale, self.poisson, self.shear)

    def rigidities(self) -> NDArray[np.float64]:
        """Rigidities of bending [dyn cm], shape (3, 3), for kappa_11, kappa_22, 2 kappa_12."""
        course, wale = self.bending_course, self.bending_wale
        isotropic = (course * wale) ** 0.5 / (2.0 + 2.0 * self.bending_poisson)
        return _orthotropic(course, wale, self.bending_poisson, isotropic if self.twist is None else self.twist)

    def rest_curvature(self) -> NDArray[np.float64]:
        """Curvatures kappa_11, kappa_22 and 2 kappa_12 without moments [1 / cm], towards the normals; shape (3,)."""
        moments = np.array([self.moment_course, self.moment_wale, 0.0])
        curvature: NDArray[np.float64] = np.linalg.solve(self.rigidities(), moments)
        return curvature

    def curves(self) -> tuple[TensionCurve, TensionCurve, TensionCurve]:
        """The laws of stress over strain along the courses, along the wales and in shear."""
        moduli, place = self.moduli(), f"material {self.name!r}: "
        course, wale, shear = (TensionCurve.linear(moduli[k, k]) for k in range(3))
        if self.tension_course:
            course = _tension_curve(self.tension_course, f"{place}tension_course")
        if self.tension_wale:
            wale = _tension_curve(self.tension_wale, f"{place}tension_wale")
        if self.shear_table:
            shear = _shear_curve(self.shear_table, f"{place}shear_table")
        return course, wale, shear

    @property
    def coupling(self) -> float:
        """The modulus C_12 [dyn / cm], zero with a table of coupling."""
        return 0.0 if self.coupling_table else float(self.moduli()[0, 1])

    def energies(self) -> tuple[TensionCurve, TensionCurve, TensionCurve, TensionCurve]:
        """The laws of E_11, E_22, 2 E_12 and E_11 + E_22; the total energy is their energies plus C_12 E_11 E_22.

        With a table of coupling, the first two laws are the tensions of strips that keep their width less the coupling.
        """
        course, wale, shear = self.curves()
        if not self.coupling_table:
            return course, wale, shear, TensionCurve.linear(0.0)
        place = f"material {self.name!r}: coupling_table"
        points = _points(self.coupling_table, place)
        both = TensionCurve.through(points[:, 0], points[:, 1], place)
        return course.without(both, f"{place} and course"), wale.without(both, f"{place} and wale"), shear, both

    def _check_tables(self) -> None:
        course, wale, _shear, _both = self.energies()
        coupling, stiffness = abs(self.coupling), (course.least_slope * wale.least_slope) ** 0.5
        if stiffness <= coupling:
            raise ParameterError(
                f"material {self.name!r}: tension tables: the smallest stiffness of both axes is {stiffness:g} dyn/cm "
                f"and their coupling {coupling:g}; expected more, for a stable cloth; choose a smaller poisson"
            )


def _orthotropic(first: float, second: float, poisson: float, shear: float) -> NDArray[np.float64]:
    """The matrix of a law from the moduli of strips along two axes."""
    scale = 1.0 / (1.0 - poisson**2)
    coupling = poisson * (first * second) ** 0.5 * scale
    return np.array([[first * scale, coupling, 0.0], [coupling, second * scale, 0.0], [0.0, 0.0, shear]])


def _points(table: Table, place: str) -> NDArray[np.float64]:
    """The points of a table, shape (n, 2)."""
    if any(len(point) != 2 for point in table) or not all(point[0] > -1.0 for point in table):
        raise ParameterError(f"{place}: expected pairs of strain (above -1) and tension, such as [[0, 0], [0.1, 500]]")
    return np.array(table, dtype=np.float64)


def _shear_curve(table: Table, place: str) -> TensionCurve:
    """The law of a table of shear strains and stresses, and of the same table with the other sign."""
    points = _points(table, place)
    if points[0].any():
        raise ParameterError(f"{place}: begins with {tuple(map(float, points[0]))}; expected (0, 0)")
    both = np.concatenate([-points[:0:-1], points])
    return TensionCurve.through(both[:, 0], both[:, 1], place)


def _tension_curve(table: Table, place: str) -> TensionCurve:
    """The law in Green strain and second Piola-Kirchhoff stress of a table of strain and tension."""
    points = _points(table, place)
    stretch = 1.0 + points[:, 0]
    return TensionCurve.through((stretch**2 - 1.0) / 2.0, points[:, 1] / stretch, place)


def checked_weights(weight: ArrayLike | None, count: int) -> NDArray[np.float64]:
    """The blending weight 1 - alpha of each triangle or rod (C 4.1), shape (count,); 1 if none are given.

    Raises:
        ParameterError: the shape is not (count,), or a weight is not in [0, 1].
    """
    if weight is None:
        return np.ones(count)
    weights = np.asarray(weight, dtype=np.float64)
    if weights.shape != (count,):
        raise ParameterError(f"blending weights: got shape {weights.shape}; expected ({count},)")
    bad = np.flatnonzero(~((weights >= 0.0) & (weights <= 1.0)))
    if len(bad):
        raise ParameterError(f"blending weights: element {bad[0]} has {weights[bad[0]]:g}; expected 0 to 1")
    return weights
