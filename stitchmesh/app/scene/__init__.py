# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The three-dimensional scene: what is drawn, as data, and where it is drawn."""
