# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Every example runs, and its yarns are valid and have small strains."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from tests.gallery import ROOT

EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(path, tmp_path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yarns = module.main(tmp_path, 2.5)
    assert np.isfinite(yarns.points).all()
    assert np.abs(yarns.strain).max() < 0.05  # The largest strain of a garment's yarn that the README allows.
    assert any(tmp_path.iterdir())


def test_there_are_examples():
    assert EXAMPLES
