# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a V-bed knitting machine does: a stitch mesh as operations on needles."""

from stitchmesh.machine_knitting.knitting import machine_program

__all__ = ["machine_program"]
