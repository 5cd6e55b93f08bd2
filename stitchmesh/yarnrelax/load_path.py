# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The path of loads for yarns that cannot take the whole load at once: the inputs of each step of a relaxation.

A relaxation starts where the yarns are, with the whole load. If rest lengths, stiffnesses or the radius are far from
the values that suit the start, the forces press yarns together before the fabric can follow, and nothing can move any
more (``step_limit``). The load is then applied in steps. At the share s of the load

    L(s) = L0^(1-s) L^s          rest length of each segment; L0 is its length at the start
    k(s) = k0^(1-s) k^s          bending and contact; at the start, bending is at most as stiff, and contact at least as
                                 stiff, as in yarn of the default material with the same resistance to stretching
    r(s) = r t^(1-s)             radius; t is 1, or less if the yarns start too close to each other; the stiffnesses
                                 are scaled with it
    P(s) = s P                   loads on the borders of a cell

Yarn that is thin for the length of its segments moves a part of its radius at a time, and takes long. A piece of such
yarn that is not near rest after ``TRIAL_ITERATIONS`` is relaxed with thicker yarn (t > 1) first.

``LoadPosition`` says which steps follow. If no step is left, the message says how much of the load the yarns took.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stitchmesh.errors import OverloadError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.load_position import LoadPosition
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

MOST_STRAIN = 100.0
"""Largest ratio, up or down, of a segment's length at the start to its rest length with which the path begins."""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """The inputs that the caller asked for, and the way to them."""

    asked: RelaxationInputs

    def inputs_at(self, position: LoadPosition) -> RelaxationInputs:
        """Return the inputs of a step, with its start."""
        asked, share = self.asked, position.share
        quality = asked.quality
        if position.finer > 1:
            quality = replace(quality, contact_samples=position.finer * quality.contact_samples)
        yarns, points = asked.yarns, asked.points
        if position.periods is not None and asked.cell is not None:
            yarns = replace(yarns, lattice=Lattice(position.periods))
        if position.points is not None:
            points = position.points
        if position.is_whole:
            return replace(asked, yarns=yarns, quality=quality, points=points)
        rest_length = _between(self._first_lengths(), yarns.rest_length, share)
        yarns = replace(yarns, rest_length=rest_length, radius=yarns.radius * position.thin ** (1.0 - share))
        material, cell = self._material_at(share, position.thin), _loaded(asked.cell, share)
        return replace(asked, yarns=yarns, material=material, quality=quality, points=points, cell=cell)

    @property
    def slenderness(self) -> float:
        """Median length of a segment over the radius."""
        yarns = self.asked.yarns
        return float(np.median(yarns.rest_length / yarns.radius[yarns.segment_yarn]))

    @property
    def is_slender(self) -> bool:
        """Whether the yarn is so thin that thicker yarn comes to rest in fewer iterations.

        This holds for pieces. Thicker yarn would lead a relaxing cell to other strains, so that nothing would be
        gained.
        """
        return self.asked.cell is None and self.slenderness > 20.0

    def thick_start(self, iterations: int) -> LoadPosition:
        """Return the position at share 0, with segments that are 3 radii long, after a trial of ``iterations``."""
        reason = f"the yarn is thin, its segments are {self.slenderness:.3g} radii long"
        return LoadPosition(share=0.0, thin=self.slenderness / 3.0, reason=reason, iterations=iterations)

    def with_asked_inputs(self, yarns: YarnSet) -> YarnSet:
        """Return the yarns of a step with the rest lengths and radii that the caller asked for."""
        asked = self.asked.yarns
        return replace(asked, points=yarns.points, lattice=yarns.lattice)

    def refusal(self, error: OverloadError, position: LoadPosition) -> OverloadError:
        """Return the error if no step is left: the reason, the reached share of the load, and what would help."""
        if position.reached is None or position.points is None:
            return OverloadError(position.reason or str(error))
        head, stretched = str(error).split(";")[0], self._strain_at(position)
        load = f"{position.reached:.2g} of the load ({self._changes(position)})"
        took = f"the yarns took {load} in {position.steps} steps, stretched by {100 * stretched:.2g} %"
        # wool yarn breaks at a strain of 25 to 35 %
        remedy = "the yarn cannot be that short, give longer" if stretched > 0.3 else "take thinner or longer"
        remedy = "take a smaller load, thicker" if self._pulls else remedy
        return OverloadError(f"{head}; {took}; {remedy} yarn, a smaller k_bend or a larger k_contact (--stiffness)")

    @property
    def _pulls(self) -> bool:
        """Whether loads act on the borders of a cell."""
        cell = self.asked.cell
        return cell is not None and bool(cell.course or cell.wale)

    def _first_lengths(self) -> FloatArray:
        """Return the rest lengths at share 0 [cm], shape (S,)."""
        asked = self.asked
        start = asked.yarns if asked.points is None else replace(asked.yarns, points=asked.points)
        rest = asked.yarns.rest_length
        return np.clip(start.lengths, rest / MOST_STRAIN, rest * MOST_STRAIN)

    def _first_material(self) -> YarnMaterial:
        """Return the stiffnesses at share 0."""
        own = self.asked.material
        usual = YarnMaterial.named().of_radius(float(self.asked.yarns.radius.mean()))
        level = own.k_length / usual.k_length if own.k_length > 0.0 else own.k_len / usual.k_len
        k_bend, k_contact = min(own.k_bend, level * usual.k_bend), max(own.k_contact, level * usual.k_contact)
        return replace(own, k_bend=k_bend, k_contact=k_contact)

    def _material_at(self, share: float, thin: float) -> YarnMaterial:
        first, last = self._first_material(), self.asked.material
        found = {name: _between(getattr(first, name), getattr(last, name), share) for name in ("k_bend", "k_contact")}
        return replace(last, **found).scaled(thin ** (1.0 - share))

    def _strain_at(self, position: LoadPosition) -> float:
        """Return the largest magnitude of the strain at the share that was reached."""
        at = replace(position, share=position.reached if position.reached is not None else 1.0)
        inputs = self.inputs_at(at)
        assert inputs.points is not None
        return float(np.abs(replace(inputs.yarns, points=inputs.points).strain).max())

    def _changes(self, position: LoadPosition) -> str:
        """Return, in words, the inputs that differ between the two ends of the path."""
        rest_length = float(np.median(self.asked.yarns.rest_length / self._first_lengths()))
        first, last = self._first_material(), self.asked.material
        factors = {"rest lengths": rest_length, "radius": 1.0 / position.thin}
        factors |= {name: _ratio(getattr(last, name), getattr(first, name)) for name in ("k_bend", "k_contact")}
        named = [f"{name} x {factor:.2g}" for name, factor in factors.items() if abs(factor - 1.0) > 0.02]
        if self._pulls:
            named.append("the loads on the cell")
        return ", ".join(named) or "rest lengths of single segments"


def _between(first: Any, last: Any, share: float) -> Any:
    """Return the geometric mean of two positive numbers, or of two arrays entry by entry, weighted by the share."""
    if np.all(first == last):
        return last
    return first ** (1.0 - share) * last**share


def _ratio(last: float, first: float) -> float:
    return last / first if first > 0.0 else 1.0


def _loaded(cell: RelaxCell | None, share: float) -> RelaxCell | None:
    """Return the cell with a share of its loads."""
    if cell is None:
        return None
    course, wale = (None if load is None else share * load for load in (cell.course, cell.wale))
    return replace(cell, course=course, wale=wale)
