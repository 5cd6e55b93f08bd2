# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a face mesh: a drawing for each type of face, its strands on each face, and yarns along the joins."""
