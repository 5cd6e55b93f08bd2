# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Residuals and energies of states, which ``convergence`` judges.

A batch has thousands of cells, and each of them is assessed every few iterations. Their assessments and remaining
changes are therefore arrays over the cells (``Assessments``, ``RemainingChanges``), and the assessment or the remaining
change of one cell (``Assessment``, ``RemainingChange``) is made from them when needed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.quality import MORE_DIGITS

ABOVE_NOISE = 4.0
"""Forces are significant above this ratio to the noise, because the noise of one place varies by about this factor."""
MORE_ITERATIONS = "raise max_iterations"
"""Advice for yarns that more iterations would bring nearer to rest."""


@dataclass(frozen=True)
class RemainingChange:
    """Estimate of the remaining change between a state and rest."""

    spacing: float
    """Largest relative change of the periods of a cell. For a piece that ends with Newton's method, the rms relative
    change of the distances between neighbouring stitches; for other pieces, the change of the mean distance along the
    yarns or across them."""
    energy: float
    """Relative change of the energy."""
    rms_radii: float
    """The rms displacement in yarn radii: of the control points, or of the stitches if Newton's method does not end."""


@dataclass(frozen=True, eq=False)
class RemainingChanges:
    """Estimates of the remaining changes of C cells; an index gives that of a cell, or None if it is unknown."""

    spacing: NDArray[np.float64]
    """Relative changes of the spacing, as in ``RemainingChange``; infinite where they are unknown, shape (C,)."""
    energy: NDArray[np.float64]
    """Relative changes of the energy, shape (C,)."""
    rms_radii: NDArray[np.float64]
    """The rms displacements in yarn radii, shape (C,)."""

    @classmethod
    def unknown(cls, count: int) -> RemainingChanges:
        """Return the estimates of cells of which nothing is known."""
        return cls(np.full(count, np.inf), np.full(count, np.inf), np.full(count, np.inf))

    def __getitem__(self, cell: int) -> RemainingChange | None:
        """Return the estimate of a cell; None if it is unknown."""
        own = (float(self.spacing[cell]), float(self.energy[cell]), float(self.rms_radii[cell]))
        return RemainingChange(*own) if np.isfinite(own[0]) else None

    def forgotten(self, cells: NDArray[np.bool_]) -> RemainingChanges:
        """Return these estimates, unknown in some cells, shape (C,)."""
        return replace(self, spacing=np.where(cells, np.inf, self.spacing))

    def replaced(self, cells: NDArray[np.bool_], others: RemainingChanges) -> RemainingChanges:
        """Return these estimates, with those of ``others`` in some cells, shape (C,)."""
        return RemainingChanges(*(np.where(cells, getattr(others, each.name), getattr(self, each.name))
                                  for each in fields(self)))  # fmt: skip

    def with_cell(self, cell: int, left: RemainingChange | None) -> RemainingChanges:
        """Return these estimates with another one of a cell."""
        chosen = np.arange(len(self.spacing)) == cell
        if left is None:
            return self.forgotten(chosen)
        one = RemainingChanges(*(np.full(len(chosen), value) for value in astuple(left)))
        return self.replaced(chosen, one)


@dataclass(frozen=True)
class Assessment:
    """Residual and energies of a state."""

    residual: float
    """Relative force residual."""
    energies: dict[str, float]
    """Energy of each term [erg]."""
    rounding: float = 0.0
    """Residual that the rounding of coordinates alone causes; 0 if it is certainly less than ``residual``."""
    hidden: bool = False
    """Whether all forces of loaded yarns are noise, so that nothing can say whether the yarns are at rest."""

    @property
    def energy(self) -> float:
        """Total energy [erg]."""
        return sum(self.energies.values())

    @property
    def size(self) -> float:
        """Sum of the magnitudes of the energies [erg]."""
        return sum(abs(energy) for energy in self.energies.values())

    @property
    def is_noise(self) -> bool:
        """Whether the residual cannot be distinguished from the effect of rounding."""
        return self.residual <= ABOVE_NOISE * self.rounding

    def remedy(self, tolerance: float) -> str:
        """Advice for yarns that are not at rest: a higher precision if rounding hides rest, else more iterations."""
        if self.hidden or (self.is_noise and self.rounding > tolerance):
            return f"rounding of coordinates alone leaves {self.rounding:.2g}: {MORE_DIGITS}"
        return MORE_ITERATIONS

    @property
    def finite(self) -> bool:
        """Whether the residual and all energies are finite."""
        return bool(np.isfinite(self.residual) and np.isfinite(self.energy))


