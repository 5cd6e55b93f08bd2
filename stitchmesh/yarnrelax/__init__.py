# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Physical relaxation of yarns (Leaf 2018, section 3; Yuksel 2012, section 6.3).

Names are loaded when first used, so that the command line reads the names of materials without Warp.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.cell import RelaxCell
    from stitchmesh.yarnrelax.energies import yarn_energies, yarn_forces
    from stitchmesh.yarnrelax.linking import linking_certificate
    from stitchmesh.yarnrelax.material import REFERENCE_RADIUS, YarnMaterial
    from stitchmesh.yarnrelax.solver import Relaxation, relax_yarns

_HOME = {
    "RelaxCell": "cell",
    "yarn_energies": "energies",
    "yarn_forces": "energies",
    "linking_certificate": "linking",
    "REFERENCE_RADIUS": "material",
    "YarnMaterial": "material",
    "Relaxation": "solver",
    "relax_yarns": "solver",
}
"""Module of each public name."""

__all__ = [
    "REFERENCE_RADIUS",
    "RelaxCell",
    "Relaxation",
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
