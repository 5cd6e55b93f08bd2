# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The smallest cell of a swatch at rest, with all that acted on it. Later questions about this state use it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stitchmesh.compute.device import device_named
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs


@dataclass(frozen=True, eq=False)
class CellAtRest:
    """A cell at rest.

    Its lengths are gamma times the lengths in the fabric, and its material is scaled in the same way.
    """

    yarns: YarnSet
    """The relaxed yarns of the cell, on its lattice."""
    material: YarnMaterial
    """Material of the yarns at this size."""
    quality: Quality
    """Resolution of the relaxation."""
    cell: RelaxCell | None
    """The free changes of the periods and their loads; None for constant periods."""
    terms: Sequence[TermChoice]
    """The planes between which the cell lies; empty if it lies on nothing."""
    device: str | None
    """Device of the kernels."""
    gamma: float = 1.0
    """The lengths of the cell over the lengths in the fabric."""
    rubs: bool = False
    """Whether friction between the yarns held the cell on its way to rest."""

    @classmethod
    def of(cls, prepared: PreparedSwatch, yarns: YarnSet) -> CellAtRest:
        """Return the cell of a prepared repeat, whose smallest cell came to rest with these yarns."""
        return cls(
            yarns, prepared.similar, prepared.quality, prepared.cell, prepared.terms, prepared.device,
            prepared.options.gamma, prepared.release is not None,
        )  # fmt: skip

    @property
    def inputs(self) -> RelaxationInputs:
        """The inputs of a relaxation that goes on from this state."""
        return RelaxationInputs(
            self.yarns, self.material, self.quality, device_named(self.device), self.terms, cell=self.cell
        )  # fmt: skip
