# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Matplotlib with its own settings: plots are the same whatever files of settings lie in a folder or a home.

Matplotlib reads a file ``matplotlibrc`` of the present folder when it is imported, which PyVista does too. Such a file
may ask for LaTeX, for example.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

SETTINGS_FILE = "matplotlibrc"


def import_matplotlib() -> None:
    """Import matplotlib as in a folder without a file of settings."""
    if "matplotlib" in sys.modules or not os.path.lexists(SETTINGS_FILE):
        return
    present = os.open(os.curdir, os.O_RDONLY)
    try:
        os.chdir(os.sep)
        import matplotlib  # noqa: F401
    finally:
        os.chdir(present)
        os.close(present)


@contextmanager
def own_settings() -> Iterator[None]:
    """Give matplotlib the settings that it comes with, for the time of a block or of a function."""
    import_matplotlib()
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        yield
