# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where measurements of others were compared with swatches and stretch tests, and the error to expect there.

``RANGES`` holds what the comparisons of docs/validation.md found (``benchmarks/published``): for each quantity the
fabric, the loop lengths, the strains, the stretch of the yarn, and the error. ``gauge_verdict`` and ``tension_verdict``
say of one computation which row applies, or what lies outside all rows, as a verdict with findings.

Loop lengths are in diameters of the core of the yarn, because stiff yarns of one material have the same shapes at every
radius (``YarnMaterial.scaled``). The stretch of a yarn is its axial stiffness over its linear density [N/tex].
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.relaxation.off_needles import state_of_rest
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.reporting.verdict import Finding, Verdict
from stitchmesh.yarn.yarn_presets import NEWTON_PER_TEX
from stitchmesh.yarnrelax.model.material import NAMED, REFERENCE_RADIUS, YarnMaterial

if TYPE_CHECKING:
    from stitchmesh.periodic.relaxation.drawn_cell import Direction
    from stitchmesh.periodic.stretch import StretchPath
    from stitchmesh.periodic.swatch_options import KnitState, SwatchOptions

Quantity = Literal["gauge", "width", "crimp", "tension", "shape of the curve", "fitted solid", "work returned",
                   "inner loops of friction", "order of stiffness", "curl", "spirality", "thickness"]  # fmt: skip
"""What was compared; the shape of a curve is the tension over that at 10 %."""
Fabric = Literal["stockinette", "1x1 rib", "garter", "seed", "plain weave", "other"]
"""Fabrics that were compared, and all others."""
NEAR = 0.05
"""Loops that differ from compared ones by this part count as compared: it is the goal for the gauge, and as near as
authors state their loops."""
DRAFT_STRAIN = 0.4
"""Largest strain at which the tension of ``draft`` was compared with that of ``reference``; they differ by 2 %."""
STIFF_CONTACT = 100.0
"""Contact over bending, over that of the default material, from which on the shape of loops is hardly determined."""
ROUNDING = 1e-6
"""Relative rounding error of stiffnesses that were scaled to a radius and back."""


@dataclass(frozen=True, kw_only=True)
class ValidatedRange:
    """One comparison with measurements."""

    quantity: Quantity
    """What was compared."""
    fabrics: tuple[Fabric, ...]
    """The fabrics."""
    off: str
    """The error to expect, in words; for what was not compared, what is known."""
    error: float | None = None
    """The error to expect, as a part of the measured value; None if no value was compared."""
    loops: tuple[float, float] | None = None
    """Shortest and longest loop [core diameters]; None where loops do not matter, or where no value was compared."""
    strains: tuple[float, float] | None = None
    """Smallest and largest strain; None for a fabric at rest."""
    direction: Direction | None = None
    """The stretch direction; None for both, or for none."""
    states: tuple[KnitState, ...] = ()
    """States of a knit; empty for all."""
    stretch: tuple[float, float] | None = None
    """Smallest and largest stiffness of the yarn along itself [N/tex]; None where it does not matter."""
    friction: tuple[float, float] | None = None
    """Smallest and largest coefficient of friction; None where it does not matter."""
    heading: str
    """Heading of the section with the comparison."""
    page: str = "validation.md"
    """Page of the documentation with that heading."""

    @property
    def section(self) -> str:
        """Short name of the section."""
        return self.heading.partition(":")[0] if self.heading.startswith("V") else self.heading

    def holds_loops(self, loops: float) -> bool:
        """Whether loops of this length [core diameters] were compared."""
        return self.loops is None or self.loops[0] / (1.0 + NEAR) <= loops <= self.loops[1] * (1.0 + NEAR)

    @property
    def words(self) -> str:
        """Where the comparison was made, and its error."""
        loops = "" if self.loops is None else f"loops of {range_words(self.loops)}"
        strain = "" if self.strains is None else f" at {range_words([100.0 * each for each in self.strains])} %"
        along = "" if self.direction is None else f" along the {self.direction}s"
        return f"{loops}{along}{strain}, off by {self.off} ({self.section})"


