# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A scene that runs in a fraction of a second, a small cloth that swings from its upper side, and a stop of its run."""

from __future__ import annotations

from stitchmesh.mixed.drape import Draped
from stitchmesh.mixed.scene.motion_section import AttachmentSection
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import ClothSection, OutputSection, Scene, SceneSolverSection, YarnsSection
from stitchmesh.run_control import RunControl, Snapshot

MIDDLE = BoxSection(low=(1.0, 1.0, -1.0), high=(2.0, 2.0, 1.0))
SWINGING = Scene(
    cloth=ClothSection(rectangle=(3.0, 3.0), edge_length=0.75),
    yarns=YarnsSection(weave="plain", ends=3.0, picks=3.0),
    region=RegionSection(boxes=(MIDDLE,)),
    mode="dynamic",
    duration=0.02,
    largest_step=0.004,
    gravity=(0.0, -700.0, 700.0),
    attachments=(AttachmentSection(boxes=(BoxSection(low=(-1.0, 2.8, -1.0), high=(9.0, 9.0, 1.0)),)),),
    solver=SceneSolverSection(device="cpu", velocity_tolerance=1.0),
    output=OutputSection(picture=False, frames_per_second=100.0),
)
"""Three frames: at 0, 0.01 and 0.02 s."""


def stopping_after(steps: int) -> RunControl[Draped]:
    """A control that stops a run after a number of steps; a pause shows its state, however fast the steps are."""

    def watch(snapshot: Snapshot[Draped]) -> None:
        if snapshot.iteration >= steps:
            control.stop()

    control: RunControl[Draped] = RunControl(watch, seconds=0.0)
    control.step(steps - 1)  # the first step needs no leave
    return control
