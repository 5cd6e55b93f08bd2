# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The swatch designer: a chart, the fabric that follows it, and the dials of the fabric."""
