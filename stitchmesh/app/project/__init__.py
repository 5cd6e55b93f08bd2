# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Projects: the folder on disk, the values of all stages, settings, undo and autosave."""
