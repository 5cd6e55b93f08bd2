# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Periodic swatches: one repeat of a knitted or woven fabric, relaxed on a lattice (Leaf et al. 2018)."""
