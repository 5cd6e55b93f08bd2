# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns laid out on the panels of a cloth, woven or knitted, with a node at each crossing."""
