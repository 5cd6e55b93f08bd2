# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns on any moving mesh: knit the fabric if it has no yarns yet, and carry the yarns with the cloth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from stitchmesh.compute.device import device_named
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.animate_yarns import animate_yarns, refuse_wrong_cloth
from stitchmesh.yarnrelax.frame_run import YarnFrame
from stitchmesh.yarnrelax.motion.animation_options import AnimationOptions


def animate(
    fabric: StitchMesh,
    cloth: MovingMesh,
    yarns: YarnSet | None = None,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    options: AnimationOptions | None = None,
    run: Run[YarnSet] = SHOWN,
) -> Iterator[YarnFrame]:
    """Carry the yarns of a fabric with a cloth that moves, relax them in each frame, and yield them.

    The cloth is an animation that any program made of the surface on which the fabric was knitted. Its first frame is
    where the fabric is. ``animate_yarns`` describes the frames, what is proved about them, and their reports.

    Args:
        fabric: the stitch mesh.
        cloth: the moving surface (``read_moving_mesh``).
        yarns: yarns that were generated from the fabric, for example those that ``knit`` relaxed; if not given, they
            are generated and relaxed.
        material: stiffnesses; None for the material ``stitchmesh``, scaled to the radius of the yarns.
        quality: a preset or a ``Quality``.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.
        options: numbers of iterations and of certificates.
        run: progress, checkpoints, whose interval is counted in frames, and the checkpoint to resume.

    Yields:
        The yarns at each frame; a resumed run yields only the frames after its checkpoint.

    Raises:
        StitchMeshError: the yarns cannot be generated or relaxed, or as for ``animate_yarns``.
    """
    if yarns is None:
        refuse_wrong_cloth(fabric, cloth, device_named(device))  # before the work
        drawn = generate_yarns(fabric, quality=quality, device=device)
        alone = replace(run, checkpoints=None, resume=None)
        yarns = relax_yarns(
            drawn, material=material, quality=quality, device=device, keep_shape=fabric, run=alone
        ).yarns  # fmt: skip
    return animate_yarns(
        yarns, fabric, cloth, material=material, quality=quality, device=device, options=options, run=run
    )  # fmt: skip
