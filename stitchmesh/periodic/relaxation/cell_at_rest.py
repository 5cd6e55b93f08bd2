# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The smallest cell of a swatch as it came to rest, with what acted on it, for questions about that state."""

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
    """A cell at rest. Lengths are gamma times those of the fabric, and the material belongs to them."""

    yarns: YarnSet
    """The relaxed yarns of the cell, on its lattice."""
    material: YarnMaterial
    """Material of the yarns at this size."""
    quality: Quality
    """Resolution of the relaxation."""
    cell: RelaxCell | None
    """The free changes of the periods and their loads; None for constant periods."""
    terms: Sequence[TermChoice]
    """What the cell lies on."""
    device: str | None
    """Device of the kernels."""
    gamma: float = 1.0
    """Lengths over those of the fabric."""
    rubs: bool = False
    """Whether friction between its yarns has held it on its way."""

    @classmethod
    def of(cls, prepared: PreparedSwatch, yarns: YarnSet) -> CellAtRest:
        """Return the cell of a prepared repeat whose smallest cell came to rest with these yarns."""
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
