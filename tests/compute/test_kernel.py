# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch, prepare

CPU = wp.get_device("cpu")


@kernel
def double(values: wp.array[Any], doubled: wp.array[Any]) -> None:
    i = wp.tid()
    doubled[i] = values[i] + values[i]


def test_a_kernel_of_other_types_leaves_the_compiled_one_as_it_is() -> None:
    """Warp would compile both combinations of types again, in one module, and load it in place of the first."""
    single = [wp.array([1.5, 2.5], dtype=wp.float32, device=CPU) for _ in range(2)]
    exact = [wp.array([1.5, 2.5], dtype=wp.float64, device=CPU) for _ in range(2)]
    first = prepare(double, 2, single[:1], single[1:], CPU)
    code = first.hooks.forward
    launch(double, 2, exact[:1], exact[1:], CPU)
    again = prepare(double, 2, single[:1], single[1:], CPU)
    assert again.kernel is first.kernel
    assert again.hooks.forward is code
    again.launch()
    assert single[1].numpy().tolist() == exact[1].numpy().tolist() == [3.0, 5.0]
