# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``edit``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.options import READ_STITCHES, WRITTEN_STITCHES, OnSelection, Overwrite, Serving
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError

if TYPE_CHECKING:
    from stitchmesh.editing.edit import Edit
    from stitchmesh.mesh import StitchMesh


@dataclass(frozen=True)
class EditCommand:
    """Apply edits to a stitch mesh; without edits, open it in the browser."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    arguments: Annotated[Positional[tuple[str, ...]], help_entry("NAME=VALUE", "none")] = ()
    """arguments of the edit (docs/editing.md); a value is a number, a text, or a list such as [1,2]"""
    apply: Annotated[str | None, help_entry("EDIT", "none")] = None
    """edit to apply"""
    on: OnSelection = None
    log: Annotated[str | None, help_entry("LOG", "not written")] = None
    """file to which the edit is written as a log, for --replay"""
    replay: Annotated[str | None, help_entry("LOG", "none")] = None
    """file of edits, one JSON object in each line (docs/editing.md)"""
    output: Annotated[str | None, help_entry("FILE", "none", short="-o", help=WRITTEN_STITCHES)] = None
    serving: Annotated[Serving, arg(name="")] = field(default_factory=Serving)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Apply the edits, and write the result; if one edit is not possible, nothing is written.

        If neither edits nor an output are given, the application opens at the page Edit.
        """
        from stitchmesh.editing.history import write_log
        from stitchmesh.io import read_stitches, write_stitches
        from stitchmesh.io.outputs import plan_outputs

        if self == replace(EditCommand(self.fabric), serving=self.serving):
            self._open_in_browser()
            return
        if self.output is None or (self.apply is None) == (self.replay is None):
            raise ParameterError("edit: needs one edit or one log, and -o FILE; give --apply EDIT or --replay LOG")
        plan_outputs(Path(path) for path in (self.output, self.log) if path is not None)
        before = read_stitches(self.fabric)
        after = self._edited(before)
        write_stitches(self.output, after)
        if self.log is not None:
            write_log(self.log, [self._edit()])
        say(f"{before.face_count} stitches before, {after.face_count} after")

    def _open_in_browser(self) -> None:
        from stitchmesh.app.project.opening import project_for
        from stitchmesh.app.starts import EDIT

        self.serving.run(partial(project_for, self.fabric), EDIT)

    def _edited(self, before: StitchMesh) -> StitchMesh:
        """Return the stitch mesh after the edit or the log."""
        from stitchmesh.editing.edit import apply_edit
        from stitchmesh.editing.history import replay_edits

        if self.replay is None:
            return apply_edit(before, self._edit()).fabric
        if self.arguments or self.on is not None or self.log is not None:
            raise ParameterError("edit: a log holds whole edits; leave --on, --log and NAME=VALUE out")
        return replay_edits(before, self.replay)

    def _edit(self) -> Edit:
        """Return the edit that the options describe.

        Raises:
            ParameterError: an argument does not have the form NAME=VALUE, or is given twice.
        """
        from stitchmesh.editing.edit import Edit
        from stitchmesh.editing.on_selection import ON

        values: dict[str, object] = {} if self.on is None else {ON: self.on}
        for word in self.arguments:
            name, equals, text = word.partition("=")
            if not equals or name in values:
                raise ParameterError(f"edit: got {word!r}; expected NAME=VALUE, each name once")
            values[name] = _value(text)
        return Edit(self.apply or "", values)


def _value(text: str) -> object:
    """Return a value that JSON can read, such as a number or a list, and any other text as it is."""
    from stitchmesh.io.checked import parse_json

    try:
        return parse_json(text)
    except ParameterError:
        return text
