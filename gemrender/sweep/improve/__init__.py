"""Better stones: parameters of a cut searched for one goal, or for several at once."""

from __future__ import annotations

from gemrender.sweep.improve.answers import Answer, SearchInterruptedError
from gemrender.sweep.improve.pareto import Front, pareto_front
from gemrender.sweep.improve.run import Improvement, improve

__all__ = ["Answer", "Front", "Improvement", "SearchInterruptedError", "improve", "pareto_front"]
