# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloth as triangulated flat panels that are sewn together, and the inputs from which it is made."""
