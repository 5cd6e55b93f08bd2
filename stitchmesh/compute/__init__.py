# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Building blocks of kernels: devices, precision, vector loads, blocks of threads, reductions, captured launches."""
