# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The probe turns a crash of the graphics library into an error message of one line."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from stitchmesh.errors import DisplayError
from stitchmesh.render import gl_probe
from stitchmesh.render.gl_probe import check_display


@pytest.fixture(autouse=True)
def _forget():
    gl_probe._failure.cache_clear()
    yield
    gl_probe._failure.cache_clear()


def answer(monkeypatch, *, status: int = 0, stderr: str = "", error: Exception | None = None) -> list[object]:
    calls: list[object] = []

    def run(command, **options):
        calls.append(command)
        if error is not None:
            raise error
        return subprocess.CompletedProcess(command, status, "", stderr)

    monkeypatch.setattr(gl_probe.subprocess, "run", run)
    return calls


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"status": -11}, "VTK was ended by signal 11"),
        (
            {"status": 1, "stderr": "Traceback\nModuleNotFoundError: No module named 'vtkmodules'\n"},
            "No module named 'vtkmodules'",
        ),
        ({"status": 3}, "VTK ended with status 3"),
        ({"error": subprocess.TimeoutExpired("probe", 60)}, "no answer within 60 s"),
        ({"error": OSError(12, "Out of memory")}, "Out of memory"),
    ],
)
def test_a_failed_probe_names_the_packages(monkeypatch, given, reason):
    answer(monkeypatch, **given)
    with pytest.raises(DisplayError) as caught:
        check_display()
    assert reason in str(caught.value)
    assert str(caught.value).endswith("apt-get install libegl1 libgl1")
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(sys.platform != "linux", reason="EGL is the off-screen window of Linux")
def test_egl_is_selected_unless_the_user_selected_another_window(monkeypatch):
    calls = answer(monkeypatch)
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    check_display()
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"] == "vtkOSOpenGLRenderWindow"
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW")
    check_display()
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"] == "vtkEGLRenderWindow"
    assert len(calls) == 1  # The probe runs once for each process.
