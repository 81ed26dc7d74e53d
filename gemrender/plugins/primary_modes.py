"""The principal ray of a birefringent stone: in one mode at a time, drawn by its share; for `gem_primary`.

As polygons with modes follow it (`gemrender.beam.modes`): what enters of unpolarised light is shared between
two modes, what is totally reflected of a mode between the two that go on, and at the first facet that some of
it may leave by it is done. Where one mode stands for both, drawn by its share, means over rays are sums over
all histories of modes.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from gemrender.observation import PATH_CODE_FACTOR, PATH_CODE_MASK, RayStatus
from gemrender.optics.fresnel import LEAST_TOTAL
from gemrender.plugins.surfaces import Way, enter, meet, set_out, turn

__all__ = ["Path", "follow_modes"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Path:
    """What is known of a principal ray that has been followed; arrays, one value a ray."""

    hit: mi.Bool
    status: mi.UInt32
    reflections: mi.UInt32
    entry_facet: mi.Float
    entry_normal: mi.Vector3d
    exit_facet: mi.Float
    code: mi.UInt32
    way: Way  # where the ray leaves the stone, and in which direction
    eye_side: tuple[mi.Float64, mi.Float64]  # cosines of the angles in air and in the stone
    light_side: tuple[mi.Float64, mi.Float64]
    normal: mi.Vector3d  # where it leaves
    transmitted: mi.Float64  # share of the light that both crossings let through
    section: mi.Float64  # cross-section of the beam where its light comes in, by that in the view


@dr.syntax
def follow_modes(scene, sampler, crystal, most, ray, active):  # type: ignore[no-untyped-def]  # dr.syntax
    """Follow rays from outside into a birefringent stone and to where they first may leave it.

    Parameters
    ----------
    scene, sampler : Scene, Sampler
        The scene, and what draws the modes: a number at the entry, and one at each reflection.
    crystal : Crystal
        What the stone is made of.
    most : UInt32
        Number of reflections after which a ray counts as trapped.
    ray, active : Ray3f, Bool
        The rays, and which of them are followed.

    Returns
    -------
    Path
        What became of them.
    """
    # ---- Into the stone: what enters is what would leave, reversed; of unpolarised light half of it ----

    entry = enter(scene, ray, active)
    hit, n = entry.hit, entry.normal
    tangential = entry.direction + entry.cos_air * n
    at = crystal.at_facet(-tangential, n)
    entering = at.passed[0] + at.passed[1]
    number = mi.Float64(sampler.next_1d(hit))
    second = number * entering >= at.passed[0]  # whether the ray is in the second mode
    wave = dr.select(second, at.out[1], at.out[0])
    nowhere = mi.Vector3d(0, 0, -1)
    k, d = dr.select(hit, -wave.k, nowhere), dr.select(hit, -wave.ray, nowhere)
    cos_eye = -dr.dot(d, n)
    section = cos_eye / entry.cos_air

    # ---- From surface to surface by total reflection, until the ray leaves ----

    p = dr.select(hit, entry.point, 0)
    way = set_out(p, d, entry.on_wall)
    inside = mi.Bool(hit)
    status = dr.select(hit, mi.UInt32(int(RayStatus.TRAPPED)), mi.UInt32(int(RayStatus.MISSED)))
    reflections = mi.UInt32(0)
    facet = mi.Float(-1)
    code = dr.select(hit, mi.UInt32(entry.facet) + 1, 0)
    leaving = mi.Float64(1)  # share of the ray's mode that leaves
    cos_stone = mi.Float64(1)  # of the ray's angle inside, where it leaves
    cos_air = mi.Float64(1)  # of the angle outside
    normal = mi.Vector3d(0)  # there

    while dr.hint(inside, label="gem_primary: modes"):
        met = meet(scene, way, inside)
        status[inside & ~met.found & ~met.again] = mi.UInt32(int(RayStatus.LOST))
        code = dr.select(
            met.found, (code * PATH_CODE_FACTOR + mi.UInt32(met.facet) + 1) & PATH_CODE_MASK, code
        )

        n, along = met.normal, met.cos
        tangential = k - dr.dot(k, n) * n
        sin2 = dr.squared_norm(tangential)
        at = crystal.at_facet(tangential, n)
        came = crystal.is_second(at, k, n, second)
        exits = met.found & (sin2 < LEAST_TOTAL)
        cos_t = dr.safe_sqrt(1 - sin2)
        status[exits] = mi.UInt32(int(RayStatus.EXITED))
        facet = dr.select(exits, met.facet, facet)
        leaving = dr.select(exits, dr.select(came, at.passed[1], at.passed[0]), leaving)
        cos_stone = dr.select(exits, along, cos_stone)
        cos_air = dr.select(exits, cos_t, cos_air)
        normal = dr.select(exits, n, normal)

        reflects = met.found & ~exits & (reflections < most)
        first = dr.select(came, at.reflected[1][0], at.reflected[0][0])
        both = first + dr.select(came, at.reflected[1][1], at.reflected[0][1])
        number = mi.Float64(sampler.next_1d(reflects))
        into = number * both >= first
        back = dr.select(into, at.back[1], at.back[0])
        section *= dr.select(exits, cos_t / along, dr.select(reflects, -dr.dot(back.ray, n) / along, 1))
        second = dr.select(reflects, into, second)
        k = dr.select(reflects, back.k, k)
        refracted = tangential + cos_t * n
        d = dr.select(exits, refracted, dr.select(reflects, back.ray, way.d))
        reflections[reflects] += 1
        inside = reflects | met.again
        way = turn(way, met, d)

    return Path(
        hit=hit,
        status=status,
        reflections=reflections,
        entry_facet=entry.facet,
        entry_normal=entry.normal,
        exit_facet=facet,
        code=code,
        way=way,
        eye_side=(entry.cos_air, cos_eye),
        light_side=(cos_air, cos_stone),
        normal=normal,
        transmitted=0.5 * entering * leaving,
        section=section,
    )
