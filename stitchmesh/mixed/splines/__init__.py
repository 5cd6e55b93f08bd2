# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as B-splines in contact, with loops that stand out of the cloth (Kaldor et al. 2008, Leaf et al. 2018).

``yarnrelax`` provides the energies, their second derivatives and the contact. Control points are the yarn nodes of
the mixed system; they have no Eulerian coordinates.
"""
