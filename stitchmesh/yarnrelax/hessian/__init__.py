# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Second derivatives of the energies, their product with a motion, and the factors of their matrix."""
