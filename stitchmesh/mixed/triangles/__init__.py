# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The energies of cloth as triangles: membrane, bending, rods along seams, and weight."""
