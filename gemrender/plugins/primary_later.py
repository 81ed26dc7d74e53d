"""One later exit of what a stone reflects where the principal ray leaves it; for `gem_primary`."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from gemrender.observation import LATER_CHANNELS, RayStatus
from gemrender.optics.fresnel import LEAST_TOTAL
from gemrender.plugins.stones import reflectance
from gemrender.plugins.surfaces import meet, set_out, turn

__all__ = ["LATER_NAMES", "follow_on"]

#: The AOVs of the later exit, in order.
LATER_NAMES = tuple(name for names in LATER_CHANNELS.values() for name in names)


@dr.syntax
def follow_on(scene, sampler, eta, most, path):  # type: ignore[no-untyped-def]  # dr.syntax reads the source
    """Follow what is reflected where the principal path leaves, to one later exit; return its AOVs.

    Parameters
    ----------
    scene, sampler : Scene, Sampler
        The scene, and what draws the exit.
    eta : Float64
        Relative index of the stone.
    most : UInt32
        Number of reflections after which a ray counts as trapped.
    path : Path
        The principal path.
    """
    # ---- Reflection where the principal path leaves: it is certain ----

    inside = path.status == int(RayStatus.EXITED)
    (cos_air, cos_stone), n = path.light_side, path.normal
    weight = reflectance(cos_air, cos_stone, eta)
    probability = mi.Float64(1)
    partial = mi.UInt32(1)
    d = (path.way.d - cos_air * n) / eta - cos_stone * n
    way = set_out(path.way.p, dr.normalize(d), path.way.on_wall)
    status = dr.select(inside, mi.UInt32(int(RayStatus.TRAPPED)), mi.UInt32(int(RayStatus.MISSED)))
    any_later = mi.Bool(inside)
    inside &= path.reflections < most
    reflections = dr.select(inside, path.reflections + 1, path.reflections)
    facet = mi.Float(-1)
    cos_out = mi.Float64(0)  # of the angle in air, where it leaves

    # ---- From surface to surface, until it leaves by chance ----

    while dr.hint(inside, label="gem_primary: all light"):
        met = meet(scene, way, inside)
        status[inside & ~met.found & ~met.again] = mi.UInt32(int(RayStatus.LOST))

        d, n, cos_i = way.d, met.normal, met.cos
        sin2 = dr.square(eta) * (1 - dr.square(cos_i))
        parts = met.found & (sin2 < LEAST_TOTAL)
        cos_t = dr.safe_sqrt(1 - sin2)
        back = dr.select(parts, reflectance(cos_t, cos_i, eta), 1)
        exits = parts & (mi.Float64(sampler.next_1d(parts)) >= back)
        probability *= dr.select(exits, 1 - back, back)
        status[exits] = mi.UInt32(int(RayStatus.EXITED))
        facet = dr.select(exits, met.facet, facet)
        cos_out = dr.select(exits, cos_t, cos_out)

        reflects = met.found & ~exits
        weight *= dr.select(reflects, back, 1)
        partial[parts & ~exits] += 1
        refracted = eta * (d - cos_i * n) + cos_t * n
        d = dr.select(exits, refracted, dr.select(reflects, d - 2 * cos_i * n, d))
        reflects &= reflections < most
        reflections[reflects] += 1
        inside = reflects | met.again
        way = turn(way, met, d)

    exited = status == int(RayStatus.EXITED)
    p, d = dr.select(exited, way.p, 0), dr.select(exited, way.d, 0)
    counts = (reflections, partial, weight, probability)
    values = (status, *(dr.select(any_later, x, 0) for x in counts), *p, *d, facet, cos_out)
    return dict(zip(LATER_NAMES, values, strict=True))
