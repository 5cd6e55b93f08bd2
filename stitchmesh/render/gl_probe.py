# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Check whether this machine can draw off screen.

If the GL libraries are missing, VTK ends with a segmentation fault, which no exception handler can catch. The check
therefore draws a small window in a separate process first.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys

from stitchmesh.child_interpreter import clean_environment, python_command
from stitchmesh.errors import DisplayError

PACKAGES = "libegl1 libgl1"
"""Debian packages that VTK needs to draw off screen."""

PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.AddRenderer(vtkRenderer())
window.Render()
"""
SECONDS = 60
"""Time limit of the probe [s]; a successful probe takes half a second."""


def check_display() -> None:
    """Check that pictures can be drawn; the probe runs once per process.

    On Linux this function also selects VTK's EGL window, which needs no display server, unless the user has selected
    another window.

    Raises:
        DisplayError: pictures cannot be drawn; the message names the packages to install.
    """
    if sys.platform == "linux":
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    reason = _failure()
    if reason:
        raise DisplayError(
            f"pictures cannot be drawn here ({reason}); install the GL libraries: apt-get install {PACKAGES}"
        )


@functools.cache
def _failure() -> str:
    """Return the reason why the probe failed; an empty string if it succeeded."""
    try:
        probe = subprocess.run(
            python_command("-c", PROBE), env=clean_environment(),
            capture_output=True, text=True, timeout=SECONDS, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"the probe gave no answer within {SECONDS} s"
    except OSError as error:
        return f"the probe did not start: {error.strerror}"
    if probe.returncode < 0:
        return f"VTK was ended by signal {-probe.returncode}"
    if probe.returncode > 0:
        errors = probe.stderr.strip().splitlines()
        return errors[-1][:120] if errors else f"VTK ended with status {probe.returncode}"
    return ""
