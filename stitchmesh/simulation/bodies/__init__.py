# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bodies: triangle meshes that yarns and cloth cannot enter."""
