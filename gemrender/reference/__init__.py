"""The paper's tracer: small, float64, numpy only."""

from __future__ import annotations

from gemrender.reference.tracer import RayRecord, observe, trace

__all__ = ["RayRecord", "observe", "trace"]