V1, V2 = "V1: Plain knit: Munden's constants", "V2: Loose stockinette of nylon monofilament"
V4, V9 = "V4: Four patterns of an acrylic yarn", "V9: Cycles with friction"
V8 = "V8: Yarns, and hand-knitting yarns at their gauge"
JERSEY: tuple[Fabric, ...] = ("stockinette",)
SPUN = (0.2, 0.7)
"""Stretch of spun yarns [N/tex], with the acrylic yarn of V4 and the wool and cotton of V6."""


def _acrylic(fabric: Fabric, last: float, off: str, error: float) -> ValidatedRange:
    """Return the row of one pattern of V4, up to the strain at which its first regime ends."""
    return ValidatedRange(
        quantity="tension", fabrics=(fabric,), loops=(13.8, 13.8), direction="wale", strains=(0.0, last), stretch=SPUN,
        off=f"{off} in the modulus, with a yarn fitted to these curves", error=error, heading=V4,
    )  # fmt: skip


RANGES: tuple[ValidatedRange, ...] = (
    ValidatedRange(quantity="gauge", fabrics=JERSEY, loops=(16.0, 17.0), states=("wet", "full", "frictionless"),
                   off="1 to 4 %", error=0.04, heading=V8),
    ValidatedRange(quantity="gauge", fabrics=JERSEY, loops=(16.0, 17.0), states=("dry",),
                   off="7 % in rows and 1 % in stitches", error=0.07, heading=V8),
    ValidatedRange(quantity="gauge", fabrics=JERSEY, loops=(16.7, 19.3),
                   off="6 % RMS, and up to 11 % in the stitches of an area", error=0.11, heading=V1),
    ValidatedRange(quantity="gauge", fabrics=JERSEY, loops=(60.0, 60.0),
                   off="85 % in the width of a stitch over its height", error=0.85, heading=V2),
    ValidatedRange(quantity="width", fabrics=("1x1 rib",), loops=(14.0, 24.0), off="10 to 20 % or more", error=0.2,
                   heading="V10: Width and extension of ribs"),
    ValidatedRange(quantity="crimp", fabrics=("plain weave",), off="0.7 % from Peirce's theory; no measured cloth",
                   error=0.007, heading="Plain weave: Peirce's crimp"),
    ValidatedRange(quantity="tension", fabrics=JERSEY, loops=(16.67, 16.67), strains=(0.05, 0.15),
                   stretch=(SPUN[0], 3.0), off="up to a factor of 2", error=0.5,
                   heading="V6: Tension of industrial knits"),
    _acrylic("stockinette", 0.3, "15 % of the largest stress and 23 %", 0.23),
    _acrylic("1x1 rib", 0.4, "22 % of the largest stress and 5 %", 0.22),
    _acrylic("seed", 0.5, "13 % of the largest stress and 16 %", 0.16),
    _acrylic("garter", 0.6, "22 % of the largest stress and 28 %", 0.28),
    ValidatedRange(quantity="shape of the curve", fabrics=JERSEY, loops=(24.6, 24.6), direction="wale",
                   strains=(0.05, 0.4), off="6 % in the shape of the curve alone", error=0.06, heading=V2),
    ValidatedRange(quantity="shape of the curve", fabrics=JERSEY, loops=(60.0, 60.0), direction="wale",
                   strains=(0.05, 0.4), off="up to 21 % in the shape of the curve, 87 % in tension", error=0.21,
                   heading=V2),
    ValidatedRange(quantity="fitted solid", fabrics=JERSEY, loops=(21.9, 33.1), strains=(0.0, 0.3),
                   off="2.5 to 5.4 %, a solid from our own curves", error=0.054,
                   heading="V5: Jersey at three stitch settings, and a fitted solid"),
    ValidatedRange(quantity="work returned", fabrics=JERSEY, loops=(16.67, 16.67), friction=(0.2, 0.3),
                   off="0.53 to 0.62 up to 1 N/m, where about 0.5 is published", error=0.24, heading=V9),
    ValidatedRange(quantity="inner loops of friction", fabrics=("1x1 rib",), off="not validated", heading=V9),
    ValidatedRange(quantity="order of stiffness", fabrics=("seed", "garter"), off="not validated: laboratories differ",
                   heading="V3: Rib beside stockinette, and four patterns"),
    ValidatedRange(quantity="curl", fabrics=JERSEY, off="the signs only", heading="V11: Curl of stockinette"),
    ValidatedRange(quantity="spirality", fabrics=JERSEY, off="the signs and trends only", page="yarn-physics.md",
                   heading="Residual torque and spirality"),
    ValidatedRange(quantity="thickness", fabrics=("stockinette", "1x1 rib"), off="not validated", page="contact.md",
                   heading="Yarns: soft when squeezed"),
)  # fmt: skip
"""All comparisons; of two rows that hold the same loops, the better one stands first."""


