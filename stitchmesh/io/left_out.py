# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One line about the parts of a file that a reader left out: a reader reads everything that it understands."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from os import fspath

from stitchmesh.io.path_kind import FilePath

logger = logging.getLogger(__name__)

MOST_NAMES = 8
"""Number of names that a line lists."""


def say_left_out(path: FilePath, counts: Mapping[str, int], what: str) -> None:
    """Log a warning about what was left out of a file, if anything was.

    Args:
        path: the file.
        counts: number of the things that were left out, by their name in the file.
        what: word for the things, in the plural, such as ``lines``.
    """
    if not counts:
        return
    names = [f"{name[:20]} ({count})" for name, count in list(counts.items())[:MOST_NAMES]]
    more = f" and {len(counts) - MOST_NAMES} more" if len(counts) > MOST_NAMES else ""
    listed = ", ".join(names) + more
    logger.warning("%s: left out %s, which the surface does not need: %s", fspath(path), what, listed)
