# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options of measures, which are the parameters of their functions, and the types that several of them share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import tyro
from tyro.conf import arg

from benchmarks.table import Rows
from stitchmesh.cli.arguments import CONFIG

Output = Annotated[Path, arg(aliases=["-o"])]
"""A file or a folder that the measure writes."""
OptionalOutput = Annotated[Path | None, arg(aliases=["-o"])]
"""The same, for a measure that may write none."""


def begun(actions: Sequence[Callable[..., Rows]], program: str, words: Sequence[str], description: str) -> Rows:
    """Return a measure with the options of a command line; it begins with the first row that is taken.

    Args:
        actions: its function, or several functions, of which the first word names one.
        program: how the measure is started.
        words: the words after that.
        description: text of the help.

    Raises:
        SystemExit: the help was printed, or the words are no options of the measure.
    """
    if len(actions) == 1:
        return tyro.cli(actions[0], prog=program, description=description, args=words, config=CONFIG)
    named = {action.__name__: action for action in actions}
    made: Rows = tyro.extras.subcommand_cli_from_dict(
        named, prog=program, description=description, args=words, config=CONFIG
    )
    return made
