# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of the selection: by words, all, none, the others, and saved selections."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import paragraph
from stitchmesh.app.pages.edit.edit_session import NO_FACES, EditSession
from stitchmesh.markup import Markup, markup

WORDS_HINT = "Such as hem 6, rows 10-20, front and stitch p, wale 120; see the documentation of selections"


class SelectionPanel:
    """The group of the selection."""

    def __init__(self, session: EditSession, controls: Controls) -> None:
        """Make the controls."""
        self._session = session
        with controls.group("Selection"):
            self._count = controls.html(Markup())
            self._text = controls.text("Select by words", WORDS_HINT, "")
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
            self._session.choose(NO_FACES)
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
