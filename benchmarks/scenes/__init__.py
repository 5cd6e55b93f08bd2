# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What is measured: garments, swatches, surfaces and cloths."""
