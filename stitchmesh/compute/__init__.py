# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The basis of kernels: devices, precision, vector loads, blocks of threads, reductions and captured launches."""
