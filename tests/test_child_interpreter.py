# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Child interpreters find the packages of their parent, and no module in the present folder."""

from __future__ import annotations

import multiprocessing
import os
import re
import subprocess
import sys

import pytest

from stitchmesh.child_interpreter import PACKAGES, clean_children, clean_environment, python_command, search_path
from tests.gallery import ROOT


@pytest.fixture(autouse=True)
def trap(tmp_path, monkeypatch):
    """A present folder with modules that say so when they are executed."""
    for name in ("sitecustomize", "usercustomize", "numpy", "multiprocessing"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'sprung')!r}, 'a').write({name!r})\n")
    monkeypatch.chdir(tmp_path)
    yield
    assert not (tmp_path / "sprung").exists()


def test_a_child_finds_the_package_and_nothing_in_the_present_folder(tmp_path, monkeypatch):
    named = ["", ".", str(tmp_path), f"{tmp_path}/../{tmp_path.name}"]
    monkeypatch.setattr(sys, "path", [*named, *sys.path])
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(["", str(tmp_path)]))
    code = "import multiprocessing, numpy, stitchmesh; print(stitchmesh.__path__[0])"
    done = subprocess.run(python_command("-c", code), env=clean_environment(), capture_output=True, text=True)
    assert done.stdout == f"{PACKAGES}/stitchmesh\n", done.stderr


def test_the_folder_of_the_package_stays_at_its_place_when_it_is_the_present_one(monkeypatch):
    monkeypatch.chdir(PACKAGES)
    others = [entry for entry in sys.path if entry not in ("", PACKAGES)]
    monkeypatch.setattr(sys, "path", ["", *others])
    assert search_path() == [PACKAGES, *dict.fromkeys(others)]


def test_an_entry_that_the_variable_would_cut_into_two_is_left_out(monkeypatch):
    monkeypatch.setattr(sys, "path", ["/data/a:b", *sys.path])
    assert not any("/data/a" in entry for entry in search_path())


def test_processes_of_libraries_start_clean_within_the_block():
    before = dict(os.environ)
    with clean_children():
        process = multiprocessing.get_context("spawn").Process(target=os.getpid)
        process.start()
        process.join()
    assert process.exitcode == 0
    assert dict(os.environ) == before


def test_no_other_place_starts_an_interpreter():
    for path in (ROOT / "stitchmesh").rglob("*.py"):
        text = path.read_text()
        started = re.findall(r"subprocess\.(?:run|Popen|call|check_call|check_output)\(\s*(\w+)", text)
        clean = re.findall(r"env=(?:\{\*\*)?clean_environment\(\)", text)
        assert set(started) <= {"python_command"} and len(clean) == len(started), path
        assert path.name == "child_interpreter.py" or "sys.executable" not in text, path
        other = r"import multiprocessing|from multiprocessing|ProcessPool|os\.(exec|spawn|system)"
        assert not re.search(other, text), path
