# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The three-dimensional scene: its drawings, as data, and the places where they appear."""
