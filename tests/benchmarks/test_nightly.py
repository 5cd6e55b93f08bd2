# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures that look for faults find none, with another seed each day: ``make test-nightly``."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.fuzz import SEED
from tests.gallery import ROOT

FUZZERS = {
    "crash-safety": ["--kills", "40", "--seed", SEED],
    "disk-refusals": [],
    "extremes": ["--device", "cpu"],
    "mixed-extremes": [],
    "swatch-extremes": ["--device", "cpu"],
    "stranded-charts": ["--device", "cpu", "--count", "60", "--seed", SEED],
}
"""Measures whose exit status says whether a rule is broken, and their options."""


@pytest.mark.nightly
@pytest.mark.parametrize("name", FUZZERS)
def test_a_fuzzer_finds_no_fault(name):
    if name == "disk-refusals" and subprocess.run(["unshare", "--mount", "true"], capture_output=True).returncode != 0:
        pytest.skip("a disk can be mounted by root only")
    command = [sys.executable, "benchmarks/run.py", name, *FUZZERS[name]]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr[-2000:]
