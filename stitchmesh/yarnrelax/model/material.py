# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The material of yarns: stiffnesses of Kaldor 2008 and Leaf 2018 (L) in CGS units, and the mass of control points.

Both papers state the stiffness against stretch, k_len and L's k_l, for one segment of their own splines, so that a yarn
of shorter segments would be stiffer. Here both hold for a segment of the rest length l0 (``segment_length``), and a
segment of length l has l / l0 of them. The axial stiffness EA = 2 (k_len + k_length) / l0 is then a property of the
yarn, like the flexural rigidity EI = 2 k_bend and the torsional rigidity GJ = 2 k_twist, and finer splines have one
limit. A plain stitch of L has about 14 segments. In a loop of 16.67 diameters they are 2.4 radii long, between the
segments of a garment (12 in a stitch) and those of a free swatch (16) at ``draft``.

A yarn has the mass m per rest length: the mass that the yarn states (``YarnSet.mass_per_length``), or else the mass of
its material. Over a segment the four basis functions have the integrals (1, 11, 11, 1) / 24. These are the row sums of
its mass matrix over m l (L, appendix B). A control point has the mass

    m_j = sum over its segments of  m l (1, 11, 11, 1)_slot / 24        [g]

which is m l for an inner control point between segments of length l.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.yarn.yarn_presets import TWIST_OVER_BEND, Yarn, yarn_names

if TYPE_CHECKING:
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarnrelax.model.constants import Model

DEFAULT_MATERIAL = "stitchmesh"
"""Name of the material that applies if no material is given."""
MOST_OVER_DEFAULT = 1e6
"""Largest value that a user may give, over the value of the default material. With contact a hundred million times as
stiff, a step of the solver would leave the numbers of single precision."""
REFERENCE_RADIUS = 0.125
"""Radius [cm] of the yarn that the named materials describe."""


Compression: TypeAlias = Literal["stiff", "van-wyk"]
"""Laws of contact (``energies.contact``)."""


