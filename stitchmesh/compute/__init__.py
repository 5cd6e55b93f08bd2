# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where and how kernels run: devices, and the one decorator that declares a kernel."""
