# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The scenes before and after each change, for undo and redo. A scene never changes, so that undo is exact."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.mixed.scene.scene import Scene

MOST_KEPT = 100
"""Largest number of scenes that are kept for undo."""


@dataclass(frozen=True)
class SceneHistory:
    """A scene with those before it and those that were undone."""

    scene: Scene
    """The present scene."""
    before: tuple[Scene, ...] = ()
    """Earlier scenes, the newest last."""
    after: tuple[Scene, ...] = ()
    """Scenes that were undone, the one to come back next last."""

    def changed(self, scene: Scene) -> SceneHistory:
        """Return the history after a change; a change to the same scene is none."""
        if scene == self.scene:
            return self
        return SceneHistory(scene, (*self.before, self.scene)[-MOST_KEPT:])

    def undone(self) -> SceneHistory:
        """Return the history before the last change; without one, the same."""
        if not self.before:
            return self
        return SceneHistory(self.before[-1], self.before[:-1], (*self.after, self.scene))

    def redone(self) -> SceneHistory:
        """Return the history after the change that was undone last; without one, the same."""
        if not self.after:
            return self
        return SceneHistory(self.after[-1], (*self.before, self.scene), self.after[:-1])
