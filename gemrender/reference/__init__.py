"""The paper's tracer: small, float64, numpy only."""

from __future__ import annotations

from gemrender.reference.path import RayPath, trace_paths
from gemrender.reference.tracer import RayRecord, observe, trace

__all__ = ["RayPath", "RayRecord", "observe", "trace", "trace_paths"]
