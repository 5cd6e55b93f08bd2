# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Energies of crossing yarns at one crossing or segment, and the angles that they depend on."""
