# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Products with the Hessian are those of the assembled matrix."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from tests.yarnrelax.hessian.scenes import SCENES, Scene, forces_at, mixture, points_of, started


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_products_are_those_of_the_assembled_matrix(scene: Scene) -> None:
    exact = 0.7
    simulation = started(*scene)
    model = simulation.model
    forces_at(simulation, points_of(simulation))  # places the contact samples
    hessian = Hessian(model, simulation.state, simulation.candidates)
    hessian.exact.fill_(exact)
    hessian.find_launches(model.launch)
    given = np.random.default_rng(3).normal(size=(model.point_count, 3))
    motion, product = model.upload(given, 3), model.empty(model.point_count, 3)
    hessian.product_launches(motion, product, model.launch)
    expected = (mixture(*scene, exact) @ given.ravel()).reshape(-1, 3)
    np.testing.assert_allclose(product.numpy(), expected, atol=1e-12 * np.abs(expected).max())  # rounding of sums
