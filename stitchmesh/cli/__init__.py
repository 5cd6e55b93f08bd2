# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line: every stage from file to file, each option read from a field of a dataclass."""
