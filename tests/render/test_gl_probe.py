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
    ("status", "stderr", "reason"),
    [
        (-11, "", "VTK was ended by signal 11"),
        (1, "Traceback\nModuleNotFoundError: No module named 'vtkmodules'\n", "No module named 'vtkmodules'"),
        (3, "", "VTK ended with status 3"),
    ],
)
def test_a_failed_probe_names_the_packages(monkeypatch, status, stderr, reason):
    answer(monkeypatch, status=status, stderr=stderr)
    with pytest.raises(DisplayError) as caught:
        check_display()
    assert reason in str(caught.value)
    assert str(caught.value).endswith("apt-get install libegl1 libgl1")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (subprocess.TimeoutExpired("probe", 60), "no answer within 60 s"),
        (OSError(12, "Out of memory"), "Out of memory"),
    ],
)
def test_a_probe_that_does_not_answer_is_a_failure(monkeypatch, error, reason):
    answer(monkeypatch, error=error)
    with pytest.raises(DisplayError, match=reason):
        check_display()


def test_the_probe_runs_once(monkeypatch):
    calls = answer(monkeypatch)
    check_display()
    check_display()
    assert len(calls) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="EGL is the off-screen window of Linux")
def test_egl_is_selected_unless_the_user_selected_another_window(monkeypatch):
    answer(monkeypatch)
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    check_display()
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"] == "vtkOSOpenGLRenderWindow"
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW")
    check_display()
    assert os.environ["VTK_DEFAULT_OPENGL_WINDOW"] == "vtkEGLRenderWindow"


def test_rendering_loads_no_graphics_until_it_draws():
    loaded = "{'pyvista', 'vtkmodules', 'h5py', 'meshio'} & set(sys.modules)"
    code = f"import sys, stitchmesh.render; sys.exit(bool({loaded}))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
