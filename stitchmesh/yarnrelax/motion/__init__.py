# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bodies that move in time: their surface on the device, contact and friction with yarns, and yarns that they carry."""
