"""The one palette for Hall's zones: figures, report and review page use it, and nothing else stands for a zone."""

from __future__ import annotations

from types import MappingProxyType

from ..distances import UNCERTAIN

#: After Okabe and Ito 2008, the nearest zone warmest; intimate is darker and social lighter than theirs, so that any
#: two differ by 20 (CIEDE2000) or more for protanopes, deuteranopes and tritanopes too, where theirs came to 12.
ZONE_COLOURS = MappingProxyType(
    {"intimate": "#B33C00", "personal": "#E69F00", "social": "#6CC0F0", "public": "#0072B2", UNCERTAIN: "#8A8F94"}
)
