# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A yarn as its makers and a laboratory describe it, and what follows from the description.

With the linear density m, the density rho of the fibre and the part phi of the cross-section that fibres fill, the
diameter and the area of the yarn are

    D = sqrt(4 m / (pi phi rho)),        A = pi D^2 / 4

and from a tensile modulus E or a specific stiffness e (of the linear density), and from a bending modulus E_b,

    EA = E A = e m        [dyn],        EI = E_b pi D^4 / 64        [dyn cm^2]

A yarn that hangs free loses its residual twist tau [turns in a length]. Held, it carries the torque 2 pi GJ tau.

A yarn whose fibres slide over one another has the bending rigidity of all its fibres together. For round fibres of the
diameter f with the specific modulus e_f this is the least rigidity that a yarn can have:

    EI = m e_f f^2 / 16        [dyn cm^2]

A monofilament is one fibre, f = D, with the rigidity of a solid rod. The moduli of fibres are the initial moduli of
Morton and Hearle's tables (Physical Properties of Textile Fibres), from handbooks that quote them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.yarn.quantities import (
    FORCE,
    LENGTH,
    LINEAR_DENSITY,
    PER_LENGTH,
    PRESSURE,
    RIGIDITY,
    SPECIFIC_STIFFNESS,
    TORQUE,
    in_cgs,
)
from stitchmesh.yarn.yarn_look import PRESETS, YarnLook
from stitchmesh.yarn.yarn_presets import (
    FIBRES,
    LOOP_OVER_WIDTH,
    TWIST_OVER_BEND,
    Fibre,
    Gauge,
    Yarn,
    YarnMechanics,
    free_fibres,
    parse_gauge,
)