@dataclass(frozen=True)
class YarnMaterial:
    """Stiffness, damping and mass of a yarn (Kaldor 2008, Table 1; L, appendix B).

    Raises:
        ParameterError: a value is negative or not finite.
    """

    k_len: float
    """Resistance to a drift of the parametrisation along a segment of ``segment_length`` [erg]."""
    k_length: float
    """Length penalty of a segment of ``segment_length``, L's k_l [erg]; 0 for none."""
    k_bend: float
    """Bending [erg cm]; the flexural rigidity EI is twice as large."""
    k_contact: float
    """Contact [erg / cm^2]."""
    k_global: float
    """Damping of all motion [g / s] (no effect on a state of rest)."""
    k_dt: float
    """Damping of sliding in contacts (no effect on a state of rest)."""
    k_dn: float
    """Damping of approach in contacts (no effect on a state of rest)."""
    mass_per_length: float
    """Mass of a length of yarn [g / cm]."""
    segment_length: float = 2.4 * REFERENCE_RADIUS
    """Rest length of the segments for which ``k_len`` and ``k_length`` are stated [cm]."""
    compression: Compression = "stiff"
    """How yarns in contact resist: ``stiff`` (Kaldor 2008), or ``van-wyk``, a soft mass of fibres (``contact``)."""
    k_twist: float | None = None
    """Twist [erg cm], which acts on request only; the torsional rigidity GJ is twice as large. None for
    ``TWIST_OVER_BEND`` times ``k_bend``."""

    def __post_init__(self) -> None:
        for name in stiffness_names():
            value = getattr(self, name)
            if value is None:
                continue
            if not (np.isfinite(value) and value >= 0.0):
                raise ParameterError(f"material: {name} is {value}; expected a finite number of at least 0")
        if self.compression not in get_args(Compression):
            found = f"material: compression is {self.compression!r}"
            raise ParameterError(f"{found}; expected one of {', '.join(get_args(Compression))}")
        check_positive("material: segment_length", self.segment_length, "cm")

    @property
    def axial_stiffness(self) -> float:
        """EA, the tension over the strain [dyn]."""
        return 2.0 * (self.k_len + self.k_length) / self.segment_length

    @property
    def flexural_rigidity(self) -> float:
        """EI, the bending moment over the curvature [dyn cm^2]."""
        return 2.0 * self.k_bend

    @property
    def twist_stiffness(self) -> float:
        """``k_twist``, or its value if it is not given [erg cm]."""
        return TWIST_OVER_BEND * self.k_bend if self.k_twist is None else self.k_twist

    @property
    def torsional_rigidity(self) -> float:
        """GJ, the torque over the twist in a length [dyn cm^2]."""
        return 2.0 * self.twist_stiffness

    @staticmethod
    def named(name: str = DEFAULT_MATERIAL, stiffness: Mapping[str, float] | None = None) -> YarnMaterial:
        """Return a named material, or that of a named yarn, for ``REFERENCE_RADIUS``, with some values changed.

        Args:
            name: name of the material, name of a yarn (``Yarn.named``), or path of the description of a yarn.
            stiffness: new values of single fields, by name, for a yarn of ``REFERENCE_RADIUS``; ``of_radius`` then
                changes them together with the others.

        Raises:
            ParameterError: no material or yarn has that name, a value of a description is wrong, or as for ``changed``.
            FileError: the description of a yarn cannot be read.
        """
        found = NAMED[name] if name in NAMED else _of_named_yarn(name)
        return found.changed(stiffness or {})

    def changed(self, stiffness: Mapping[str, float]) -> YarnMaterial:
        """Return this material, for yarn of ``REFERENCE_RADIUS``, with some of its values changed.

        Args:
            stiffness: new values of single fields, by name.

        Raises:
            ParameterError: no field has that name, or a value is negative, not finite, or above ``MOST_OVER_DEFAULT``
                times the value of the default material.
        """
        for field, value in stiffness.items():
            _check_field(field)
            default = NAMED[DEFAULT_MATERIAL]
            most = MOST_OVER_DEFAULT * (default.twist_stiffness if field == "k_twist" else getattr(default, field))
            if not 0.0 <= value <= most:
                raise ParameterError(f"material: {field} is {value:g}; expected a number from 0 to {most:g}")
        changed: dict[str, Any] = dict(stiffness)
        return replace(self, **changed)

    @staticmethod
    def of_yarn(yarn: Yarn) -> YarnMaterial:
        """Return the material of a yarn, for its core radius.

        k_length is five times k_len, as in the default material. Without a transverse modulus, contact is as stiff over
        bending as in the default material. With it, parallel yarns whose axes are 0.9 diameters apart carry a tenth of
        the modulus on their diameter (``pressure_of_parallel_yarns``).
        """
        radius, usual = yarn.core_radius, YarnMaterial.named().of_radius(yarn.core_radius)
        made = replace(usual, mass_per_length=yarn.mass_per_length)
        if yarn.mechanics is None:
            return made
        along = yarn.mechanics.axial_stiffness * usual.segment_length / 2.0
        k_bend = yarn.mechanics.flexural_rigidity / 2.0
        k_contact = usual.k_contact * k_bend / usual.k_bend
        rigidity = yarn.mechanics.torsional_rigidity
        if yarn.mechanics.transverse_modulus is not None:
            k_contact = 0.1 * yarn.mechanics.transverse_modulus / pressure_of_parallel_yarns(0.9, radius)
        return replace(made, k_len=along / 6.0, k_length=along * 5.0 / 6.0, k_bend=k_bend, k_contact=k_contact,
                       k_twist=None if rigidity is None else rigidity / 2.0)  # fmt: skip

    def transverse_modulus(self, radius: float) -> float:
        """Return the pressure between parallel yarns of a radius [cm] over their compression by a tenth [dyn/cm^2]."""
        return 10.0 * self.k_contact * pressure_of_parallel_yarns(0.9, radius, self.compression)

    def compressed_by(self, compression: Compression) -> YarnMaterial:
        """Return this material with another law of compression, and the same transverse modulus.

        Raises:
            ParameterError: there is no such law.
        """
        made = replace(self, compression=compression)
        same = self.transverse_modulus(1.0) / made.transverse_modulus(1.0) if self.k_contact > 0.0 else 1.0
        return replace(made, k_contact=self.k_contact * same)

    def of_radius(self, radius: float, own: float = REFERENCE_RADIUS) -> YarnMaterial:
        """Return the material of yarn of a radius [cm]; this material describes yarn of the radius ``own`` [cm].

        Stiffnesses and damping follow the similarity of ``scaled``. The yarn has the same density, so its mass per
        length is proportional to the square of the radius.

        Raises:
            ParameterError: the radius is not a positive finite number.
        """
        check_positive("material: yarn radius", radius, "cm")
        thicker = radius / own
        return replace(self.scaled(thicker), mass_per_length=self.mass_per_length * thicker**2)

    def scaled(self, gamma: float) -> YarnMaterial:
        """Return the material of the same yarn with every length multiplied by ``gamma``, as by a change of the unit.

        This similarity is exact (L section 6.2, eq 4): all energies keep their values. The mass of a yarn also stays
        the same, so the mass per length is divided by gamma. ``of_radius`` gives the material of another yarn.

        Raises:
            ParameterError: gamma is not a positive finite number.
        """
        check_positive("material: scale", gamma)
        return YarnMaterial(
            k_len=self.k_len,
            k_length=self.k_length,
            k_bend=self.k_bend * gamma,
            k_contact=self.k_contact / gamma**2,
            k_global=self.k_global / gamma**2,
            k_dt=self.k_dt / gamma**4,
            k_dn=self.k_dn / gamma**4,
            mass_per_length=self.mass_per_length / gamma,
            segment_length=self.segment_length * gamma,
            compression=self.compression,
            k_twist=None if self.k_twist is None else self.k_twist * gamma,
        )


