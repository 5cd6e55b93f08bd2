# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Matplotlib with its own settings, so that plots do not depend on files of settings in a folder or a home.

Matplotlib reads the file ``matplotlibrc`` of the present folder when it is imported, and PyVista imports it. Such a
file may ask for LaTeX, for example.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

SETTINGS_FILE = "matplotlibrc"


def import_matplotlib() -> None:
    """Import matplotlib as if the folder had no file of settings."""
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
    """Give matplotlib its default settings during a block or a function."""
    import_matplotlib()
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        yield
