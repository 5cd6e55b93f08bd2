# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether this machine can draw off screen.

Where the GL libraries are missing VTK dies by a segmentation fault, which no exception handler sees, so a tiny window
is drawn in a process of its own first.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys

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
"""A probe that takes longer than this will not draw a picture either; it takes half a second where all is well."""


def check_display() -> None:
    """Return where pictures can be drawn; the probe runs once in a process.

    On Linux this also selects VTK's EGL window, which needs no display server, unless the user selected another.

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
    """Why the probe failed, empty where it did not."""
    try:
        probe = subprocess.run(
            [sys.executable, "-c", PROBE], capture_output=True, text=True, timeout=SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return f"the probe gave no answer within {SECONDS} s"
    except OSError as error:
        return f"the probe did not start: {error.strerror}"
    if probe.returncode < 0:
        return f"VTK died of signal {-probe.returncode}"
    if probe.returncode > 0:
        said = probe.stderr.strip().splitlines()
        return said[-1][:120] if said else f"VTK ended with status {probe.returncode}"
    return ""
