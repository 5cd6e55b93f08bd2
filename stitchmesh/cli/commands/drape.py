# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``drape``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from stitchmesh.cli.options import Device, Overwrite, Serving, Threads
from stitchmesh.cli.output_folder import draw_if_possible, output_folder
from stitchmesh.cli.say import say
from stitchmesh.cli.summary import AsJson, files_to_open, print_result
from stitchmesh.cli.words import Flag, help_entry
from stitchmesh.errors import FileError, ParameterError

if TYPE_CHECKING:
    from stitchmesh.mixed.drape import Draped
    from stitchmesh.mixed.scene.scene import Scene
    from stitchmesh.progress import Progress

COMPARED: dict[str, Literal["none", "chosen", "all"]] = {"triangles": "none", "mixed": "chosen", "yarns": "all"}
"""Folders of the runs that ``--compare`` makes, and where each of them has yarns."""
NOT_CONVERGED = 1
"""Exit status after a run that did not converge."""


@dataclass(frozen=True)
class DrapeCommand:
    """Simulate a cloth with yarns where they are needed, and triangles elsewhere."""

    scene: Annotated[Positional[str], help_entry("SCENE")]
    """scene file (.toml)"""
    output: Annotated[str | None, help_entry("DIR", "none", short="-o")] = None
    """output folder for yarns, surface, animation, maps, a picture and a report"""
    init: Flag = False
    """write an example scene to SCENE, with comments, and do nothing else"""
    region: Annotated[
        Literal["none", "chosen", "all"] | None,
        help_entry("none|chosen|all", "that of the scene", help="where yarns are simulated"),
    ] = None
    mode: Annotated[
        Literal["static", "dynamic"] | None,
        help_entry("static|dynamic", "that of the scene", help="equilibrium, or motion in time"),
    ] = None
    duration: Annotated[float | None, help_entry("S", "that of the scene")] = None
    """time of the motion [s]"""
    compare: Flag = False
    """run the scene with triangles alone, as it is, and with yarns alone, and draw all three side by side"""
    checkpoint_every: Annotated[int | None, help_entry("N", "no checkpoints")] = None
    """write a checkpoint into the output folder every N steps of a motion, or iterations of a static scene"""
    resume: Flag = False
    """continue from the checkpoint in the output folder, if there is one; the result has the same bits"""
    device: Device = None
    threads: Threads = None
    no_picture: Flag = False
    """do not write preview.png"""
    json: AsJson = False
    view: Flag = False
    """open the scene, or a cloth as a new one, in the browser; nothing is written"""
    serving: Annotated[Serving, arg(name="")] = field(default_factory=Serving)
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Run the scene, write its files, and print a summary; or open the application at its page.

        Returns:
            The exit status if the run did not converge, otherwise None.

        Raises:
            ParameterError: there is no output folder.
        """
        if self.init:
            _write_example(Path(self.scene))
            return None
        if self.view:
            from stitchmesh.app.starts import DRAPE, drape_project

            self.serving.run(partial(drape_project, Path(self.scene)), DRAPE)
            return None
        if self.output is None:
            message = "drape: needs -o DIR for its files, --view for the browser, or --init for an example scene"
            raise ParameterError(message)
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.io.atomic import write_json

        scene = self._scene()
        with output_folder(self.output, self._outputs(scene)) as folder, show_progress() as progress:
            runs = self._runs(scene, folder, progress)
            draws = not self.no_picture and (scene.output.picture or self.compare)
            drawn = draws and draw_if_possible(lambda: _draw(runs, folder / "preview.png"))
            report = runs["mixed"].report
            if self.compare:
                report = {name: run.report["mixed"] for name, run in runs.items()}
                write_json(folder / "report.json", report)
        lines = [line for name, run in runs.items() for line in _summary(name if self.compare else "", run)]
        print_result(report, [*lines, files_to_open(folder, bool(drawn))], as_json=self.json)
        return None if all(run.report["mixed"]["converged"] for run in runs.values()) else NOT_CONVERGED

    def _scene(self) -> Scene:
        """Return the scene with the changes of the options."""
        from stitchmesh.mixed.scene.scene import read_scene

        scene = read_scene(self.scene)
        if self.region is not None:
            scene = replace(scene, region=replace(scene.region, yarns=self.region))
        if self.device is not None:
            scene = replace(scene, solver=replace(scene.solver, device=self.device))
        changes: dict[str, Any] = {"mode": self.mode, "duration": self.duration}
        return replace(scene, **{name: value for name, value in changes.items() if value is not None})

    def _outputs(self, scene: Scene) -> list[str]:
        """Return the names of the files that the scene writes; each form has a folder of its own in a comparison."""
        from stitchmesh.mixed.drape import output_names

        names, above = output_names(scene), ["preview.png"]
        return above + ([f"{form}/{name}" for form in COMPARED for name in names] if self.compare else names)

    def _runs(self, scene: Scene, folder: Path, progress: Progress) -> dict[str, Draped]:
        """Run the scene, or its three forms, and write the files of each."""
        if not self.compare:
            return {"mixed": self._one(scene, folder, progress)}
        forms = {name: replace(scene, region=replace(scene.region, yarns=kind)) for name, kind in COMPARED.items()}
        if scene.region.yarns == "automatic":
            forms["mixed"] = scene
        return {name: self._one(form, folder / name, progress) for name, form in forms.items()}

    def _one(self, scene: Scene, folder: Path, progress: Progress) -> Draped:
        from stitchmesh.mixed.drape import drape
        from stitchmesh.run import CHECKPOINT, Checkpoints, Run

        every = self.checkpoint_every
        run: Run[Draped] = Run(
            progress,
            checkpoints=None if every is None else Checkpoints(folder, every),
            resume=folder / CHECKPOINT if self.resume else None,
        )
        made = drape(scene, folder, run=run)
        made.write(folder)
        return made


def _write_example(path: Path) -> None:
    """Write the example scene, unless the file is there already."""
    from stitchmesh.io.atomic import write_text
    from stitchmesh.io.path_kind import is_there
    from stitchmesh.mixed.scene.scene import example_scene

    if path.suffix.lower() != ".toml":
        raise FileError(f"{path}: got the suffix {path.suffix!r}; expected .toml")
    if is_there(path):
        raise FileError(f"{path}: is there already; choose another name")
    write_text(path, example_scene())
    say(f"Wrote {path}; stitchmesh drape {path} -o DIR runs it.")


def _draw(runs: dict[str, Draped], path: Path) -> None:
    from stitchmesh.render.draped.picture import render_draped

    names = list(runs) if len(runs) > 1 else [""]
    render_draped(list(zip(names, runs.values(), strict=True)), path)


def _summary(name: str, run: Draped) -> list[str]:
    """The lines about one run."""
    mixed = run.report["mixed"]
    nodes = f"{mixed['yarn_nodes_full']:,} + {mixed['yarn_nodes_hybrid']:,} of {mixed['yarn_nodes']:,} yarn nodes"
    vertices = f"{mixed['vertices_triangle_only']:,} + {mixed['vertices_hybrid']:,} vertices"
    work = f"{mixed['steps']} steps, {mixed['newton_iterations']} Newton iterations, {mixed['seconds']:.1f} s"
    state = "converged" if mixed["converged"] else f"did not converge (error {mixed['error']:.2g})"
    prefix = f"{name}: " if name else ""
    return [f"{prefix}{nodes} (full + hybrid), {vertices} (triangles + hybrid).", f"{prefix}{work}; {state}."]
