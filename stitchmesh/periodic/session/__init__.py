# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Live swatches: a swatch that takes changes while it relaxes."""
