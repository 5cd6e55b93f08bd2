# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting patterns as pictures: colour charts and tile codes, one pixel a stitch."""