def material_of(
    yarns: YarnSet, material: str | YarnMaterial | None = None, stiffness: Mapping[str, float] | None = None
) -> YarnMaterial:
    """Return the material of yarns, for their mean radius.

    Args:
        yarns: the yarns.
        material: a material for yarn of ``REFERENCE_RADIUS``, or its name; None for that of the yarn of which the
            yarns were made (``YarnSet.made_of``), or the default material if none is known.
        stiffness: new values of single fields, by name, for yarn of ``REFERENCE_RADIUS``.

    Raises:
        ParameterError: as for ``YarnMaterial.named``, or as for ``check_one_mass``.
    """
    check_one_mass(stiffness or {}, yarns.mass_per_length)
    if material is None and yarns.made_of is not None:
        material = YarnMaterial.of_yarn(yarns.made_of).of_radius(REFERENCE_RADIUS, yarns.made_of.core_radius)
    known = material if isinstance(material, YarnMaterial) else YarnMaterial.named(material or DEFAULT_MATERIAL)
    return known.changed(stiffness or {}).of_radius(float(yarns.radius.mean()))


def _of_named_yarn(name: str) -> YarnMaterial:
    """Return the material of a yarn for ``REFERENCE_RADIUS``."""
    from stitchmesh.io.yarn_files import yarn_of

    try:
        yarn = yarn_of(name)
    except ParameterError as error:
        if name.lower().endswith(".toml"):
            raise
        near = difflib.get_close_matches(name, [*NAMED, *yarn_names()], n=1)
        expected = near[0] if near else f"one of {', '.join(NAMED)}, or a yarn"
        raise ParameterError(f"material: got {name!r}; expected {expected}") from error
    return YarnMaterial.of_yarn(yarn).of_radius(REFERENCE_RADIUS, yarn.core_radius)


def stiffness_names() -> list[str]:
    """Return the names of the values of a material that are numbers."""
    return [field.name for field in fields(YarnMaterial) if field.name != "compression"]


def pressure_of_parallel_yarns(distance: float, radius: float, compression: Compression = "stiff") -> float:
    """Return the pressure between two parallel yarns over ``k_contact`` [1 / cm].

    Their force on a length is the derivative of the energy of two straight yarns, which is the integral of
    f(rho) = 1 / rho^2 + rho^2 - 2 along one of them (``energies.contact``), and the pressure is the force over the
    diameter. By van Wyk's law the force over ``k_contact`` is
    distance^-3 - 4 + 3 distance.

    Args:
        distance: distance of the axes over the diameter, below 1.
        radius: radius of both yarns [cm].
        compression: the law.
    """
    if compression == "van-wyk":
        return (distance**-3 - 4.0 + 3.0 * distance) / (2.0 * radius)
    half = math.sqrt(1.0 - distance**2)
    force = 2.0 * half / distance + 2.0 * math.atan2(half, distance) / distance**2 - 4.0 * distance * half
    return force / (2.0 * radius)


