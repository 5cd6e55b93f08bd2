# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weaves: matrices of the yarns that lie on top, their files, and their yarns."""
