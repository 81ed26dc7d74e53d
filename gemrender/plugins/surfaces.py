"""The surfaces of a stone as `gem_primary` meets them: found by Mitsuba, placed in double precision."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

from gemrender.scene.mesh import FACET_ATTRIBUTE, NORMAL_ATTRIBUTES, OFFSET_ATTRIBUTES

__all__ = ["RAY_OFFSET", "Entry", "Meeting", "Way", "enter", "meet", "set_out", "turn"]

#: How far the search for the next facet starts from the last one [girdle radius]. Must exceed the sagitta
#: of the mesh's girdle (4.7e-6) and single precision's rounding at distance 1 (6e-8).
RAY_OFFSET = 1e-5

#: How far a surface's place along a ray may be from the mesh's [girdle radius]: more than the girdle's chords
#: and arcs are apart along a ray that grazes it (3e-3), less than most ways through the stone.
MOST_APART = 1e-2

#: A ray that runs along a round girdle meets it so far behind the mesh's chord, or more, that it may meet a
#: facet in between [girdle radius]. At steeper angles chord and wall are closer.
GRAZING = 2e-5
#: How far aside a second look is taken for that facet [girdle radius]: more than the sagitta of the chords.
ASIDE = 1e-5

#: Further queries, beyond a surface that was passed by or beside the last place, before a ray is lost.
MOST_RETRIES = 8


@dataclass(slots=True, kw_only=True)
class Entry:
    """Where rays from outside meet the stone; arrays, one value a ray."""

    hit: mi.Bool
    facet: mi.Float
    point: mi.Point3d
    normal: mi.Vector3d
    on_wall: mi.Bool  # of a round girdle
    direction: mi.Vector3d  # of the ray, in air
    cos_air: mi.Float64


@dataclass(slots=True, kw_only=True)
class Way:
    """Where rays inside are, and where their next surface is looked for: the state of a loop."""

    p: mi.Point3d  # the last place, on the surface itself
    d: mi.Vector3d
    start: mi.Point3f  # of the query
    on_wall: mi.Bool
    retries: mi.UInt32
    wall_facet: mi.Float  # number of the wall that a ray grazes
    to_wall: mi.Float64  # how far it goes to that wall, while facets before it are looked for


@dataclass(slots=True, kw_only=True)
class Meeting:
    """What one query found."""

    found: mi.Bool
    again: mi.Bool  # nothing yet: another query may
    grazes: mi.Bool  # it is for the wall that the other query looks
    passes_by: mi.Bool  # or beyond what this one found
    beyond: mi.Point3f
    retries: mi.UInt32
    place: mi.Point3d
    facet: mi.Float
    normal: mi.Vector3d
    is_wall: mi.Bool
    cos: mi.Float64  # of the angle of incidence
    wall_facet: mi.Float
    to_wall: mi.Float64


# ---- Steps of a ray ----


def enter(scene: mi.Scene, ray: mi.Ray3f, active: mi.Bool) -> Entry:
    """Return where rays from outside meet the stone."""
    si = _first_hit(scene, ray, active)
    hit = active & si.is_valid()
    facet, n, offset = _surface(si, hit)
    on_wall = _is_wall(n)
    d = dr.normalize(mi.Vector3d(ray.d))
    p, n = _meet(mi.Point3d(ray.o), d, n, offset, entering=True)
    cos_air = -dr.dot(n, d)
    hit &= cos_air > 0
    return Entry(hit=hit, facet=facet, point=p, normal=n, on_wall=on_wall, direction=d, cos_air=cos_air)


def set_out(p: mi.Point3d, d: mi.Vector3d, on_wall: mi.Bool) -> Way:
    """Return the way of rays that leave a place on the surface inwards."""
    retries = mi.UInt32(0)
    return Way(
        p=mi.Point3d(p),
        d=mi.Vector3d(d),
        start=_query_start(p, d, on_wall, retries),
        on_wall=mi.Bool(on_wall),
        retries=retries,
        wall_facet=mi.Float(-1),
        to_wall=mi.Float64(0),
    )


def meet(scene: mi.Scene, way: Way, inside: mi.Bool) -> Meeting:
    """Look for the next surface of rays inside, once."""
    p, d, start = way.p, way.d, way.start
    si = scene.ray_intersect(mi.Ray3f(start, mi.Vector3f(d)), mi.RayFlags.Minimal, False, inside)
    found = inside & si.is_valid()
    facet, n, offset = _surface(si, found)
    is_wall = _is_wall(n)
    q, n = _meet(p, d, n, offset)
    cos = dr.dot(n, d)
    # Beside an edge the mesh may show a face whose own place on this line is elsewhere.
    apart = dr.dot(q - mi.Point3d(start), d) - mi.Float64(si.t)
    found &= (cos > 0) & (dr.abs(apart) < MOST_APART)

    # The mesh's girdle stands inside the true wall: between them a ray along it may meet a facet,
    # which a parallel one a little further inside finds.
    looks_aside = way.to_wall > 0
    grazes = found & ~looks_aside & is_wall & (apart > GRAZING)
    before_wall = found & ~is_wall & (dr.dot(q - p, d) < way.to_wall)
    at_wall = looks_aside & ~before_wall
    q = dr.select(at_wall, p + way.to_wall * d, q)
    n = dr.select(at_wall, _radial(q), n)
    wall_facet = dr.select(grazes, facet, way.wall_facet)
    facet = dr.select(at_wall, wall_facet, facet)
    is_wall |= at_wall
    cos = dr.select(at_wall, dr.dot(n, d), cos)
    found = (found | at_wall) & ~grazes
    to_wall = dr.select(grazes, dr.dot(q - p, d), 0)
    # What faces the other way is passed by; a ray may also slip through an edge in single precision.
    retries = dr.select(found | grazes, 0, way.retries + 1)
    again = inside & ~found & (retries <= MOST_RETRIES)
    return Meeting(
        found=found,
        again=again,
        grazes=grazes,
        passes_by=again & si.is_valid() & ~grazes,
        beyond=mi.Point3f(mi.Point3d(start) + (mi.Float64(si.t) + RAY_OFFSET) * d),
        retries=retries,
        place=q,
        facet=facet,
        normal=n,
        is_wall=is_wall,
        cos=cos,
        wall_facet=wall_facet,
        to_wall=to_wall,
    )


def turn(way: Way, met: Meeting, d: mi.Vector3d) -> Way:
    """Go on from what was met, in direction d; where nothing was yet, by another query of the same ray."""
    p = dr.select(met.found, met.place, way.p)
    on_wall = dr.select(met.found, met.is_wall, way.on_wall)
    aside = mi.Point3f(p + RAY_OFFSET * d - ASIDE * _radial(p + met.to_wall * d))
    start = dr.select(met.passes_by, met.beyond, _query_start(p, d, on_wall, met.retries))
    return Way(
        p=p,
        d=d,
        start=dr.select(met.grazes, aside, start),
        on_wall=on_wall,
        retries=met.retries,
        wall_facet=met.wall_facet,
        to_wall=met.to_wall,
    )


# ---- Queries ----


def _first_hit(scene: mi.Scene, ray: mi.Ray3f, active: mi.Bool) -> mi.SurfaceInteraction3f:
    """Return where rays from outside meet the stone.

    The ray tracer may miss both faces beside an edge that a ray meets exactly, as whole rows of pixels do,
    and find the stone's far side, what is behind it, or nothing: where rays a little to either side do not,
    one of them counts.
    """

    def meet(ray: mi.Ray3f, active: mi.Bool) -> mi.SurfaceInteraction3f:
        return scene.ray_intersect(ray, mi.RayFlags.Minimal, False, active)

    si = meet(ray, active)
    missed = active & ~_comes_in(si, ray)
    aside = ASIDE * mi.Frame3f(ray.d).s
    left, right = (mi.Ray3f(ray.o + side, ray.d, ray.time, ray.wavelengths) for side in (aside, -aside))
    beside = meet(left, missed)
    leaks = missed & _comes_in(beside, ray)
    leaks &= _comes_in(meet(right, leaks), ray)
    return dr.select(leaks, beside, si)


def _comes_in(si: mi.SurfaceInteraction3f, ray: mi.Ray3f) -> mi.Bool:
    """Return whether a ray meets a stone's face from outside."""
    valid = si.is_valid()
    return valid & si.shape.has_attribute(NORMAL_ATTRIBUTES[0], valid) & (dr.dot(si.n, ray.d) < 0)


