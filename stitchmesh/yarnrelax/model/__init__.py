# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a relaxation on the device: constants, state, material, spline and lattice images."""
