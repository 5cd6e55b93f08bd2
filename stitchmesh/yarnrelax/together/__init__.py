# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many cells that are relaxed and examined together, in launches that all cells share."""