@dataclass(frozen=True, eq=False)
class Assessments:
    """Residuals and energies of the states of C cells; indices and loops give the assessment of each cell."""

    residual: NDArray[np.float64]
    """Relative force residuals, shape (C,)."""
    energies: Mapping[str, NDArray[np.float64]]
    """Energies of each term [erg], each of shape (C,)."""
    rounding: NDArray[np.float64]
    """Residuals that rounding alone causes, as in ``Assessment``, shape (C,)."""
    hidden: NDArray[np.bool_]
    """Whether the forces of loaded yarns are noise, as in ``Assessment``, shape (C,)."""

    @classmethod
    def of(cls, cells: Sequence[Assessment]) -> Assessments:
        """Return the assessments of cells that have the same terms."""
        names = cells[0].energies if cells else ()
        energies = {name: np.array([each.energies[name] for each in cells]) for name in names}
        residual, rounding = ([getattr(each, name) for each in cells] for name in ("residual", "rounding"))
        hidden = np.array([each.hidden for each in cells], dtype=bool)
        return cls(np.array(residual, dtype=np.float64), energies, np.array(rounding, dtype=np.float64), hidden)

    def __len__(self) -> int:
        """Return the number of cells."""
        return len(self.residual)

    def __getitem__(self, cell: int) -> Assessment:
        """Return the assessment of a cell."""
        energies = {name: float(own[cell]) for name, own in self.energies.items()}
        return Assessment(
            float(self.residual[cell]), energies, float(self.rounding[cell]), bool(self.hidden[cell])
        )  # fmt: skip

    def __iter__(self) -> Iterator[Assessment]:
        """Return the assessments of all cells, one after another."""
        return (self[cell] for cell in range(len(self)))

    @property
    def energy(self) -> NDArray[np.float64]:
        """Total energies [erg], shape (C,)."""
        return sum(self.energies.values(), start=np.zeros(len(self)))

    @property
    def size(self) -> NDArray[np.float64]:
        """Sums of the magnitudes of the energies [erg], shape (C,)."""
        return sum((np.abs(own) for own in self.energies.values()), start=np.zeros(len(self)))

    @property
    def is_noise(self) -> NDArray[np.bool_]:
        """Whether each residual cannot be distinguished from the effect of rounding, shape (C,)."""
        return self.residual <= ABOVE_NOISE * self.rounding

    def hides_rest(self, tolerance: float) -> NDArray[np.bool_]:
        """Whether rounding alone leaves a cell above the tolerance, or all its forces are noise, shape (C,)."""
        return self.hidden | (self.is_noise & (self.rounding > tolerance))

    @property
    def finite(self) -> NDArray[np.bool_]:
        """Whether the residual and all energies of each cell are finite, shape (C,)."""
        return np.isfinite(self.residual) & np.isfinite(self.energy)

    def replaced(self, cells: NDArray[np.bool_], others: Assessments) -> Assessments:
        """Return these assessments, with the assessments of ``others`` for the chosen ``cells``, shape (C,)."""
        energies = {name: np.where(cells, others.energies[name], own) for name, own in self.energies.items()}
        residual, rounding = (np.where(cells, getattr(others, name), getattr(self, name))
                              for name in ("residual", "rounding"))  # fmt: skip
        return Assessments(residual, energies, rounding, np.where(cells, others.hidden, self.hidden))
