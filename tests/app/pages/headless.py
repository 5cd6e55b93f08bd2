# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application without a browser, on a small garment: pages are pressed, clicked and read in the test itself.

Pages with long work are called in the thread of the events: ``call``, ``press``, ``wait_for_task``.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.app.application import App
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.scene import Modifier, Pick
from stitchmesh.errors import StitchMeshError
from stitchmesh.io.meshes import write_mesh
from stitchmesh.mesh import Mesh
from tests.app.null_front import NullControls, NullFront, NullScene

SAFETY = 120.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


class Headless:
    """The application with a front that remembers."""

    def __init__(self, app: App, front: NullFront) -> None:
        """Keep the application."""
        self.app, self.front = app, front

    @property
    def controls(self) -> NullControls:
        """The controls of the open page."""
        return self.front.controls

    @property
    def scene(self) -> NullScene:
        """The scene."""
        return self.front.scene

    @property
    def project(self) -> Project:
        """The project."""
        return self.app.project

    def click(self, point: ArrayLike, towards: ArrayLike = (0.0, 0.0, -1.0), modifier: Modifier = "") -> None:
        """Click at a point, seen from 100 cm away in a direction; an error becomes a notice, as in the browser."""
        direction = np.asarray(towards, dtype=np.float64)
        try:
            assert self.front.listener is not None
            self.front.listener.picked(Pick(np.asarray(point) - 100.0 * direction, direction, modifier))
        except StitchMeshError as error:
            self.app.report(error)

    def click_face(self, face: int, modifier: Modifier = "") -> None:
        """Click at the middle of a face of the mesh, from outside."""
        mesh = self.project.mesh
        assert mesh is not None
        normal = mesh.face_vector_area[face] / np.linalg.norm(mesh.face_vector_area[face])
        self.click(face_middle(mesh, face), -normal, modifier)

    def click_side(self, side: int, share: float = 0.85, modifier: Modifier = "") -> None:
        """Click at a face near the middle of one of its sides: share 1 is on the side, 0 in the middle of the face."""
        mesh = self.project.mesh
        assert mesh is not None
        face = int(mesh.side_face[side])
        normal = mesh.face_vector_area[face] / np.linalg.norm(mesh.face_vector_area[face])
        middle = (mesh.corner_position[side] + mesh.corner_position[mesh.side_next[side]]) / 2
        self.click(share * middle + (1.0 - share) * face_middle(mesh, face), -normal, modifier)

    def notices(self) -> str:
        """All notices, one in each line."""
        return "\n".join(text for _, text, _ in self.front.notices)


def face_middle(mesh: Mesh, face: int) -> np.ndarray:
    """The mean of the corners of a face [cm], shape (3,)."""
    return mesh.corner_position[mesh.face_start[face] : mesh.face_start[face + 1]].mean(axis=0)


@contextmanager
def headless(folder: Path, mesh: Mesh | None, page: str) -> Iterator[Headless]:
    """Run the application without a browser on a mesh, with a page open."""
    project = Project.create(folder / "project")
    if mesh is not None:
        write_mesh(folder / "garment.obj", mesh)
        project.import_mesh("garment.obj", (folder / "garment.obj").read_bytes())
    with on_project(project, page) as opened:
        yield opened


@contextmanager
def on_project(project: Project, page: str) -> Iterator[Headless]:
    """Run the application without a browser on a project, with a page open."""
    front = NullFront()
    app = App(project, front)
    app.open_page(page)
    try:
        yield Headless(app, front)
    finally:
        app.close()


def call(shown: Headless, function: Callable[..., Any], *arguments: Any) -> None:
    """Call a function in the thread of the events, and wait for its end; an error becomes a notice."""
    shown.app.post(function, *arguments)
    shown.app.queue.settle(SAFETY)


def press(shown: Headless, label: str) -> None:
    """Press a button."""
    call(shown, shown.controls.press, label)


def wait_for_task(shown: Headless) -> None:
    """Wait until no task runs and its result has arrived."""
    for _ in range(int(SAFETY / 0.01)):
        if not shown.app.tasks.running:
            break
        threading.Event().wait(0.01)
    assert not shown.app.tasks.running
    shown.app.queue.settle(SAFETY)
