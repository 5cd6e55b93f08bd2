# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The product with the Hessian of a mixed system, for tests that compare it with other ways."""

from __future__ import annotations

from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.mixed_vector import MixedVector


def set_hessian_product(system: MixedSystem, direction: MixedVector, product: MixedVector) -> None:
    """Set ``product`` to H d of the last ``linearize``."""
    product.values.zero_()
    for term in system.terms:
        term.products(direction, product, system.launch)
