# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact of a cloth with itself and with bodies, friction with bodies, and attachments."""
