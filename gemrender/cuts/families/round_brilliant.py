"""The round brilliant, as a family: the paper's proportions."""

from __future__ import annotations

from gemrender.cuts.round_brilliant.proportions import RoundBrilliant

__all__ = ["FAMILY", "Parameters"]

FAMILY = "round brilliant"
Parameters = RoundBrilliant
