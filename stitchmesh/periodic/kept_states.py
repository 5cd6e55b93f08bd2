# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks that the memory holds many states of one repeat, which are kept until the last of them is at rest."""

from __future__ import annotations

from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_KEPT_POINT, check_memory
from stitchmesh.yarn import YarnSet


def check_kept_states(what: str, states: int, yarns: YarnSet) -> None:
    """Refuse states that do not fit into the memory.

    Args:
        what: the command, for the message.
        states: number of states.
        yarns: the yarns of one state.

    Raises:
        ParameterError: the states need more memory than there is (``check_memory``).
    """
    needed = BASE_MEMORY + BYTES_PER_KEPT_POINT * len(yarns.points) * states
    check_memory(f"{what} with {states:,} states of {len(yarns.points)} control points", needed, "fewer of them")
