# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What every simulation of fabric needs, of yarns (``yarnrelax``) and of cloth with yarns (``mixed``)."""
