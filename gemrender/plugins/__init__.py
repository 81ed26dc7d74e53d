"""The Mitsuba plugins of gemrender, reached by name through ``mi.load_dict`` only.

========================  ==========  ===================================================
Name                      Kind        What it is
========================  ==========  ===================================================
``gem_orthographic``      sensor      parallel rays for the top view of a stone
``gem_hemisphere``        emitter     uniform light from above the horizon
``gem_zones``             emitter     light by zones of elevation above a viewer's horizon
``gem_primary``           integrator  follows principal rays, or all light from them
``gem_dielectric``        bsdf        smooth surface of a gem, with dispersion
``gem_rough_conductor``   bsdf        rough metal that keeps its energy
``gem_path``              integrator  radiance of scenes with stones, for pictures
========================  ==========  ===================================================

Importing this package registers the plugins for the active variant, if there is one, and again after every
change of variant. A class derived from ``mi.*`` belongs to the variant that it was defined under: registered
under another one it loads without an error, and the scene then leaves it out without a word. So the modules
are executed anew for each variant, and a class imported from one of them is soon a stale one: never import
the modules, ask ``load_dict`` for the name.
"""

from __future__ import annotations

import importlib
import sys

import mitsuba as mi

__all__ = ["register"]

_MODULES = ("orthographic", "hemisphere", "zones", "primary", "dielectric", "rough_conductor", "path")

# The variant that the classes in the modules belong to now.
_defined_for: str | None = None


def register(_old: str | None = None, _new: str | None = None) -> None:
    """Define and register every plugin for the active variant, unless that is done already.

    Mitsuba calls this after each change of variant with the old and the new name. Scalar variants get no
    plugins: Python plugins are about a hundred times slower there.
    """
    global _defined_for
    variant = mi.variant()
    if variant is None or variant.startswith("scalar") or variant == _defined_for:
        return
    _defined_for = None  # should a module fail, the next call starts over
    for name in _MODULES:
        module = sys.modules.get(f"{__name__}.{name}")
        if module is None:
            importlib.import_module(f"{__name__}.{name}")
        else:
            importlib.reload(module)
    _defined_for = variant


mi.detail.add_variant_callback(register)
register()
