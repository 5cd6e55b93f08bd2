# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of kernels: devices, precision, vector loads, blocks of threads, reductions and captured launches."""
