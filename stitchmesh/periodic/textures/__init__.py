# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture maps of one period of a fabric: colour, height, normal, opacity and yarn direction."""
