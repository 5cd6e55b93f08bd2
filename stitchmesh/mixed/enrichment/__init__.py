# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a cloth has yarns, and how yarns and triangles move together there (Casafranca et al. 2020)."""
