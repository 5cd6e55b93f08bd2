# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Materials of crossing yarns: one yarn, and the yarns of a fabric."""
