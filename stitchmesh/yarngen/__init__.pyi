# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from .embedding import belongs_to_loop_below as belongs_to_loop_below
from .finish import YarnFinish as YarnFinish
from .generate import generate_yarns as generate_yarns
from .generate import mean_stitch_width as mean_stitch_width
from .loop_check.loop_linking import check_loops as check_loops
from .regenerate import regenerate_yarns as regenerate_yarns
from .room import make_room as make_room