def _query_start(p: mi.Point3d, d: mi.Vector3d, on_wall: mi.Bool, retries: mi.UInt32) -> mi.Point3f:
    """Where to look for the next facet from: inside the stone, although p lies on its surface.

    From a plane a little way along the ray, which leaves the line as it is. From a round girdle, whose mesh
    runs inside the true wall, and after a query that found nothing (p lies beside an edge), towards the
    stone's middle; each retry also aside of the last.
    """
    along = p + RAY_OFFSET * d
    step = RAY_OFFSET * mi.Float64(retries)
    drawn_in = p * (1 - RAY_OFFSET - step) + step * dr.cross(d, mi.Vector3d(0.8, 0.36, 0.48))
    return mi.Point3f(dr.select(on_wall | (retries > 0), drawn_in, along))


# ---- Surfaces of the stone, in double precision ----


def _surface(si: mi.SurfaceInteraction3f, active: mi.Bool) -> tuple[mi.Float, mi.Vector3d, mi.Float64]:
    """Facet number, and the plane's outward normal and offset, of the face that was hit."""
    shape = si.shape
    facet = shape.eval_attribute_1(FACET_ATTRIBUTE, si, active)
    normal, offset = (
        kind(shape_value(high, si, active)) + kind(shape_value(low, si, active))
        for kind, shape_value, (high, low) in (
            (mi.Vector3d, shape.eval_attribute_3, NORMAL_ATTRIBUTES),
            (mi.Float64, shape.eval_attribute_1, OFFSET_ATTRIBUTES),
        )
    )
    return facet, normal, offset


def _meet(
    p: mi.Point3d,
    d: mi.Vector3d,
    n: mi.Vector3d,
    offset: mi.Float64,
    *,
    entering: bool = False,
) -> tuple[mi.Point3d, mi.Vector3d]:
    """Return where the ray p + t d meets the surface, and the outward normal there."""
    is_wall = _is_wall(n)
    on_plane = (offset - dr.dot(n, p)) / dr.dot(n, d)
    # A round girdle is the cylinder of radius `offset`, entered through the nearer root and left through
    # the farther one.
    a = dr.square(d.x) + dr.square(d.y)
    b = p.x * d.x + p.y * d.y
    c = dr.square(p.x) + dr.square(p.y) - dr.square(offset)
    root = dr.safe_sqrt(dr.square(b) - a * c)
    on_wall = (-b - root if entering else -b + root) / a
    q = p + dr.select(is_wall, on_wall, on_plane) * d
    return q, dr.select(is_wall, _radial(q), n)


def _is_wall(n: mi.Vector3d) -> mi.Bool:
    """Whether a face belongs to a round girdle: what it carries as a plane's normal is 0."""
    return dr.squared_norm(n) < 0.5


def _radial(q: mi.Point3d) -> mi.Vector3d:
    """Return the unit vector away from the stone's axis."""
    return mi.Vector3d(q.x, q.y, 0) * dr.rsqrt(dr.square(q.x) + dr.square(q.y))