@dataclass(frozen=True)
class RangeVerdict(Verdict):
    """Whether a computation lies where measurements were compared."""

    error: float | None = None
    """The error to expect, as a part of the value; None outside all ranges."""

    def __str__(self) -> str:
        """Return one line: ``Validated: ...`` or ``Not validated: ...``."""
        if self.good:
            return f"Validated: {self.praise}."
        return f"Not validated: {'. Also, '.join(map(str, self.findings))}."

    def report(self) -> dict[str, Any]:
        """Return the entries of a report: the findings, and the error to expect (None if it is not known)."""
        return {"ranges": [asdict(finding) for finding in self.findings], "expected_error": self.error}


NOT_JUDGED = RangeVerdict((), "")
"""The verdict on what was not judged, such as a size that is held."""


def fabric_of(source: Pattern | Weave) -> Fabric:
    """Return which of the compared fabrics a pattern is, from its stitches."""
    if isinstance(source, Weave):
        over = source.over
        plain = (over != np.roll(over, 1, axis=0)).all() and (over != np.roll(over, 1, axis=1)).all()
        return "plain weave" if plain and source.layer_count == 1 else "other"
    rows = source.rows
    cells = [cell for row in rows for cell in row.cells]
    plain = all(cell.stitch in (Stitch.KNIT, Stitch.PURL) and not any(cell.twist) for cell in cells)
    moved = any(loop.shift or loop.twist for row in rows for loop in row.loops)
    floats = any(len({cell.yarn for cell in row.cells}) > 1 for row in rows)
    if not plain or moved or floats or any(row.left + row.right for row in rows):
        return "other"
    knit = np.array([[cell.stitch == Stitch.KNIT for cell in row.cells] for row in rows])
    if (knit == knit[0, 0]).all():
        return "stockinette"
    changes: tuple[str, str] = (_change(knit, 1), _change(knit, 0))
    known: dict[tuple[str, str], Fabric] = {
        ("all", "none"): "1x1 rib", ("none", "all"): "garter", ("all", "all"): "seed",
    }  # fmt: skip
    return known.get(changes, "other")


def _change(knit: np.ndarray, axis: int) -> str:
    """Return whether all, none or some of the neighbours along an axis differ."""
    differ = knit != np.roll(knit, 1, axis=axis)
    return "all" if differ.all() else "some" if differ.any() else "none"


def swatch_verdict(
    source: Pattern | Weave, options: SwatchOptions, loop_length: float, material: YarnMaterial
) -> RangeVerdict:  # fmt: skip
    """Return whether the size and the lean of a swatch lie where measurements were compared.

    A size that is held is no result, and is not judged.

    Args:
        source: the pattern.
        options: the options of the swatch.
        loop_length: yarn length of a stitch at rest [cm].
        material: material of the yarn.
    """
    found, verdict = list[Finding](), NOT_JUDGED
    if options.blocked is not None or options.steamed or options.yield_curvature:
        treated = "the size of a fabric that is blocked or steamed, or whose bends last,"
        found.append(_outside(treated, None))
    elif options.has_free_size and options.period == (None, None):
        state = state_of_rest(options, woven=isinstance(source, Weave))
        loops = loop_length / (2.0 * options.yarn_radius)
        verdict = gauge_verdict(fabric_of(source), loops, state, material, options.yarn_radius)
    if options.residual_twist:
        found.append(Finding("not validated", "of spirality only the signs and trends were compared"))
    return replace(verdict, findings=(*verdict.findings, *found))


