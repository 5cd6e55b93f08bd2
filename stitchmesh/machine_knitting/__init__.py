# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Machine knitting: a stitch mesh as a program of needle operations for a V-bed knitting machine."""

from stitchmesh.machine_knitting.knitting import machine_program

__all__ = ["machine_program"]