_SIMULATION = YarnMaterial(2000.0, 0.0, 5.0, 3250.0, 1.5, 0.003, 0.03, 0.006)

NAMED: dict[str, YarnMaterial] = {
    "kaldor-simulation": _SIMULATION,
    "kaldor-relaxation": YarnMaterial(10_000.0, 0.0, 0.005, 3250.0, 1.5, 0.003, 0.03, 0.006),
    "leaf": YarnMaterial(2000.0, 1000.0, 5.0, 3250.0, 1.5, 0.003, 0.03, 0.006),
    "stitchmesh": YarnMaterial(2000.0, 10_000.0, 5.0, 3250.0, 1.5, 0.003, 0.03, 0.006),
}
"""Materials by name: three published ones, and ``stitchmesh``. This is L's material with the stiffest length penalty
for which L reports no smaller steps (L section 3.1). It limits the strain of a garment's yarn to a few percent."""


def check_one_mass(stiffness: Mapping[str, float], stated: ArrayLike | None) -> None:
    """Refuse a mass among the values that a user gives for a material if the yarns state their own.

    Args:
        stiffness: values by name.
        stated: mass of a length of the yarns [g/cm], NaN for a yarn that states none; None if no yarn states one.

    Raises:
        ParameterError: both are given.
    """
    masses = np.atleast_1d(np.nan if stated is None else stated)
    if "mass_per_length" in stiffness and not np.isnan(masses).all():
        found = f"got one, and yarn that states a mass of {np.nanmean(masses):.3g} g/cm"
        raise ParameterError(f"stiffness mass_per_length: {found}; leave it out, or take yarn without a name")


def parse_stiffnesses(words: Iterable[str]) -> dict[str, float]:
    """Parse values of single fields of a material as a user writes them: ``k_bend=2.5``.

    Returns:
        The value of each named field.

    Raises:
        ParameterError: a word has another form, a field is unknown or is named twice, or a value is not a number.
    """
    found: dict[str, float] = {}
    for word in words:
        name, equals, text = (part.strip() for part in word.partition("="))
        if not equals:
            raise ParameterError(f"stiffness: got {word!r}; expected NAME=VALUE, for example k_bend=2.5")
        _check_field(name)
        if name in found:
            raise ParameterError(f"stiffness {name}: is given twice; expected one value")
        try:
            found[name] = float(text)
        except ValueError as error:
            raise ParameterError(f"stiffness {name}: got {text!r}; expected a number") from error
    return found


def _check_field(name: str) -> None:
    """Raise an error if a material has no field of that name."""
    known = stiffness_names()
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.5) or [f"one of {', '.join(known)}"]
        raise ParameterError(f"stiffness {name!r}: is no value of a material; expected {near[0]}")


def point_masses(model: Model) -> NDArray[np.float64]:
    """Return the mass of each control point [g], shape (N,).

    Raises:
        ParameterError: a yarn states no mass, and its material has none.
    """
    mass = np.concatenate(
        [cell.yarns.masses_per_length(cell.material.mass_per_length / cell.unit) * cell.unit for cell in model.cells]
    )
    if not mass.all():
        raise ParameterError("material: mass_per_length is 0; expected a mass [g/cm] for gravity and for dynamics")
    carried = carried_lengths(model.rest_length, model.yarns.segment_points, model.point_count)
    return mass[model.yarns.point_yarn] * carried


def carried_lengths(
    rest_length: NDArray[np.float64], segment_points: NDArray[np.int64], count: int
) -> NDArray[np.float64]:  # fmt: skip
    """Return the rest length of yarn that each of ``count`` control points carries, shape (N,).

    Args:
        rest_length: rest length of each segment, shape (S,).
        segment_points: control points of each segment, shape (S, 4).
        count: number of control points.
    """
    length = rest_length[:, None] * (np.array([1.0, 11.0, 11.0, 1.0]) / 24.0)  # integrals of the basis functions
    return np.bincount(segment_points.ravel(), weights=length.ravel(), minlength=count).astype(np.float64)
