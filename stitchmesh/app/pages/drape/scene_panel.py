# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The controls of the scene: equilibrium or motion, materials, densities, precision and device."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from stitchmesh.app.controls.controls import Control, Controls
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.compute.device import device_names
from stitchmesh.io.toml_file import read_table
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial
from stitchmesh.mixed.scene.cloth_of_yarns import MATCHED
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import STITCHES
from stitchmesh.mixed.triangles.material_file import material_names

MODES = {"comes to rest": "static", "moves": "dynamic"}
"""What the cloth does, in the words of the page and of the scene."""
FROM_YARNS = "from the yarns"
"""Name of the material of cloth that is computed from the yarns."""
AUTOMATIC = "automatic"
"""Name of the preferred device."""
MOST_SECONDS, MOST_DENSITY = 3600.0, 1000.0
"""Longest motion [s], and most yarns for each cm."""
MOST_DIVISIONS = 20
"""Most loops along each side of a stitch."""


class ScenePanel:
    """The group of the scene; each control changes the scene."""

    def __init__(self, session: DrapeSession, controls: Controls, scene: Scene | None) -> None:
        """Make the controls for a scene; without one, none."""
        self._session, self._controls = session, controls
        self._shown: dict[str, tuple[Control, Callable[[Scene], Any]]] = {}
        if scene is None:
            return
        with controls.group("Scene", opened=False):
            self._choice("The cloth", "An equilibrium, or a motion in time.", tuple(MODES), _mode, _with_mode)
            self._number("Time", "Time of the motion, or of the last keyframe [s].", 1e-4, MOST_SECONDS, 0.05,
                         lambda found: found.duration, lambda found, value: replace(found, duration=value))  # fmt: skip
            self._choice("Yarn", "Material of the yarns.", yarn_materials(scene), _yarn, _with_yarn)
            self._choice("Cloth", "Material of the triangles.", cloth_materials(scene), _cloth, _with_cloth)
            for name, label in densities(scene):
                self._number(label, "Yarns or stitches for each cm.", 0.1, MOST_DENSITY, 0.5, *_density(name))
            if scene.yarns.knit == STITCHES and scene.yarns.model == "crossings":
                self._number("Loops per stitch", "Loops along each side of a stitch of the cloth.", 1, MOST_DIVISIONS,
                             1, lambda found: found.yarns.divisions, _with_divisions)  # fmt: skip
            self._choice("Precision", "float32 is faster on a GPU.", ("float64", "float32"),
                         lambda found: found.solver.precision, _with_precision)  # fmt: skip
            self._choice("Device", "Processor of the run; automatic takes a GPU if there is one.", devices(scene),
                         lambda found: found.solver.device or AUTOMATIC, _with_device)  # fmt: skip

    def refresh(self) -> None:
        """Show the values of the scene."""
        opened = self._session.opened
        if opened is not None:
            for control, value in self._shown.values():
                control.value = value(opened.scene)

    def _choice(
        self, label: str, hint: str, options: tuple[str, ...], value: Callable[[Scene], str],
        change: Callable[[Scene, str], Scene],
    ) -> None:  # fmt: skip
        scene = self._scene()
        made = self._controls.choice(label, hint, options, value(scene), lambda new: self._change(change, new))
        self._shown[label] = made, value

    def _number(
        self, label: str, hint: str, least: float, most: float, step: float, value: Callable[[Scene], float],
        change: Callable[[Scene, float], Scene],
    ) -> None:  # fmt: skip
        made = self._controls.number(
            label, hint, value(self._scene()), lambda new: self._change(change, float(new)), least=least,
            most=most, step=step,
        )  # fmt: skip
        self._shown[label] = made, value

    def _scene(self) -> Scene:
        opened = self._session.opened
        assert opened is not None
        return opened.scene

    def _change(self, change: Callable[[Scene, Any], Scene], value: object) -> None:
        try:
            self._session.change(change(self._scene(), value))
        except Exception:
            self.refresh()  # A change that is refused leaves the controls as they were.
            raise


def yarn_materials(scene: Scene) -> tuple[str, ...]:
    """Return the names of the materials that the yarns of a scene can have."""
    if scene.yarns.material_file is not None:
        return tuple(read_table(scene.yarns.material_file))
    return CrossingMaterial.names()


def cloth_materials(scene: Scene) -> tuple[str, ...]:
    """Return the materials that the cloth of a scene can have; a file of the scene among them."""
    own = scene.cloth.material
    known = (FROM_YARNS, MATCHED, *material_names())
    return known if own is None or own in known else (*known, own)


def densities(scene: Scene) -> tuple[tuple[str, str], ...]:
    """Return the fields and labels of the densities of the yarns; none for yarns that follow stitches."""
    if scene.yarns.weave is not None:
        return ("ends", "Warps per cm"), ("picks", "Wefts per cm")
    return () if scene.yarns.knit == STITCHES else (("wales", "Wales per cm"), ("courses", "Courses per cm"))


def devices(scene: Scene) -> tuple[str, ...]:
    """Return the devices that a scene can have; its own one also where this machine has none of that name."""
    names = [AUTOMATIC, *device_names()]
    own = scene.solver.device
    return tuple(names if own is None or own in names else [*names, own])


def _mode(scene: Scene) -> str:
    return next(words for words, mode in MODES.items() if mode == scene.mode)


def _with_mode(scene: Scene, words: str) -> Scene:
    return replace(scene, mode="dynamic" if MODES[words] == "dynamic" else "static")


def _yarn(scene: Scene) -> str:
    return scene.yarns.material or DEFAULT


def _with_yarn(scene: Scene, name: str) -> Scene:
    return replace(scene, yarns=replace(scene.yarns, material=name))


def _cloth(scene: Scene) -> str:
    return scene.cloth.material or FROM_YARNS


def _with_cloth(scene: Scene, name: str) -> Scene:
    return replace(scene, cloth=replace(scene.cloth, material=None if name == FROM_YARNS else name))


def _with_precision(scene: Scene, name: str) -> Scene:
    return replace(scene, solver=replace(scene.solver, precision="float32" if name == "float32" else "float64"))


def _with_device(scene: Scene, name: str) -> Scene:
    return replace(scene, solver=replace(scene.solver, device=None if name == AUTOMATIC else name))


def _with_divisions(scene: Scene, divisions: float) -> Scene:
    return replace(scene, yarns=replace(scene.yarns, divisions=round(divisions)))


def _density(name: str) -> tuple[Callable[[Scene], float], Callable[[Scene, float], Scene]]:
    """How a density is read from a scene, and how a scene with another one is made."""
    return (
        lambda scene: float(getattr(scene.yarns, name)),
        lambda scene, value: replace(scene, yarns=replace(scene.yarns, **{name: value})),
    )
