"""Scenes with stones that others made, and what gem_path says of them."""

from __future__ import annotations

import warnings

import mitsuba as mi
import numpy as np
import pytest

from gemrender.errors import GemrenderWarning, InputError

GEM = {"type": "gem_dielectric", "dispersion": False}
QUARTZ = {"type": "gem_dielectric", "material": "quartz"}
INWARDS = "stone gem looks inwards; it is turned round"
SOME = "stone gem has {} faces of 12 that look inwards; they are turned round"


def camera(origin=(4, 3, 5), **more):
    to_world = mi.ScalarTransform4f().look_at(list(origin), [0, 0, 0], [0, 0, 1])
    film = {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    return {"type": "perspective", "fov": 20, "to_world": to_world, "film": film, **more}


def scene(**shapes):
    """A scene in light of radiance 1 from everywhere."""
    parts = {"integrator": {"type": "gem_path"}, "sensor": camera(), "sky": {"type": "constant"}}
    if mi.is_spectral:
        parts["sky"]["radiance"] = {"type": "uniform", "value": 1.0}
    return mi.load_dict({"type": "scene", **parts, **shapes})


def mean(of_scene, spp=64):
    return float(np.array(mi.render(of_scene, spp=spp)).mean())


def check(of_scene):
    of_scene.integrator().check(of_scene, of_scene.sensors()[0])


def refused(of_scene):
    """The one line that a scene is refused in."""
    with pytest.raises(InputError) as error:
        check(of_scene)
    return str(error.value)


def told(of_scene):
    """The warnings that a scene is taken with."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check(of_scene)
    assert all(w.category is GemrenderWarning for w in caught)
    return [str(w.message) for w in caught]
