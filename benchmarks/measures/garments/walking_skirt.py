# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A knitted skirt on a body that walks in place: seconds for each frame, and a sheet of the frames as one picture.

- ``skirt`` and ``walk`` write the skirt and the frames of the body (``benchmarks/scenes/walking_body.py``).
- ``follow``: the skirt is knitted, relaxed around the standing body, and follows it; the body carries the two rows at
  the waist. Yarns that are at rest in the output folder are taken from there, and a run that was stopped continues
  there: one with ``--simulate-only`` on a machine without OpenUSD and a display is drawn by the same command elsewhere.
  The first frame includes the loading of kernels, and the mean leaves it out.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.options import Output
from benchmarks.scenes import walking_body
from benchmarks.scenes.garments import Garment
from benchmarks.scenes.walking_body import FRAMES_PER_SECOND, walking
from benchmarks.table import Rows
from stitchmesh.mesh import StitchMesh
from stitchmesh.yarn import YarnSet


def skirt(*, output: Output) -> Rows:
    """Write the skirt."""
    mesh = walking_body.skirt()
    sm.write_mesh(output, mesh)
    yield f"{output}: {mesh}"


def walk(body: Path, /, *, output: Output, unit: str = "cm", frames: int = 60) -> Rows:
    """Bend the body, and write the frames."""
    mesh = sm.read_mesh(body, unit=unit)
    sm.write_moving_mesh(output, walking(mesh, frames), frames_per_second=FRAMES_PER_SECOND)
    yield f"{output}: {frames} frames of {len(mesh.vertices):,} vertices"


SHEET = sm.AnimationPictures(sheet=True, sheet_frames=60, sheet_columns=12, view="25,5", picture_size=(600, 780))
"""The sheet of the frames."""


def skirt_at_rest(
    given: Options, body: sm.Mesh, folder: Path
) -> Generator[str, None, tuple[StitchMesh, YarnSet]]:
    """The skirt, relaxed around the standing body."""
    fabric_file, yarn_file = folder / "stitches.h5", folder / "yarns.h5"
    if yarn_file.exists():
        return sm.read_stitches(fabric_file), sm.read_yarns(yarn_file)
    fabric = Garment(str(given.skirt), given.stitch_width, given.unit).evened(given.device)
    yarns = sm.generate_yarns(fabric, yarn_radius=given.stitch_width / 8.0)
    worn = sm.dressed(yarns, fabric, [sm.Body(body)], device=given.device)
    relaxed = sm.relax_yarns(
        worn.yarns, quality=given.quality, keep_shape=worn.fabric, terms=[sm.Body(body)], device=given.device,
        material=material_of(given, yarns),
    )  # fmt: skip
    yield f"at rest: {relaxed.report['seconds']:.3g} s, residual {relaxed.report['residual']:.2g}"
    sm.write_stitches(fabric_file, fabric)
    sm.write_yarns(yarn_file, relaxed.yarns)
    return fabric, relaxed.yarns


def material_of(given: Options, yarns: YarnSet) -> sm.YarnMaterial:
    """The usual material for the radius of the yarns, with contacts as stiff as asked for."""
    usual = sm.YarnMaterial.named().of_radius(float(yarns.radius.mean()))
    return replace(usual, k_contact=given.contact * usual.k_contact)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    skirt: Positional[Path]
    body: Positional[Path]
    output: Output
    unit: str = "cm"
    stitch_width: float = 1.5
    frames: int = 60
    quality: str = "draft"
    contact: float = 1.0
    """stiffness of contacts over the usual one"""
    device: str | None = None
    simulate_only: bool = False
    """write no USD and no picture"""


def follow(given: Options) -> Rows:
    """Knit a skirt, relax it around a body, let it follow, and draw it."""
    body = sm.read_mesh(given.body, unit=given.unit)
    moving = walking(body, given.frames)
    fabric, yarns = yield from skirt_at_rest(given, body, given.output)
    yield f"{fabric.face_count:,} stitches, {len(yarns.points):,} control points"
    files = sm.FollowFiles(given.output, yarns, moving)
    if not (given.output / "frames" / f"{given.frames - 1:04d}.smc").exists():
        yield from simulate(given, fabric, yarns, moving, files)
    seconds = [frame.report["seconds"] for frame in files.frames()][2:]
    if seconds:
        yield f"mean of frames 2 to {given.frames - 1}: {np.mean(seconds):.3g} s"
    if not given.simulate_only:
        files.finish()
        sm.draw_animation(files.frames(), moving, given.output, SHEET, body=True)


def simulate(
    given: Options, fabric: StitchMesh, yarns: YarnSet, moving: sm.MovingMesh, files: sm.FollowFiles
) -> Rows:
    """Let the skirt follow, write its frames, and print a line for each."""
    yield "frame", "steps", "s", "smallest distance / r", "from the body / reach"
    kept = sm.Checkpoints(given.output, every=1)
    frames = sm.follow_body(
        yarns, sm.MovingBody(moving, carried=sm.Pins(faces=sm.select(fabric, "neck 2"))), quality=given.quality,
        device=given.device, terms=[sm.Gravity()], material=material_of(given, yarns),
        run=sm.Run(checkpoints=kept, resume=kept.path),
    )  # fmt: skip
    for frame in frames:
        files.add(frame)
        own = frame.report
        distances = f"{own['min_distance_over_radius']:.2f}", f"{own['body_gap_over_reach']:.2f}"
        yield frame.number, own["steps"], f"{own['seconds']:.2f}", *distances


ACTIONS = (skirt, walk, follow)
