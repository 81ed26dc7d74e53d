"""Light that comes straight from lights and sky to a surface, and is reflected there."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from gemrender.plugins.spectra import unpolarised

__all__ = ["MOST_LIGHTS", "direct_light", "mis_weight", "one_light"]

#: Most lights that are sampled one by one at a surface; of more of them so many are drawn.
MOST_LIGHTS = 8
#: Steps of Roberts' sequence of two dimensions: what is drawn on one light is spread against the others.
_STEPS = 0.7548777, 0.5698403


def mis_weight(pdf: mi.Float, other: mi.Float) -> mi.Float:
    """Power heuristic (Veach 1997, section 9.2.4) for a sample of density `pdf`, against one other."""
    # By the ratio: the square of a density can be infinite where a light is seen edge-on
    return dr.select(pdf > 0, dr.rcp(1 + dr.square(other / pdf)), 0)


@dr.syntax
def direct_light(scene, si, bsdf, place, samples, active):  # type: ignore[no-untyped-def]  # dr.syntax
    """Return the light that is reflected, by several samples, each in its own stratum of the lights.

    Where there are as many samples as lights, and these are drawn alike, each light has one. They are
    weighted against samples of the BSDF (Veach 1997, section 9.2).

    Parameters
    ----------
    scene : Scene
        The scene.
    si, bsdf : SurfaceInteraction3f, BSDFPtr
        The surface.
    place : Point2f
        Random numbers: where on the lights, the same for all but for a shift.
    samples : UInt32
        How many samples each surface takes.
    active : Bool
        Which surfaces there are.
    """
    context = mi.BSDFContext()
    radiance, number, left = mi.UnpolarizedSpectrum(0), mi.UInt32(0), mi.Bool(active)
    while dr.hint(left, label="direct light"):
        shifted = place + number * mi.Vector2f(*_STEPS)
        shifted -= dr.floor(shifted)
        drawn = mi.Point2f((shifted.x + number) / samples, shifted.y)
        ds, weight = scene.sample_emitter_direction(si, drawn, True, left)
        found = left & (ds.pdf != 0)
        value, pdf = bsdf.eval_pdf(context, si, si.to_local(ds.d), found)
        value, weight = unpolarised(value), unpolarised(weight)
        mis = dr.select(ds.delta, 1, mis_weight(ds.pdf * samples, pdf))
        radiance += dr.select(found, value * weight * (mis / samples), 0)
        number += 1
        left &= number < samples
    return radiance


def one_light(
    scene: mi.Scene, si: mi.SurfaceInteraction3f, bsdf: mi.BSDFPtr, place: mi.Point2f, active: mi.Bool
) -> mi.UnpolarizedSpectrum:
    """Return the light that is reflected, by one sample that stands for all: from there no ray goes on."""
    ds, weight = scene.sample_emitter_direction(si, place, True, active)
    found = active & (ds.pdf != 0)
    value = unpolarised(bsdf.eval(mi.BSDFContext(), si, si.to_local(ds.d), found))
    return dr.select(found, value * unpolarised(weight), 0)
