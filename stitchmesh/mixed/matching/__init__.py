# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangle stiffnesses that match the yarns of the same fabric (Casafranca et al. 2020, section 7)."""
