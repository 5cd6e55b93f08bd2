# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weaves: matrices of over and under, their files, and their yarns."""