def gauge_verdict(
    fabric: Fabric, loops: float, state: KnitState, material: YarnMaterial | None = None, radius: float = 1.0
) -> RangeVerdict:  # fmt: skip
    """Return whether the size of a free swatch lies where measurements were compared.

    Args:
        fabric: the fabric (``fabric_of``).
        loops: yarn length of a stitch [core diameters].
        state: the state to which a knit relaxed.
        material: material of the yarn; None if only the loops count.
        radius: radius of the core of that yarn [cm].
    """
    rows = [row for row in _rows(("gauge", "width", "crimp"), fabric) if not row.states or state in row.states]
    found = [] if material is None else _findings_of_limp_yarn(material, radius)
    limp = bool(found)
    fitting = next((row for row in rows if row.holds_loops(loops)), None)
    if fitting is None:
        where = "" if fabric == "other" else f" with loops of {loops:.3g} core diameters"
        found.append(_outside(f"the size of {_named(fabric)}{where}", _nearest(rows, loops)))
    return _verdict(found, None if limp else fitting)


def tension_verdict(
    fabric: Fabric, loops: float, path: StretchPath, material: YarnMaterial, radius: float, quality: Quality
) -> RangeVerdict:  # fmt: skip
    """Return whether the tensions of a stretch test lie where measurements were compared.

    Args:
        fabric: the fabric (``fabric_of``).
        loops: yarn length of a stitch at rest [core diameters].
        path: the strains and the friction.
        material: material of the yarn.
        radius: radius of the core of that yarn [cm].
        quality: the quality that was asked for.
    """
    most, rows = max(path.ends), _rows(("tension", "shape of the curve"), fabric)
    along = [row for row in rows if row.direction in (None, path.direction)]
    measured = [row for row in along if row.quantity == "tension" and row.holds_loops(loops)]
    drawn = path.other == "free" and min(path.ends) >= 0.0
    within = [row for row in measured if drawn and row.strains and most <= row.strains[1] + ROUNDING]
    found = list[Finding]()
    if not within:
        held = " with the other direction held" if path.other == "held" else ""
        what = f"the tension of {_named(fabric)} along the {path.direction}s{held}"
        if fabric not in ("other", "plain weave"):
            what = f"{what} up to {100.0 * most:.3g} %, with loops of {loops:.3g} core diameters,"
        found.append(_outside(what, _nearest(along or rows, loops)))
    found += _findings_of_yarn(material, radius, within or measured or rows)
    if not within:
        found += _findings_of_contact(material, radius)
    known = within[0] if within and not found else None
    found += _findings_of_friction(fabric, loops, path)
    coarse = quality.control_points_per_stitch < PRESETS["standard"].control_points_per_stitch
    if coarse and most > DRAFT_STRAIN:
        checked = f"tensions of quality draft were compared with finer ones up to {100.0 * DRAFT_STRAIN:g} % only"
        found.append(Finding("coarse", checked, "take standard"))
    return _verdict(found, known)


def thickness_verdict(fabric: Fabric) -> RangeVerdict:
    """Return the verdict on the thickness of a fabric under pressure, which was compared with no measurement.

    Args:
        fabric: the fabric (``fabric_of``).
    """
    return _verdict([_outside(f"the thickness of {_named(fabric)} under pressure", None)], None)


def _findings_of_friction(fabric: Fabric, loops: float, path: StretchPath) -> list[Finding]:
    """Return what was not compared of a cycle with friction: its work, or loops inside of it."""
    if not path.friction or not (path.cycles or len(path.ends) > 2):
        return []
    if len(path.ends) > 2:
        return [Finding("not validated", "inner loops of friction are not validated (V9)")]
    rows = _rows(("work returned",), fabric)
    low, high = rows[0].friction or (0.0, math.inf) if rows else (0.0, 0.0)
    if rows and rows[0].holds_loops(loops) and low <= path.friction <= high:
        return []
    what = f"the work that {_named(fabric)} returns at a friction of {path.friction:g}"
    return [_outside(what, rows[0] if rows else None)]


