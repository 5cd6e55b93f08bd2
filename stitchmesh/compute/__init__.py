# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What kernels are made of: devices, precision, vector loads, blocks of threads, reductions, captured launches."""
