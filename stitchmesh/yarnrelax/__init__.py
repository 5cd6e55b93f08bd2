# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Physical relaxation of yarns (Leaf 2018, section 3; Yuksel 2012, section 6.3).

Names are loaded when first used, so that the command line reads the names of materials without Warp.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.evaluate import yarn_energies, yarn_forces
    from stitchmesh.yarnrelax.linking.certificate import linking_certificate
    from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS, YarnMaterial
    from stitchmesh.yarnrelax.relax import Relaxation, relax_yarns
    from stitchmesh.yarnrelax.relax_cells import RelaxedCell, RelaxedCells
    from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

_HOME = {
    "yarn_energies": "evaluate",
    "yarn_forces": "evaluate",
    "linking_certificate": "linking.certificate",
    "REFERENCE_RADIUS": "model.material",
    "YarnMaterial": "model.material",
    "Relaxation": "relax",
    "relax_yarns": "relax",
    "RelaxedCell": "relax_cells",
    "RelaxedCells": "relax_cells",
    "RelaxCell": "solvers.cell_strain",
}
"""Module of each public name."""

__all__ = [
    "REFERENCE_RADIUS",
    "RelaxCell",
    "Relaxation",
    "RelaxedCell",
    "RelaxedCells",
    "YarnMaterial",
    "linking_certificate",
    "relax_yarns",
    "yarn_energies",
    "yarn_forces",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
