# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape: the region of yarns of a scene is chosen, and the scene runs while it is watched."""
