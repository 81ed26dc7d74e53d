"""The paper's tracer: small, float64, numpy only."""

from __future__ import annotations

from gemrender.reference.all_light import paths, paths_by_ray
from gemrender.reference.path import RayPath, full_paths
from gemrender.reference.tracer import RayRecord, observe, trace

__all__ = ["RayPath", "RayRecord", "full_paths", "observe", "paths", "paths_by_ray", "trace"]
