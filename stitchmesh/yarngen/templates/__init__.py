# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What one stitch looks like: the yarn parts in a flat face."""
