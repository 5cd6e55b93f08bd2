# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands, one in each file: a frozen dataclass whose fields are the arguments, with a method ``run``."""
