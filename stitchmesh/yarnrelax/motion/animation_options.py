# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of yarns that a moving cloth carries (``yarnrelax.animate_yarns``)."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.settings import check_settings, setting


@dataclass(frozen=True)
class AnimationOptions:
    """How accurate the frames are, and which of them are certified in full.

    Raises:
        ParameterError: a number is out of its bounds.
    """

    iterations: int = setting(
        20, "iterations of the solver in each frame; more of them bring the yarns nearer to rest", form="N",
        example=20, least=1, most=1000, expected="a number of iterations",
    )  # fmt: skip
    first_iterations: int = setting(
        2000, "largest number of iterations at the first frame, with which the yarns come to rest on the cloth",
        form="N", example=2000, least=1, most=1_000_000, expected="a number of iterations",
    )  # fmt: skip
    certify_every: int = setting(
        30, "frames from one certificate of the linking of all yarns to the next; the last frame has one too",
        form="N", example=30, least=1, most=1_000_000, expected="a number of frames",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)