Quantity: TypeAlias = float | str
"""A number in CGS units, or a text with a unit."""
PACKING = 0.5
"""Part of the cross-section of a spun yarn that fibres fill, if nothing states the thickness of the yarn."""
COMPACT_LOOP = 16.67
"""Loop length over the diameter of the core, if no gauge is given (Peirce)."""
@dataclass(frozen=True, kw_only=True)
class YarnDescription:
    """The keys of a file ``yarn.toml``; quantities are texts with a unit, or numbers in CGS units."""

    name: str = ""
    """Name of the yarn."""
    linear_density: Quantity
    """Mass of a length, or a count: ``72 tex``, ``2/28 Nm``, ``20/2 Ne``, ``70 denier``."""
    diameter: Quantity | None = None
    """Diameter that the eye sees."""
    wraps: Quantity | None = None
    """Turns of yarn side by side in a length, for example ``12 wpi``, in the place of the diameter."""
    packing: float | None = None
    """Part of the cross-section that fibres fill, in the place of the diameter; 0.5 if nothing states a thickness."""
    core_diameter: Quantity | None = None
    """Diameter within which the yarn resists compression; the diameter itself if it is not given."""
    fibre: str | None = None
    """wool, cotton, acrylic, nylon, polyester, viscose or silk."""
    fibre_diameter: Quantity | None = None
    """Diameter of a fibre, or of a monofilament."""
    bending_rigidity: Quantity | None = None
    """Bending moment over curvature, EI; the rigidity of free fibres if it is not given."""
    bending_modulus: Quantity | None = None
    """Modulus of a round solid rod with this rigidity, in the place of the rigidity."""
    axial_stiffness: Quantity | None = None
    """Tension over strain, EA."""
    tensile_modulus: Quantity | None = None
    """Modulus of the whole cross-section, in the place of the axial stiffness."""
    specific_stiffness: Quantity | None = None
    """Tension over strain and linear density, for example ``220 cN/tex``, in the place of the axial stiffness."""
    load_extension: str | tuple[tuple[float, float], ...] | None = None
    """Pairs of strain [%] and tension [cN], or in a file ``yarn.toml`` the path of a CSV file with a head and these
    columns; in the place of the axial stiffness, which is then the slope of the line through zero that fits the curve
    best up to ``up_to``."""
    up_to: float = 5.0
    """Largest strain [%] of the curve that counts."""
    transverse_modulus: Quantity | None = None
    """Pressure between parallel yarns over their compression by a tenth; as in the default material if not given."""
    twist: Quantity | None = None
    """Turns in a length, for example ``850/m``."""
    torsional_rigidity: Quantity | None = None
    """Torque over twist in a length, GJ; two thirds of the bending rigidity if it is not given."""
    residual_twist: Quantity | None = None
    """Turns that a length of yarn would lose if it hung free, for example ``120/m``, or ``-120/m`` for S twist."""
    torque: Quantity | None = None
    """Torque of the yarn, in the place of the residual twist."""
    friction: float | None = None
    """Coefficient of friction of the yarn on itself."""
    gauge: str | None = None
    """Stitches, or stitches and rows, in 10 cm; from loops of 16.67 core diameters if not given."""
    look: str | YarnLook | None = None
    """How the yarn looks: the name of a look, or a table of the fields of ``YarnLook``; by default as the fibre."""
    source: str = ""
    """Where the values were measured or published."""

    def yarn(self) -> Yarn:
        """Return the yarn.

        Raises:
            ParameterError: a value is malformed, is missing, or is given twice.
        """
        mass = self._cgs("linear_density", LINEAR_DENSITY)
        assert mass is not None
        diameter = self._diameter(mass)
        core = self._cgs("core_diameter", LENGTH) or diameter
        loop = COMPACT_LOOP * core
        gauge = Gauge(10.0 * LOOP_OVER_WIDTH / loop) if self.gauge is None else parse_gauge(self.gauge)
        area = math.pi * diameter**2 / 4.0
        mechanics = YarnMechanics(
            axial_stiffness=self._axial_stiffness(mass, area),
            flexural_rigidity=self._rigidity(mass, diameter),
            transverse_modulus=self._cgs("transverse_modulus", PRESSURE),
            twist=self._cgs("twist", PER_LENGTH),
            friction=self.friction,
            torsional_rigidity=self._cgs("torsional_rigidity", RIGIDITY),
            residual_twist=self._residual_twist(self._rigidity(mass, diameter)),
            least_rigidity=self._free_fibres(mass),
            source=self.source,
        )
        return Yarn(
            self.name, core / 2.0, diameter / 2.0, 100.0 * mass, gauge, mechanics=mechanics, look=self._look(diameter)
        )

    def _look(self, diameter: float) -> YarnLook:
        """Return the look, by default that of the fibre; a fibre as thick as the yarn is a monofilament."""
        if isinstance(self.look, YarnLook):
            return self.look
        fibre = None if self.fibre_diameter is None else self._cgs("fibre_diameter", LENGTH)
        if self.look is None and fibre is not None and fibre > 0.5 * diameter:
            return YarnLook("monofilament")
        return YarnLook(self.look or (self.fibre if self.fibre in PRESETS else YarnLook.name))

    def _cgs(self, name: str, unit: str) -> float | None:
        value = getattr(self, name)
        return None if value is None else in_cgs(value, unit, self._what(name))

    def _residual_twist(self, bending: float) -> float | None:
        """Return the residual twist [1/cm]; a torque is divided by the torsional rigidity."""
        given = self._one_of("residual_twist", "torque")
        if given is None:
            return None
        value = getattr(self, given)
        negative = value.strip().startswith("-") if isinstance(value, str) else value < 0.0
        size = value.strip().lstrip("-") if isinstance(value, str) else abs(value)
        found = in_cgs(size, PER_LENGTH if given == "residual_twist" else TORQUE, self._what(given))
        if given == "torque":
            found /= 2.0 * math.pi * (self._cgs("torsional_rigidity", RIGIDITY) or TWIST_OVER_BEND * bending)
        return -found if negative else found

    def _what(self, name: str) -> str:
        return f"yarn {self.name!r}: {name}"

    def _one_of(self, *names: str) -> str | None:
        """Return the name of the value that is given; None if none is.

        Raises:
            ParameterError: two are given.
        """
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) > 1:
            raise ParameterError(f"{self._what(given[1])}: got one beside {given[0]}; give one of the two")
        return given[0] if given else None

    def _diameter(self, mass: float) -> float:
        given = self._one_of("diameter", "wraps", "packing")
        if given == "diameter":
            found = self._cgs("diameter", LENGTH)
            assert found is not None
            return found
        if given == "wraps":
            return 1.0 / in_cgs(self.wraps or "", PER_LENGTH, self._what("wraps"))
        if self.fibre is None:
            raise ParameterError(f"{self._what('diameter')}: got none; expected it, wraps, or fibre and packing")
        packing = PACKING if self.packing is None else self.packing
        if not 0.0 < packing <= 1.0:
            raise ParameterError(f"{self._what('packing')}: got {packing:g}; expected a number above 0 and up to 1")
        return math.sqrt(4.0 * mass / (math.pi * packing * self._fibre().density))

    def _fibre(self) -> Fibre:
        if self.fibre not in FIBRES:
            raise ParameterError(f"{self._what('fibre')}: got {self.fibre!r}; expected one of {', '.join(FIBRES)}")
        return FIBRES[self.fibre]

    def _free_fibres(self, mass: float) -> float | None:
        if self.fibre is None or self.fibre_diameter is None:
            return None
        return free_fibres(mass, self._fibre(), in_cgs(self.fibre_diameter, LENGTH, self._what("fibre_diameter")))

    def _rigidity(self, mass: float, diameter: float) -> float:
        given = self._one_of("bending_rigidity", "bending_modulus")
        if given == "bending_modulus":
            modulus = in_cgs(self.bending_modulus or "", PRESSURE, self._what("bending_modulus"))
            return modulus * math.pi * diameter**4 / 64.0
        found = self._cgs("bending_rigidity", RIGIDITY) or self._free_fibres(mass)
        if found is None:
            expected = "expected it, bending_modulus, or fibre and fibre_diameter"
            raise ParameterError(f"{self._what('bending_rigidity')}: got none; {expected}")
        return found

    def _axial_stiffness(self, mass: float, area: float) -> float:
        given = self._one_of("axial_stiffness", "tensile_modulus", "specific_stiffness", "load_extension")
        if given == "tensile_modulus":
            return area * in_cgs(self.tensile_modulus or "", PRESSURE, self._what("tensile_modulus"))
        if given == "specific_stiffness":
            return mass * in_cgs(self.specific_stiffness or "", SPECIFIC_STIFFNESS, self._what("specific_stiffness"))
        if given == "load_extension":
            return self._slope_of_curve()
        found = self._cgs("axial_stiffness", FORCE)
        if found is None:
            expected = "expected it, tensile_modulus, specific_stiffness or load_extension"
            raise ParameterError(f"{self._what('axial_stiffness')}: got none; {expected}")
        return found

    def _slope_of_curve(self) -> float:
        """Return the slope of the line through zero that fits the curve best [dyn]."""
        what, curve = self._what("load_extension"), self.load_extension
        if isinstance(curve, str) or curve is None:
            raise ParameterError(f"{what}: got {curve!r}; expected pairs of strain [%] and tension [cN]")
        check_positive(self._what("up_to"), self.up_to, "%")
        pairs = [(strain / 100.0, 1e3 * tension) for strain, tension in curve if 0.0 < strain <= self.up_to]
        if not pairs:
            found = f"got no strain above 0 and up to {self.up_to:g} %"
            raise ParameterError(f"{what}: {found}; expected some, or give up_to")
        slope = sum(e * f for e, f in pairs) / sum(e * e for e, _ in pairs)
        if not slope > 0.0:
            raise ParameterError(f"{what}: got tensions that fall; expected strains [%] and tensions [cN] that rise")
        return slope


