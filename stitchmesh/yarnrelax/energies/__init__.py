# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Energies of yarns and their forces: one file for each energy, and the files that add the forces up."""
