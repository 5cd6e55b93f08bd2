# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The library of weaves: each weave agrees with its name."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.periodic.weave.library import read_weave, weave_names
from tests.periodic.weave.stitching import stitching

SINGLE_LAYER = {
    "plain": (2, lambda i, j: (i + j) % 2 == 1),
    "basket-2x2": (4, lambda i, j: (i // 2 + j // 2) % 2 == 1),
    "basket-3x3": (6, lambda i, j: (i // 3 + j // 3) % 2 == 1),
    "twill-2x1": (3, lambda i, j: (j - i) % 3 < 2),
    "twill-3x2": (5, lambda i, j: (j - i) % 5 < 3),
    "twill-4x1": (5, lambda i, j: (j - i) % 5 < 4),
    "satin-2x3": (5, lambda i, j: (j - 2 * i) % 5 < 2),
    "satin-3x2": (5, lambda i, j: (j - 2 * i) % 5 < 3),
}
"""Size of the repeat, and whether weft i passes over warp j, for the eight weaves of Leaf et al. 2018, table 3."""
LAYERED = {"double-plain-stitched": 2, "triple-plain-stitched": 3, "orthogonal-interlock": 3}
"""Number of layers of each weave with several layers."""


@pytest.mark.parametrize("name", SINGLE_LAYER)
def test_weaves_agree_with_their_formulas(name):
    size, weft_is_over = SINGLE_LAYER[name]
    wefts, warps = np.indices((size, size))
    assert np.array_equal(read_weave(name).over, weft_is_over(wefts, warps))


def test_every_weave_is_known_and_has_a_name_and_a_source():
    assert set(weave_names()) == {*SINGLE_LAYER, *LAYERED, "double-cloth-exchanging"}
    for name in weave_names():
        assert read_weave(name).source and read_weave(name).name != f"{name}.weave"


@pytest.mark.parametrize("name", LAYERED)
def test_layers_are_stitched(name):
    weave = read_weave(name)
    assert weave.layer_count == LAYERED[name]
    assert len(stitching(weave)) >= LAYERED[name] - 1


def test_layers_exchange_in_a_checked_pattern():
    """Seen from the back, the checks have exchanged colours: each set of yarns lies in front in half of the checks."""
    over = read_weave("double-cloth-exchanging").over
    first_in_front = over[0::2, 1::2]
    assert first_in_front[:4, :4].all() and not first_in_front[:4, 4:].any()
    assert np.array_equal(over[1::2, 0::2], ~first_in_front)


def test_wrong_names_and_paths_are_refused(tmp_path):
    with pytest.raises(ParameterError, match=r"'satin2x3': is not in the library of \d+ weaves; did you mean satin"):
        read_weave("satin2x3")
    with pytest.raises(FileError, match=r"none\.weave: there is no such file"):
        read_weave(tmp_path / "none.weave")
    (tmp_path / "cloth.weave").write_text("01\n12\n")
    with pytest.raises(PatternError, match=r"cloth\.weave: line 2, column 2: got '2'"):
        read_weave(tmp_path / "cloth.weave")
