# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One command a file: a frozen dataclass whose fields are its arguments, and ``run``, which does it."""
