# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The star of a crossing node: all energies that have their middle in the node, their forces and their Hessian."""
