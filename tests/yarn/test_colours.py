# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of rows distinguish neighbouring rows."""

from __future__ import annotations

import numpy as np

from stitchmesh.yarn.colours import row_colours


def test_neighbouring_rows_differ_clearly_in_brightness():
    for count in (2, 7, 300):
        brightness = row_colours(np.arange(count)) @ [0.299, 0.587, 0.114]
        # A difference of a tenth of the range, 25 of 255, is clearly visible.
        assert (np.abs(np.diff(brightness)) > 25).all()
