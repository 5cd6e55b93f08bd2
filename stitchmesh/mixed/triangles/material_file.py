# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of cloth as files: TOML with the fields of ``ClothMaterial`` as keys.

``named_material`` returns materials of measured cloths. Their numbers come from the database of Wang, O'Brien and
Ramamoorthi 2011 (Data-driven elastic models for cloth), in the form in which the program ARCSim (Narain, Samii and
O'Brien 2012) distributes and reads it. For a stretch of 1/6 along five directions, the database gives the coefficients
a, b, c, d [N/m], and for three directions and five curvatures a bending coefficient k [N m]. The forces of ARCSim
follow from them as

    S_11 = 2 a E_11 + 2 b E_22,    S_22 = 2 b E_11 + 2 c E_22,    S_12 = 2 d E_12
    energy of a hinge  k l^2 theta^2 / (8 A),  with the area A of both triangles

We take a from the row of the courses (wefts), c from the row of the wales (warps), the mean of b of these two rows, d
from the row of 45 degrees, and k at the smallest curvature. A hinge of energy D l^2 theta^2 / (2 A) bends like a plate
of rigidity D on equilateral triangles, so D = k / 4. A roll at 45 degrees costs (B_1 + B_2) / 4 + twist, from which
twist follows. These are secant moduli at a large stretch; knits resist less at small stretch. No damping was measured.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from os import fspath
from pathlib import Path

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.toml_file import SUFFIX, changed_fields, read_dataclass, table_lines
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

SOURCE = "Wang, O'Brien and Ramamoorthi 2011, as distributed with ARCSim"
DYN_PER_CM = 1e3
"""One newton per metre [dyn / cm]."""
DYN_CM = 1e7
"""One newton metre [dyn cm]."""
HEADER = "# A material of cloth. Courses (wefts) run along x in the coordinates of a panel, wales (warps) along y.\n"
UNITS = {
    "stretch_course": "dyn/cm, Young's modulus times thickness",
    "stretch_wale": "dyn/cm",
    "shear": "dyn/cm",
    "bending_course": "dyn cm",
    "bending_wale": "dyn cm",
    "density": "g/cm^2",
    "twist": "dyn cm",
    "moment_course": "dyn, curls the courses towards the normals",
    "moment_wale": "dyn",
    "damping": "s",
    "mass_damping": "1/s",
    "tension_course": "strain and tension [dyn/cm] at constant width",
    "tension_wale": "strain and tension [dyn/cm] at constant width",
    "shear_table": "strain 2 E_12 and stress [dyn/cm]",
    "coupling_table": "strain E_11 + E_22 and stress [dyn/cm]",
}
"""Comments beside the keys of a written material."""


@dataclass(frozen=True)
class _Measured:
    """One cloth of the database."""

    names: tuple[str, ...]
    """Names of the material; the first is its main name."""
    density: float
    """Mass per area [kg / m^2]."""
    stretching: tuple[float, float, float, float, float]
    """Coefficients a, c, b along the courses, b along the wales, and d [N / m]."""
    bending: tuple[float, float, float]
    """Coefficient k for an edge along the courses, at 45 degrees and along the wales [1e-6 N m]."""

    def material(self) -> ClothMaterial:
        """Return the material in our units."""
        a, c, first, second, d = (DYN_PER_CM * value for value in self.stretching)
        moduli = np.array([[2.0 * a, first + second], [first + second, 2.0 * c]])
        compliance = np.linalg.inv(moduli)
        # an edge along the courses is the axis of a roll whose curvature runs along the wales
        wale, diagonal, course = (DYN_CM * 1e-6 / 4.0 * value for value in self.bending)
        return ClothMaterial(
            name=self.names[0],
            stretch_course=float(1.0 / compliance[0, 0]),
            stretch_wale=float(1.0 / compliance[1, 1]),
            shear=d,
            poisson=float(moduli[0, 1] / (moduli[0, 0] * moduli[1, 1]) ** 0.5),
            bending_course=course,
            bending_wale=wale,
            density=0.1 * self.density,
            twist=diagonal - (course + wale) / 4.0,
            source=SOURCE,
        )


_TABLE = (
    _Measured(("interlock", "t-shirt"), 0.187, (46.364765, 405.872833, 53.694656, 85.848587, 44.217571),
              (23.191698, 24.749964, 14.267624)),
    _Measured(("rib-knit", "rib"), 0.276, (52.422512, 254.593491, 7.219094, 0.416488, 27.609430),
              (46.237591, 30.015930, 32.243889)),
    _Measured(("ponte-roma", "jersey-jacket"), 0.284, (78.707756, 191.777588, 26.754574, 49.654823, 44.657330),
              (36.348366, 33.013252, 37.157593)),
    _Measured(("swimwear",), 0.204, (40.369045, 124.468513, 23.092957, 40.131950, 35.973194),
              (60.237942, 58.803211, 51.018833)),
    _Measured(("denim", "jeans"), 0.324, (232.027634, 1051.55712, 40.646339, 40.917892, 83.992020),
              (64.196457, 73.384567, 96.951576)),
    _Measured(("plain-polyester", "tablecloth"), 0.128, (2107.22753, 2150.47680, 36.371597, 61.216290, 101.462021),
              (51.713814, 40.659470, 31.282822)),
    _Measured(("twill", "trousers"), 0.220, (2109.51684, 2152.73852, 38.604588, 63.424015, 121.482445),
              (125.409805, 107.997696, 125.409805)),
)  # fmt: skip
"""Knits first, then weaves; 60% cotton 40% polyester, 95% cotton 5% spandex, 60% polyester 40% rayon, 87% nylon 13%
spandex, 99% cotton 1% spandex, polyester, 65% cotton 35% polyester."""

_NAMED = {name: row.material() for row in _TABLE for name in row.names}


def material_names() -> tuple[str, ...]:
    """Return the main names of the measured materials."""
    return tuple(row.names[0] for row in _TABLE)


def named_material(name: str) -> ClothMaterial:
    """Return a measured material.

    Raises:
        ParameterError: there is no material of that name; the message states the nearest name.
    """
    plain = "-".join(str(name).lower().replace("-", " ").replace("_", " ").split())
    if plain not in _NAMED:
        near = difflib.get_close_matches(plain, _NAMED, n=1)
        expected = f"did you mean {near[0]!r}?" if near else f"expected one of {', '.join(material_names())}"
        raise ParameterError(f"material: got {name!r}; {expected}")
    return _NAMED[plain]


def material_of(name_or_path: FilePath) -> ClothMaterial:
    """Return a measured material by its name, or read a material file, whose name ends with ``.toml``.

    Raises:
        ParameterError: there is no material of that name; the message states the nearest name.
        FileError: the file cannot be read, or is not a material file.
    """
    text = fspath(name_or_path)
    return read_material(text) if Path(text).suffix == SUFFIX else named_material(text)


def read_material(path: FilePath) -> ClothMaterial:
    """Read a material from a TOML file.

    Raises:
        FileError: the file cannot be read, is not TOML, or has an unknown key or an impossible value; the message names
            the key and, for an unknown key, the nearest known one.
    """
    return read_dataclass(path, ClothMaterial)


def write_material(path: FilePath, material: ClothMaterial, notes: Sequence[str] = ()) -> None:
    """Write a material as a TOML file; the file is written atomically. Keys whose value is the default are left out.

    Args:
        path: name of the file.
        material: the material.
        notes: comment lines for the end of the file, for example about the fit of the material.

    Raises:
        FileError: the file cannot be written, or its suffix is not ``.toml``.
    """
    suffix_of(path, [SUFFIX])
    lines = table_lines(changed_fields(material), comments=UNITS)
    comments = [f"# {line}".rstrip() for note in notes for line in note.splitlines()]
    write_text(path, HEADER + "\n".join([*lines, *comments]) + "\n")