def _findings_of_yarn(material: YarnMaterial, radius: float, rows: Sequence[ValidatedRange]) -> list[Finding]:
    """Return what of a yarn no measurement supports, for its tensions."""
    name = named_material(material, radius)
    if name is not None:
        text = (f"the material {name} is that of no measured yarn, and as thick yarn its tensions are one to three "
                "orders too low for industrial knits")  # fmt: skip
        return [Finding("unmeasured yarn", text, "name a yarn")]
    stretch = material.axial_stiffness / material.mass_per_length / NEWTON_PER_TEX if material.mass_per_length else 0.0
    known = [row.stretch for row in rows if row.stretch is not None]
    low, high = (min(each[0] for each in known), max(each[1] for each in known)) if known else (0.0, math.inf)
    if low <= stretch <= high:
        return []
    yarns = f"compared yarns have {range_words((low, high))}"
    return [Finding("unmeasured yarn", f"the yarn resists stretch by {stretch:.2g} N/tex; {yarns}")]


def _findings_of_contact(material: YarnMaterial, radius: float) -> list[Finding]:
    """Return the finding that nobody stated how a yarn resists compression; compared yarns have this fault too."""
    assumed = math.isclose(_contact_over_bending(material, radius), _USUAL, rel_tol=ROUNDING)
    if not assumed or named_material(material, radius) is not None:
        return []
    text = "contact is assumed, as stiff over bending as in the default material"
    return [Finding("assumed contact", text, "state the transverse_modulus of the yarn")]


def _findings_of_limp_yarn(material: YarnMaterial, radius: float) -> list[Finding]:
    """Return the finding that a yarn bends too easily to shape its loops, if it does."""
    if _contact_over_bending(material, radius) < STIFF_CONTACT * _USUAL:
        return []
    return [Finding("unmeasured yarn", "the yarn is so limp that its bending hardly determines the gauge")]


def named_material(material: YarnMaterial, radius: float) -> str | None:
    """Return the name of the material of ``NAMED`` that this one is at a radius [cm], apart from its mass; or None."""
    own = material.of_radius(REFERENCE_RADIUS, radius)
    parts = ("k_len", "k_length", "k_bend", "k_contact", "segment_length")
    for name, other in NAMED.items():
        if all(math.isclose(getattr(own, part), getattr(other, part), rel_tol=ROUNDING) for part in parts):
            return name
    return None


def _contact_over_bending(material: YarnMaterial, radius: float) -> float:
    """Return k_contact r^3 / k_bend, which is the same at every radius of one material."""
    return material.k_contact * radius**3 / material.k_bend if material.k_bend else math.inf


_USUAL = _contact_over_bending(YarnMaterial.named(), REFERENCE_RADIUS)


def _rows(quantities: Iterable[Quantity], fabric: Fabric) -> list[ValidatedRange]:
    return [row for row in RANGES if row.quantity in quantities and fabric in row.fabrics]


def _nearest(rows: Sequence[ValidatedRange], loops: float) -> ValidatedRange | None:
    """Return the row whose loops are nearest, by the ratio of lengths."""

    def distance(row: ValidatedRange) -> float:
        low, high = row.loops or (loops, loops)
        return max(math.log(low / loops), math.log(loops / high), 0.0)

    return min(rows, key=distance, default=None)


def _outside(what: str, nearest: ValidatedRange | None) -> Finding:
    """Return the finding that something was compared with no measurement, with the error where it was."""
    text = f"{what} was compared with no measurement"
    if nearest is None:
        return Finding("not validated", text)
    return Finding("not validated", f"{text} (nearest: {nearest.words})", "expect a larger error")


def _verdict(found: Sequence[Finding], row: ValidatedRange | None) -> RangeVerdict:
    praise = "" if row is None else f"the {row.quantity} is off measured ones by {row.off} ({row.section})"
    return RangeVerdict(tuple(found), praise, None if row is None else row.error)


def _named(fabric: Fabric) -> str:
    return "this pattern" if fabric == "other" else fabric


def range_words(ends: Sequence[float]) -> str:
    """Return the ends of a range in words; one number if they are equal."""
    low, high = (f"{each:.3g}" for each in ends)
    return low if low == high else f"{low} to {high}"