def described_yarn(**keys: Any) -> Yarn:
    """Return the yarn of a description; the keys are the fields of ``YarnDescription``.

    Raises:
        ParameterError: a key is unknown, or a value is malformed, is missing, or is given twice.
    """
    known = [part.name for part in fields(YarnDescription)]
    for key in keys:
        if key not in known:
            raise ParameterError(f"yarn: got {key!r}; expected {', '.join(known)}")
    if "linear_density" not in keys:
        raise ParameterError("yarn linear_density: got none; expected for example 72 tex, 2/28 Nm or 20/2 Ne")
    return YarnDescription(**keys).yarn()


LIBRARY: dict[str, dict[str, Any]] = {
    "acrylic-77-tex": {
        "linear_density": "77 tex", "diameter": "0.524 mm", "tensile_modulus": "79 MPa",
        "bending_modulus": "0.249 MPa", "gauge": "56", "look": "acrylic",
        "source": "Ding, Sanchez, Bertoldi, Rycroft 2023 (arXiv 2307.12360), from secondary texts; their radius is "
        "taken for a diameter, because loops of 7.23 mm would not exist otherwise; gauge from these loops",
    },
    "acrylic-worsted": {
        "linear_density": "502 tex", "diameter": "1.48 mm", "core_diameter": "0.65 mm",
        "bending_rigidity": "0.09 N mm2", "specific_stiffness": "22 cN/tex", "gauge": "36",
        "look": "acrylic",
        "source": "Singal et al. 2024 (Nat. Commun. 15:2622), their published input for stockinette: radii, and an "
        "energy of 0.045 N mm2 times the square of the curvature; linear density as its maker states it; stiffness "
        "along the yarn as acrylic-77-tex; gauge from loops of 11.28 mm",
    },
    "cotton-28-tex": {
        "linear_density": "28.1 tex", "diameter": "0.169 mm", "tensile_modulus": "815 MPa", "fibre": "cotton",
        "fibre_diameter": "12 um", "twist": "1040/m", "friction": 0.5,
        "source": "Xiong et al. 2026 (Materials 19:560), from a secondary text; bending of free fibres",
    },
    "wool-2-28": {
        "linear_density": "2/28 Nm", "diameter": "0.30 mm", "specific_stiffness": "22 cN/tex", "fibre": "wool",
        "fibre_diameter": "21 um",
        "source": "diameter 0.035 sqrt(tex) (Spencer, Knitting Technology); bending of free fibres; stiffness along "
        "the yarn as acrylic-77-tex",
    },
    "nylon-monofilament": {
        "linear_density": "20.1 tex", "diameter": "0.15 mm", "fibre": "nylon", "fibre_diameter": "0.15 mm",
        "tensile_modulus": "3 GPa",
        "source": "Poincloux, Adda-Bedia, Lechenault 2018 (PRX 8, 021075): diameter; moduli of nylon",
    },
    "polyester-monofilament": {
        "linear_density": "34.3 tex", "diameter": "0.178 mm", "fibre": "polyester", "fibre_diameter": "0.178 mm",
        "tensile_modulus": "12 GPa",
        "source": "du Pasquier et al. 2025 (arXiv 2501.07567): diameter; moduli of polyester",
    },
    "nylon-2x70-denier": {
        "linear_density": "140 denier", "packing": 0.6, "fibre": "nylon", "fibre_diameter": "19 um",
        "specific_stiffness": "260 cN/tex", "look": "silk",
        "source": "du Pasquier et al. 2025 (arXiv 2501.07567): high-tenacity nylon, 70 denier, 24 filaments, two "
        "plies; modulus of nylon filaments, which are straight; an industrial yarn under tension",
    },
    "cotton-elastane": {
        "linear_density": "24.4 tex", "diameter": "0.17 mm", "axial_stiffness": "4.84 cN",
        "bending_rigidity": "0.0009 cN cm2", "look": "cotton",
        "source": "cotton of 20 tex plated with bare elastane of 44 dtex: below the length of its cotton the yarn has "
        "the stiffness of the elastane, 0.11 cN/dtex (a maker's figure), and the bending of free cotton fibres; that "
        "the cotton stops the stretch is left out",
    },
}  # fmt: skip
"""Descriptions of measured yarns by name."""
