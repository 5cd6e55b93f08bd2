# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Execution of kernels: devices, and the decorator that declares a kernel."""
