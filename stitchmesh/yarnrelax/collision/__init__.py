# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact search and step limit: which contact samples may touch, and how far control points may move."""
