# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Motion and rest of the mixed system: masses, conjugate gradients, Newton's method, backward Euler, statics."""
