# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The material of a yarn of crossing nodes: stiffness, mass, friction, yield and damping in CGS units.

A file holds one table for each material, with all fields of ``CrossingMaterial``; ``crossing_materials.toml`` in this
folder holds three published yarns. The stiffnesses of the energies follow from the moduli and the radius R (Cirio et
al. 2014 and 2017):

    stretch k_s = Y pi R^2 [dyn],    bending k_b = B pi R^2 [dyn cm^2],    shear k_x = S R^2 [dyn]

The flexural rigidity of the yarn is EI = k_b = B pi R^2 (``crossing_energies``). ``FabricMaterials`` holds one material
each for wefts or courses, for warps, and for the rods along seams.
"""

from __future__ import annotations

import difflib
import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.toml_file import read_table

NAMED_FILE = Path(__file__).with_name("crossing_materials.toml")
"""File of the materials that have a name."""
DEFAULT = "gong-1"
"""Name of the material that applies if none is given."""
POSITIVE = ("radius", "density", "young", "yield_curvature")
"""Fields that must be larger than zero; the others may be zero."""
LARGEST_VALUE = 1e60
"""Largest finite value of a constant, so that products of constants are finite."""


@dataclass(frozen=True)
class CrossingMaterial:
    """Stiffness, mass, friction, yield and damping of a yarn.

    Raises:
        ParameterError: a value is negative, not a number, or zero or infinite where it must not be.
    """

    radius: float
    """Radius R of the yarn [cm]."""
    density: float
    """Mass per length of yarn, rho [g/cm]."""
    young: float
    """Modulus of stretch, Y [dyn/cm^2]."""
    bending: float
    """Modulus of bending, B [dyn]."""
    shear: float
    """Modulus of shear at a crossing, S [dyn/cm^2]."""
    contact: float
    """Stiffness of the contact of neighbouring parallel yarns, k_c [dyn/cm^2]."""
    wrapping: float
    """Stiffness of the wrapping of two yarns around one another in a knit, k_w [dyn]."""
    stitch_length: float
    """Stiffness against a change of length of a stitch contact in a knit, k_l [dyn]."""
    friction: float
    """Coefficient of friction mu between the yarns of a crossing."""
    friction_stiffness: float
    """Stiffness of the spring that holds a yarn at its anchor while it sticks, k_f [dyn/cm]."""
    yield_curvature: float
    """Change of curvature beyond which a bend becomes permanent, kappa_y [1/cm]; infinite for an elastic yarn."""
    damping_mass: float
    """Rayleigh damping in proportion to the mass [1/s]."""
    damping_stiffness: float
    """Rayleigh damping in proportion to the stiffness [s]."""

    def __post_init__(self) -> None:
        for field in fields(self):
            _check(field.name, getattr(self, field.name))

    @property
    def stretch_stiffness(self) -> float:
        """k_s = Y pi R^2 [dyn]."""
        return self.young * math.pi * self.radius**2

    @property
    def bending_stiffness(self) -> float:
        """k_b = B pi R^2 [dyn cm^2], the flexural rigidity EI of the yarn."""
        return self.bending * math.pi * self.radius**2

    def finer(self, times: float) -> CrossingMaterial:
        """The yarn of a cloth that is as heavy and as stiff, but has more and finer yarns.

        Where n times as many yarns lie on each cm, a yarn has 1 / n of the radius, of the mass per length, and of the
        stiffnesses k_s, k_b and k_x of stretch, bending and shear. A knit has n^2 times as many stitch contacts, which
        are 1 / n times as long. k_w and k_l therefore become 1 / n of what they were, and the friction at a crossing
        becomes 1 / n^2.

        Args:
            times: n, the number of yarns that replace one yarn.
        """
        return replace(
            self,
            radius=self.radius / times,
            density=self.density / times,
            young=self.young * times,
            bending=self.bending * times,
            shear=self.shear * times,
            wrapping=self.wrapping / times,
            stitch_length=self.stitch_length / times,
        )

    @staticmethod
    def names() -> tuple[str, ...]:
        """Names of the materials of this package."""
        return tuple(_named_materials())

    @staticmethod
    def named(name: str = DEFAULT) -> CrossingMaterial:
        """One of the materials of this package.

        Raises:
            ParameterError: no material has this name.
        """
        return _of_name(_named_materials(), name, "the named materials")

    @staticmethod
    def read(path: str | Path, name: str) -> CrossingMaterial:
        """The material of that name in a TOML file.

        Raises:
            FileError: the file cannot be read, is not TOML, or a table is not a material.
            ParameterError: no material has this name, or a value is out of range.
        """
        return _of_name(_read_tables(Path(path)), name, str(path))


def _check(name: str, value: Any) -> None:
    """Refuse a value out of range."""
    infinite = name == "yield_curvature"
    number = isinstance(value, int | float) and not isinstance(value, bool)
    least_reached = number and (value > 0.0 if name in POSITIVE else value >= 0.0)
    if least_reached and (value <= LARGEST_VALUE or (infinite and value == math.inf)):
        return
    least = "larger than 0" if name in POSITIVE else "of at least 0"
    kind = "a number" if infinite else "a finite number"
    raise ParameterError(f"crossing material: {name} is {value!r}; expected {kind} {least}")


def _of_name(materials: Mapping[str, CrossingMaterial], name: str, place: str) -> CrossingMaterial:
    """The material of this name; if there is none, the error names the material with the nearest name."""
    if name in materials:
        return materials[name]
    near = difflib.get_close_matches(name, materials, n=1, cutoff=0.0)
    remedy = f"did you mean {near[0]!r}" if near else "the file holds no material"
    raise ParameterError(f"crossing material: got {name!r}; expected a name of {place}: {remedy}")


@functools.cache
def _named_materials() -> Mapping[str, CrossingMaterial]:
    return _read_tables(NAMED_FILE)


def _read_tables(path: Path) -> dict[str, CrossingMaterial]:
    return {name: _material_of(path, name, table) for name, table in read_table(path).items()}


def _material_of(path: Path, name: str, table: Any) -> CrossingMaterial:
    """The material in a table with exactly the fields of ``CrossingMaterial``."""
    expected = [field.name for field in fields(CrossingMaterial)]
    if not isinstance(table, dict):
        raise FileError(f"{path}: {name} is {table!r}; expected a table with {', '.join(expected)}")
    wrong = [f"has no {key}" for key in expected if key not in table]
    wrong += [f"has an unknown field {key}" for key in table if key not in expected]
    if wrong:
        raise FileError(f"{path}: material {name!r} {wrong[0]}; expected the fields {', '.join(expected)}")
    return CrossingMaterial(**table)


@dataclass(frozen=True)
class FabricMaterials:
    """A material for each family of yarns."""

    weft: CrossingMaterial
    """Material of wefts, and of all yarns of a knit."""
    warp: CrossingMaterial
    """Material of warps."""
    rod: CrossingMaterial
    """Material of the rods along seams."""

    @staticmethod
    def of(material: CrossingMaterial) -> FabricMaterials:
        """The same material for all yarns."""
        return FabricMaterials(material, material, material)

    @property
    def by_family(self) -> tuple[CrossingMaterial, CrossingMaterial, CrossingMaterial]:
        """The materials in the order of the numbers of families in ``CrossingYarns.yarn_family``."""
        return self.weft, self.warp, self.rod
