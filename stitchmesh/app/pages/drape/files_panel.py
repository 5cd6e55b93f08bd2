# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls that open, save and send files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.pages.downloads import Export, download_list
from stitchmesh.app.pages.drape.drape_session import FILES, DrapeSession
from stitchmesh.app.pages.drape.opened_scene import SUFFIXES
from stitchmesh.app.pages.typed import file_name
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_bytes, write_text
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.outputs import guarded_outputs, plan_outputs
from stitchmesh.io.stitches import write_stitches
from stitchmesh.markup import Markup
from stitchmesh.mixed.drape import REPORT, SCENE_FILE, Draped, output_names
from stitchmesh.mixed.output.files import ANIMATION, MAPS, SURFACE, YARNS
from stitchmesh.mixed.scene.scene import YARN_FORMATS, example_scene, scene_text, write_scene

EXAMPLE, STITCHES = "example.toml", "stitches.h5"
"""Names of files of the page in the project: the example, and the stitches of the garment."""


class FilesPanel:
    """The groups Open, and Save and download."""

    def __init__(self, session: DrapeSession, controls: Controls, result: Callable[[], Draped | None]) -> None:
        """Make the controls; ``result`` returns the result of the last run."""
        self._session, self._result = session, result
        with controls.group("Open", opened=session.opened is None):
            controls.upload("Open a scene or a cloth", "A scene, panels (.toml), a mesh with texture coordinates, or "
                            "stitches.", SUFFIXES, self._receive)  # fmt: skip
            self._path = controls.text("Path", "A scene or a cloth on the computer of StitchMesh.", "")
            controls.button("Open path", "Open it; files that a scene names stand beside it.", self._open_typed)
            controls.button("Take the example", "Open a small scene that comes with the program.", self._take_example)
            if session.app.project.fabric is not None:
                controls.button("Take the stitches of the garment", "Drape the garment of this project.",
                                self._take_stitches)  # fmt: skip

    def build_save(self, controls: Controls) -> None:
        """Make the controls of the group Save and download."""
        with controls.group("Save and download", opened=False) as self._save_group:
            self._folder = controls.text("Folder", "A folder on the computer of StitchMesh.", "")
            controls.button("Save there", "Write the scene, and the result if there is one, into the folder.",
                            self._save)  # fmt: skip
            self._downloads = controls.html(Markup(), self._send)

    def refresh(self) -> None:
        """Show which files there are."""
        self._save_group.visible = self._session.opened is not None
        self._downloads.content = download_list(list(self._files()))

    def _receive(self, name: str, content: bytes) -> None:
        path = self._session.folder / FILES / file_name(name)
        write_bytes(path, content)
        self._session.open_path(path)

    def _open_typed(self) -> None:
        text = str(self._path.value).strip()
        if not text:
            raise ParameterError("path: got nothing; expected a scene, panels, a mesh or stitches")
        self._session.open_path(Path(text).expanduser())

    def _take_example(self) -> None:
        path = self._session.folder / FILES / EXAMPLE
        write_text(path, example_scene())
        self._session.open_path(path)

    def _take_stitches(self) -> None:
        project = self._session.app.project
        fabric = project.evened or project.fabric
        if fabric is None:
            raise ParameterError("stitches: the project holds none; divide a mesh into stitches first")
        path = self._session.folder / FILES / STITCHES
        write_stitches(path, fabric)
        self._session.open_path(path)

    def _save(self) -> None:
        text, opened = str(self._folder.value).strip(), self._session.opened
        if not text or opened is None:
            missing = "a folder" if not text else "a scene; open one first"
            raise ParameterError(f"save: got nothing; expected {missing}")
        folder, result = Path(text).expanduser(), self._result()
        with guarded_outputs():
            plan_outputs([folder / name for name in output_names(opened.scene)], folder=folder)
            if result is not None:
                result.write(folder)
            write_scene(folder / SCENE_FILE, opened.scene)
        self._session.app.notice(f"Saved in {folder}. stitchmesh drape {folder / SCENE_FILE} runs the scene.")

    def _files(self) -> Iterator[Export]:
        opened, folder = self._session.opened, self._session.run_folder
        if opened is not None:
            yield Export("Scene", SCENE_FILE, lambda path: write_text(path, scene_text(opened.scene)))
        if self._result() is None:
            return
        yarns = [(f"{YARNS}.{suffix}", "Yarns") for suffix in YARN_FORMATS]
        others = [(SURFACE, "Surface"), (ANIMATION, "Animation"), (MAPS, "Maps"), (REPORT, "Report")]
        for name, what in [*yarns, *others]:
            if (folder / name).is_file():
                yield Export(what, name, partial(_copy, folder / name))

    def _send(self, action: str, name: str) -> None:
        found = [file for file in self._files() if file.name == name]
        if action != "download" or not found:
            raise ParameterError(f"download {name!r}: is not there any more")
        self._session.app.download(name, found[0].content())


def _copy(source: Path, target: Path) -> None:
    write_bytes(target, read_bytes(source))
