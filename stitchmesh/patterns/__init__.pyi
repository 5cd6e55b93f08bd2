# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from .capture.capture import capture_pattern as capture_pattern
from .capture.capture import smallest_repeat as smallest_repeat
from .charts.colour_chart import chart_palette as chart_palette
from .charts.colour_chart import read_colour_chart as read_colour_chart
from .charts.colour_chart import write_colour_chart as write_colour_chart
from .charts.leaf_chart import read_leaf_chart as read_leaf_chart
from .charts.leaf_chart import write_leaf_chart as write_leaf_chart
from .language.parse import parse_pattern as parse_pattern
from .language.text_charts import leaf_codes as leaf_codes
from .language.text_charts import parse_leaf_codes as parse_leaf_codes
from .language.writing import format_pattern as format_pattern
from .library import pattern_names as pattern_names
from .library import read_pattern as read_pattern
from .pattern import SECTIONS as SECTIONS
from .pattern import Cell as Cell
from .pattern import Loop as Loop
from .pattern import Pattern as Pattern
from .pattern import Row as Row
from .pattern import check_closes as check_closes
from .placement.apply import apply_pattern as apply_pattern
from .placement.apply import lay_pattern as lay_pattern
from .placement.laying import LaidPattern as LaidPattern
from .placement.left_out import LeftOut as LeftOut
from .swatch_mesh import pattern_mesh as pattern_mesh
from .swatch_mesh import pattern_tube as pattern_tube
