# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``animate``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional

from stitchmesh.cli.options import FOUND_RADIUS, READ_STITCHES, READ_YARNS, Device, Overwrite, QualityName, Threads
from stitchmesh.cli.output_folder import output_folder
from stitchmesh.cli.summary import AsJson, material_lines, print_result
from stitchmesh.cli.words import DirectionWord, Flag, help_entry
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh.upright import Y
from stitchmesh.mesh.vertex_motion import FRAMES_PER_SECOND
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import MaterialSection
from stitchmesh.render.animation_options import AnimationPictures
from stitchmesh.yarnrelax.motion.animation_options import AnimationOptions

if TYPE_CHECKING:
    from stitchmesh.mesh import StitchMesh
    from stitchmesh.yarn import YarnSet

CHECKPOINT_EVERY = 10
"""Frames from one checkpoint to the next."""


@dataclass(frozen=True)
class AnimateCommand:
    """Carry yarns with a cloth that moves; no yarn passes through another one."""

    fabric: Annotated[Positional[str], help_entry("STITCHES", help=READ_STITCHES)]
    cloth: Annotated[Positional[str], help_entry("CLOTH")]
    """animation of the surface of the stitches: a folder with a mesh for each frame, such as skirt.0001.obj, or a USD,
    glTF (.glb) or Alembic file of one mesh; its first frame is where the stitches are"""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for the frames, an animation (USD), pictures, a report and a checkpoint"""
    yarns: Annotated[str | None, help_entry("YARNS", "generated and relaxed", help=f"{READ_YARNS}, at rest")] = None
    resume: Flag = False
    """continue from the checkpoint in the output folder, if there is one; give the same other options as before"""
    frames_per_second: Annotated[float, help_entry("N")] = FRAMES_PER_SECOND
    """frames for each second of a folder or of a glTF animation; USD and Alembic state their times"""
    cloth_unit: Annotated[str, help_entry("UNIT")] = DEFAULT_UNIT
    """unit of the files of a folder, or of Alembic"""
    cloth_up: Annotated[DirectionWord, help_entry("AXIS|X,Y,Z", "y")] = None
    """direction that points up in the files of a folder, or in Alembic"""
    yarn_radius: Annotated[float | None, help_entry("CM", FOUND_RADIUS)] = None
    """radius of the given yarns [cm]"""
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    threads: Threads = None
    options: AnimationOptions = field(default_factory=AnimationOptions)
    material: MaterialSection = field(default_factory=MaterialSection)
    pictures: AnimationPictures = field(default_factory=AnimationPictures)
    json: AsJson = False
    overwrite: Overwrite = False

    def run(self) -> None:
        """Make the frames, write them, and print a summary."""
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.compute.device import device_named
        from stitchmesh.io import read_stitches
        from stitchmesh.io.mesh_sequences import read_moving_mesh
        from stitchmesh.pipeline.animate import animate
        from stitchmesh.render.animation_pictures import draw_animation, picture_names
        from stitchmesh.run import Checkpoints, Run
        from stitchmesh.yarnrelax.animate_yarns import refuse_wrong_cloth
        from stitchmesh.yarnrelax.follow_files import ANIMATION, REPORT, FollowFiles
        from stitchmesh.yarnrelax.model.material import material_of

        names = ANIMATION, REPORT, *picture_names(self.pictures)
        fabric = read_stitches(self.fabric)
        cloth = read_moving_mesh(
            self.cloth, unit=self.cloth_unit, up=self.cloth_up or Y, frames_per_second=self.frames_per_second
        )  # fmt: skip
        refuse_wrong_cloth(fabric, cloth, device_named(self.device))  # before the work
        yarns = self._yarns(fabric)
        material = material_of(yarns, self.material.name, self.material.values())
        with output_folder(self.output, names) as folder, show_progress() as progress:
            kept = Checkpoints(folder, every=CHECKPOINT_EVERY)
            frames = animate(
                fabric, cloth, yarns, material=material, quality=self.quality, device=self.device,
                options=self.options,
                run=Run(progress, checkpoints=kept, resume=kept.path if self.resume else None),
            )  # fmt: skip
            files = FollowFiles(folder, yarns, cloth, frame_format=self.pictures.frame_format)
            for frame in frames:
                files.add(frame)
            report = files.finish()
            draw_animation(files.frames(), cloth, folder, self.pictures, progress=progress)
        lines = summary_lines(report["frames"]) + material_lines(yarns.made_of if self.material.name is None else None)
        lines.append(f"Wrote {folder / ANIMATION}; {folder / 'frames'} holds a file for each frame.")
        print_result(report, lines, as_json=self.json)

    def _yarns(self, fabric: StitchMesh) -> YarnSet:
        """Return the given yarns, or those that are generated from the fabric and relaxed."""
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.io import read_yarns
        from stitchmesh.run import Run
        from stitchmesh.yarngen import generate_yarns
        from stitchmesh.yarnrelax import relax_yarns
        from stitchmesh.yarnrelax.model.material import material_of

        if self.yarns is not None:
            return read_yarns(self.yarns, radius=self.yarn_radius)
        drawn = generate_yarns(fabric, yarn_radius=self.yarn_radius, quality=self.quality, device=self.device)
        material = material_of(drawn, self.material.name, self.material.values())
        with show_progress() as progress:
            return relax_yarns(
                drawn, material=material, quality=self.quality, device=self.device, keep_shape=fabric,
                run=Run(progress),
            ).yarns  # fmt: skip


def summary_lines(frames: list[dict[str, Any]]) -> list[str]:
    """Return what an animation came to, from the reports of its frames: a line for each frame that was missed too."""
    seconds = sum(frame["seconds"] for frame in frames)
    nearest = min(frame["min_distance_over_radius"] for frame in frames)
    certified = sum(frame["certified"] for frame in frames)
    missed = [frame for frame in frames if frame["missed"] is not None]
    return [
        f"Made {len(frames)} frames in {seconds:.3g} s; {len(missed)} of them were missed.",
        *(f"Frame {each['frame']} was missed ({each['passed']:.0%} of the way): {each['missed']}." for each in missed),
        f"No yarn passed through another one; the linking of all yarns is the same in {certified} frames.",
        f"Smallest distance of two yarns over their radius: {nearest:.2f}.",
    ]
