# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Controls without a panel refuse what a user could not do either."""

from __future__ import annotations

import pytest

from stitchmesh.errors import ParameterError
from tests.app.null_front import NullControls


@pytest.mark.parametrize("value", [0.0, 5.1, float("nan"), "wide", None, True])
def test_a_number_takes_nothing_beyond_its_bounds(value):
    controls, calls = NullControls(), []
    number = controls.number("Width", "Wale spacing.", 0.8, calls.append, least=0.1, most=5.0, step=0.1)
    with pytest.raises(ParameterError, match=r"Width: got .*; expected 0.1 to 5"):
        controls.set("Width", value)
    assert calls == [] and number.value == 0.8
