"""The one palette for Hall's zones: figures, report and review page use it, and nothing else stands for a zone."""

from __future__ import annotations

from types import MappingProxyType

from ..distances import UNCERTAIN

#: Okabe and Ito's colours (2008), nearest zone warmest: told apart with any colour vision, and ordered in grey.
ZONE_COLOURS = MappingProxyType(
    {"intimate": "#D55E00", "personal": "#E69F00", "social": "#56B4E9", "public": "#0072B2", UNCERTAIN: "#8A8F94"}
)
