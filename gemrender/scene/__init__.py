"""Scenes: a stone, its light and a sensor, as Mitsuba dictionaries and XML."""

from __future__ import annotations

from gemrender.scene.generator import stone_scene

__all__ = ["stone_scene"]
