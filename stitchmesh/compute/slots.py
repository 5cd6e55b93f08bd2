# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Slots of a list that many threads fill at the same time, in no particular order.

Warp's own atomic addition is atomic on a GPU only. On a CPU several threads may share a launch (``launch``).
"""

# no postponed annotations: Warp evaluates the types of native functions directly
# mypy: disable-error-code="valid-type,no-untyped-def,empty-body"

import warp as wp

_NEXT = """
#if defined(__CUDA_ARCH__)
    return atomicAdd(taken.data, 1);
#else
    return __atomic_fetch_add(taken.data, 1, __ATOMIC_RELAXED);
#endif
"""


@wp.func_native(_NEXT)
def next_slot(taken: wp.array1d(dtype=wp.int32)) -> int:
    """A slot that no other thread gets; ``taken`` counts the slots, shape (1,)."""
    ...
