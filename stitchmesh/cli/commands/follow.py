# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``follow``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import (
    FOUND_RADIUS,
    READ_STITCHES,
    READ_YARNS,
    Device,
    Overwrite,
    Threads,
    Unit,
)
from stitchmesh.cli.output_folder import output_folder
from stitchmesh.cli.summary import AsJson, material_lines, print_result
from stitchmesh.cli.words import DirectionWord, Flag, help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh.upright import Y
from stitchmesh.mesh.vertex_motion import FRAMES_PER_SECOND
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS
from stitchmesh.recipe.sections import MaterialSection
from stitchmesh.render.animation_options import AnimationPictures
from stitchmesh.yarnrelax.motion.follow_defaults import BODY_FRICTION, DRAG

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.constraints.pins import Pins


@dataclass(frozen=True)
class FollowCommand:
    """Simulate yarns in time that follow a moving body."""

    yarns: Annotated[Positional[str], help_entry("YARNS", help=f"{READ_YARNS}, at the first frame of the body")]
    body: Annotated[Positional[str], help_entry("BODY")]
    """folder with a mesh for each frame, such as walk.0001.obj, or a USD, glTF (.glb) or Alembic file of one mesh that
    moves"""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for the frames, an animation (USD), pictures, a report and a checkpoint"""
    resume: Flag = False
    """continue from the checkpoint in the output folder, if there is one; give the same other options as before"""
    frames_per_second: Annotated[float, help_entry("N")] = FRAMES_PER_SECOND
    """frames for each second of a folder or of a glTF animation; USD and Alembic state their times"""
    body_unit: Annotated[str, help_entry("UNIT")] = DEFAULT_UNIT
    """unit of the files of a folder, or of Alembic"""
    body_up: Annotated[DirectionWord, help_entry("AXIS|X,Y,Z", "y")] = None
    """direction that points up in the files of a folder, or in Alembic"""
    body_friction: Annotated[float, help_entry("MU")] = BODY_FRICTION
    """coefficient of friction between the yarns and the body"""
    body_thickness: Annotated[float, help_entry("CM")] = 0.0
    """distance from the body that the yarns keep"""
    gravity: Annotated[tuple[float, float, float], help_entry("X Y Z")] = (0.0, -981.0, 0.0)
    """acceleration of gravity [cm/s^2]"""
    drag: Annotated[float, help_entry("RATE")] = DRAG
    """rate at which the air slows motion down [1/s]"""
    carry: Annotated[str | None, help_entry("SELECTION", "none")] = None
    """part of the fabric that moves with the body, such as 'hem 2' (docs/selections.md); needs --fabric"""
    fabric: Annotated[str | None, help_entry("FABRIC", "none", help=f"{READ_STITCHES}, of the yarns")] = None
    yarn_radius: Annotated[float | None, help_entry("CM", FOUND_RADIUS)] = None
    """yarn radius [cm]"""
    unit: Unit = DEFAULT_UNIT
    quality: Annotated[str, help_entry("NAME", help=f"preset of accuracy and cost: {', '.join(PRESETS)}")] = (
        DEFAULT_QUALITY
    )
    device: Device = None
    threads: Threads = None
    material: MaterialSection = field(default_factory=MaterialSection)
    pictures: AnimationPictures = field(default_factory=AnimationPictures)
    json: AsJson = False
    overwrite: Overwrite = False

    def run(self) -> None:
        """Simulate the frames, write them, and print a summary.

        Raises:
            ParameterError: a part of the fabric is to be carried, and there is no fabric.
        """
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.io import read_yarns
        from stitchmesh.io.mesh_sequences import read_moving_mesh
        from stitchmesh.render.animation_pictures import draw_animation, picture_names
        from stitchmesh.run import Checkpoints, Run
        from stitchmesh.simulation.dead_load import Gravity
        from stitchmesh.yarnrelax.follow_body import follow_body
        from stitchmesh.yarnrelax.follow_files import ANIMATION, REPORT, FollowFiles
        from stitchmesh.yarnrelax.model.material import material_of
        from stitchmesh.yarnrelax.motion.moving_body import MovingBody

        names = ANIMATION, REPORT, *picture_names(self.pictures)
        yarns = read_yarns(self.yarns, unit=self.unit, radius=self.yarn_radius)
        moving = read_moving_mesh(
            self.body, unit=self.body_unit, up=self.body_up or Y, frames_per_second=self.frames_per_second
        )
        body = MovingBody(
            moving, friction=self.body_friction, thickness=self.body_thickness, carried=self._carried()
        )  # fmt: skip
        material = material_of(yarns, self.material.name, self.material.values())
        with output_folder(self.output, names) as folder, show_progress() as progress:
            kept = Checkpoints(folder, every=1)
            frames = follow_body(
                yarns, body, material=material, quality=self.quality, device=self.device,
                terms=[Gravity(self.gravity)], drag=self.drag,
                run=Run(progress, checkpoints=kept, resume=kept.path if self.resume else None),
            )  # fmt: skip
            files = FollowFiles(folder, yarns, moving, frame_format=self.pictures.frame_format)
            for frame in frames:
                files.add(frame)
            report = files.finish()
            draw_animation(files.frames(), moving, folder, self.pictures, body=True, progress=progress)
        seconds = sum(frame["seconds"] for frame in report["frames"])
        nearest = min(frame["body_gap_over_reach"] for frame in report["frames"])
        lines = [
            f"Simulated {len(report['frames'])} frames in {seconds:.3g} s.",
            f"Smallest distance of the yarns from the body, over the distance that they keep: {nearest:.2f}.",
            *material_lines(yarns.made_of if self.material.name is None else None),
            f"Wrote {folder / ANIMATION}; {folder / 'frames'} holds a file for each frame.",
        ]
        print_result(report, lines, as_json=self.json)

    def _carried(self) -> Pins | None:
        """Return the control points that the body carries."""
        if self.carry is None:
            return None
        if self.fabric is None:
            raise ParameterError("follow: got --carry without --fabric; name the stitch mesh of the yarns")
        from stitchmesh.io import read_stitches
        from stitchmesh.selection import select
        from stitchmesh.yarnrelax.constraints.pins import Pins

        return Pins(faces=select(read_stitches(self.fabric), self.carry))
