# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of the selection: by words, all, none, the others, and selections that the user has saved under names.

The settings of the project hold the saved selections. A selection in words, such as ``hem 6``, is evaluated at each
use. A selection of single faces follows the faces when an edit renumbers them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import SMALL_BUTTON, action_button, paragraph
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.renumbering import REMOVED
from stitchmesh.selection import parse_selection, select
from stitchmesh.selection.selection import Faces, selection_of_faces

if TYPE_CHECKING:
    from stitchmesh.app.application import App
    from stitchmesh.app.pages.edit.edit_session import EditSession



class SelectionPanel:
    """The group of the selection."""

    def __init__(self, session: EditSession, controls: Controls) -> None:
        """Make the controls."""
        self._session = session
        with controls.group("Selection"):
            self._count = controls.html(Markup())
            hint = "Such as hem 6, rows 10-20, front and stitch p, wale 120; see the documentation of selections"
            self._text = controls.text("Select by words", hint, "")
            controls.button("Select these", "Select the stitches that the words name", self._by_words)
            controls.buttons("Choose", "All stitches, none, or all that are not selected", ("All", "None", "Others"),
                             self._simple)  # fmt: skip
            self._name = controls.text("Name", "Name under which the selection is saved", "")
            controls.button("Save the selection", "Keep the selection under the name", self._save)
            self._list = controls.html(session.saved.html(), self._act)
        self.show()

    def show(self) -> None:
        """Show how many stitches are selected, and the saved selections."""
        count = len(self._session.state.selection.faces)
        verb = "stitch is" if count == 1 else "stitches are"
        selected = markup("<b>{}</b> {} selected.", count, verb) if count else "Nothing is selected."
        self._count.content = paragraph(selected)
        self._list.content = self._session.saved.html()

    def _by_words(self) -> None:
        self._session.choose_by_text(str(self._text.value).strip())
        self.show()

    def _simple(self, which: str) -> None:
        every = np.arange(self._session.fabric.face_count)
        if which == "All":
            self._session.choose(every, "all")
        elif which == "None":
            self._session.choose(every[:0])
        else:
            self._session.choose(np.setdiff1d(every, self._session.state.selection.faces))
        self.show()

    def _save(self) -> None:
        self._session.saved.save(str(self._name.value), self._session.state.selection.as_text)
        self.show()

    def _act(self, action: str, name: str) -> None:
        if action == "use":
            self._session.choose_by_text(self._session.saved.text_of(name))
        else:
            self._session.saved.delete(name)
        self.show()


PAGE, KEY = "Edit", "selections"
"""The place of the selections in the project."""
LONGEST_NAME = 40
"""Largest number of characters of a name."""
LONGEST_SHOWN = 44
"""Number of characters of a selection that the list shows."""


class SavedSelections:
    """Saved selections by name."""

    def __init__(self, app: App) -> None:
        """Keep the application, whose project holds the selections."""
        self._app = app

    @property
    def texts(self) -> dict[str, str]:
        """The text of each selection, by its name."""
        found = self._app.project.settings(PAGE).get(KEY, {})
        return {str(name): str(text) for name, text in found.items()} if isinstance(found, dict) else {}

    def save(self, name: str, text: str) -> None:
        """Save a selection; a selection of the same name is replaced.

        Raises:
            ParameterError: the name or the selection is empty, or the name is too long.
        """
        name = name.strip()
        if not name or len(name) > LONGEST_NAME or not name.isprintable():
            raise ParameterError(f"name: got {name[:LONGEST_NAME]!r}; expected 1 to {LONGEST_NAME} characters")
        if not text:
            raise ParameterError(f"selection {name!r}: nothing is selected; select stitches first")
        self._write({**self.texts, name: text})

    def delete(self, name: str) -> None:
        """Delete a selection; an unknown name is no error, because another browser may have deleted the selection."""
        self._write({known: text for known, text in self.texts.items() if known != name})

    def text_of(self, name: str) -> str:
        """Return the text of a selection.

        Raises:
            ParameterError: no selection has this name.
        """
        if name not in self.texts:
            raise ParameterError(f"selection {name!r}: is not saved; save it first")
        return self.texts[name]

    def follow(self, before: StitchMesh, numbers: IntArray) -> None:
        """Let the selections of single faces follow an edit.

        Args:
            before: the fabric before the edit.
            numbers: number of each face after the edit, ``REMOVED`` for faces that are gone, shape (F,).
        """
        if np.array_equal(numbers, np.arange(before.face_count)):
            return
        texts = {name: _followed(text, before, numbers) for name, text in self.texts.items()}
        kept = {name: text for name, text in texts.items() if text}
        if kept != self.texts:
            self._write(kept)

    def html(self) -> Markup:
        """Return the list as HTML; the actions are ``use`` and ``delete`` with the name."""
        rows = joined(_row(name, text) for name, text in self.texts.items())
        frame = '<ul style="list-style:none;margin:0;padding:0;font-size:.82em">{}</ul>'
        return markup(frame, rows) if rows else Markup()

    def _write(self, texts: dict[str, str]) -> None:
        project = self._app.project
        project.set_settings(PAGE, {**project.settings(PAGE), KEY: texts})


def faces_after(faces: IntArray, numbers: IntArray) -> IntArray:
    """Return the numbers of faces after an edit, ascending, without the faces that are gone."""
    after = numbers[faces]
    return np.sort(after[after != REMOVED])


def _followed(text: str, before: StitchMesh, numbers: IntArray) -> str:
    """Return the text of a selection after an edit; empty if its faces are gone."""
    if not isinstance(parse_selection(text), Faces):
        return text
    faces = select(before, text)
    after = faces_after(faces, numbers)
    return str(selection_of_faces(after)) if len(after) else ""


def _row(name: str, text: str) -> Markup:
    shown = text if len(text) <= LONGEST_SHOWN else f"{text[: LONGEST_SHOWN - 3]}..."
    buttons = joined(
        action_button(action, name, words, name=f"{words} {name}", style=SMALL_BUTTON)
        for action, words in (("use", "Use"), ("delete", "Delete"))
    )
    words = markup('<span style="flex:1 1 auto;overflow-wrap:anywhere"><b>{}</b><br>{}</span>', name, shown)
    return markup('<li style="display:flex;gap:4px;align-items:center;margin:.2em 0">{}{}</li>', words, buttons)
