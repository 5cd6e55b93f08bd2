# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape: the user chooses the region of yarns of a scene, runs the scene and watches the run."""
