# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A clock whose time is the number of looks at it, so that tests of limits do not depend on the machine."""

from __future__ import annotations


class CountingClock:
    """A clock on which every look takes a second."""

    def __init__(self) -> None:
        self.looks = 0

    def __call__(self) -> float:
        self.looks += 1
        return float(self.looks)
