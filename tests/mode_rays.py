"""Rays in modes through a convex stone, by numpy and the reference's optics of crystals: no kernels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.optics.crystals import Indicatrix, enter, leave

#: Surfaces are met further along than this [girdle radius], not where the ray is.
NEXT = 1e-9
#: The critical angle, within rounding.
TOTAL = (1.0 - 1e-11) ** 2
#: A ray still inside after so many reflections is given up.
MOST = 1000


@dataclass
class Rays:
    """Rays, a row each: points, directions, wave vectors; modes, cross-sections, and what entered."""

    point: np.ndarray
    direction: np.ndarray
    k: np.ndarray
    mode: np.ndarray
    section: np.ndarray
    entering: np.ndarray

    def rows(self, chosen):
        return Rays(**{name: value[chosen] for name, value in vars(self).items()})


def dot(a, b):
    return np.sum(a * b, axis=-1)


def entries(stone, basis, places):
    """Return which places (n, 2) of a view meet the stone; where, and the normal there."""
    planes, d = stone.solid.planes, -basis[2]
    start = places @ basis[:2]
    slope, gap = planes[:, :3] @ d, planes[:, 3] - start @ planes[:, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        t = gap / slope
    inward = np.where(slope < 0, t, -np.inf)
    t_in, facet = inward.max(axis=1), inward.argmax(axis=1)
    t_out = np.where(slope > 0, t, np.inf).min(axis=1)
    meets = (t_in < t_out) & ~((slope == 0) & (gap < 0)).any(axis=1)
    point, normal = start + t_in[:, None] * d, planes[facet, :3].copy()
    if stone.is_round:
        outside = np.hypot(point[:, 0], point[:, 1]) > 1
        a, b, c = d[:2] @ d[:2], start[:, :2] @ d[:2], dot(start[:, :2], start[:, :2]) - 1
        if a > 0:
            root = b * b - a * c
            at = (-b - np.sqrt(np.maximum(root, 0))) / a
            side = outside & (root > 0) & (at > t_in) & (at < t_out)
            point[side] = (start + at[:, None] * d)[side]
            normal[side] = point[side] * [1, 1, 0]
            outside &= ~side
        meets &= ~outside
    return meets, point[meets], normal[meets]


def entered(normal, point, basis, crystal: Indicatrix):
    """Return rays of both modes (each n), and the share of each, (n, 2)."""
    d = -basis[2]
    into = enter(normal, np.broadcast_to(d, normal.shape), crystal)
    each = into.transmitted.mean(axis=-1)
    entering = each.sum(axis=-1)
    rays = [_wave(into, m, normal, np.broadcast_to(d, normal.shape)) for m in range(2)]
    made = [
        Rays(point, ray, k, np.full(len(k), m), -dot(ray, normal) / -dot(d, normal), entering)
        for m, (ray, k) in enumerate(rays)
    ]
    return made, each / entering[:, None]


def _wave(at, m, normal, tangential):
    """Return ray and wave vector of one of the waves that go back from a facet, in the stone's frame."""
    along = tangential - dot(tangential, normal)[:, None] * normal
    return np.einsum("nj,nji->ni", at.waves.ray[:, m], at.axes), along + at.waves.k[:, m, 2:].real * normal


def met(stone, rays):
    """Return the surface that each ray meets next, its normal, and where."""
    planes = stone.solid.planes
    slope = rays.direction @ planes[:, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (planes[:, 3] - rays.point @ planes[:, :3].T) / slope
    t = np.where(slope > 1e-12, t, np.inf)
    surface, far = t.argmin(axis=1), t.min(axis=1)
    normal = planes[surface, :3].copy()
    if stone.is_round:
        d, p = rays.direction[:, :2], rays.point[:, :2]
        a, b = dot(d, d), dot(p, d)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = (-b + np.sqrt(np.maximum(b * b - a * (dot(p, p) - 1), 0))) / a
        side = (a > 0) & (at < far)
        far, surface = np.where(side, at, far), np.where(side, len(planes), surface)
        where = p + far[:, None] * d
        normal[side] = np.column_stack([where, np.zeros(len(p))])[side]
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return surface, normal, rays.point + far[:, None] * rays.direction


@dataclass
class Met:
    """What becomes of rays at a surface: (n,) what leaves; (n, 2) what goes on; and those that do."""

    surface: np.ndarray
    leaving: np.ndarray
    back: np.ndarray
    goes_on: list[Rays]
    exit_direction: np.ndarray
    exit_section: np.ndarray


def meet(stone, rays, crystal):
    surface, normal, point = met(stone, rays)
    at = leave(normal, rays.k, crystal)
    rows = np.arange(len(surface))
    along = dot(rays.direction, normal)
    back = at.reflected[rows, :, rays.mode]
    k_t = rays.k - dot(rays.k, normal)[:, None] * normal
    square = dot(k_t, k_t)
    leaving = np.where(square < TOTAL, at.transmitted[rows, :, rays.mode].sum(axis=-1), 0.0)
    cos = np.sqrt(np.maximum(1 - square, 0))
    goes_on = []
    for m in range(2):
        ray, k = _wave(at, m, normal, rays.k)
        section = rays.section * -dot(ray, normal) / along
        goes_on.append(Rays(point, ray, k, np.full(len(k), m), section, rays.entering))
    return Met(
        surface, leaving, back, goes_on, k_t + cos[:, None] * normal, rays.section * cos / along
    ), point


def average_and_rear(stone, crystal, basis, n, rng, ground=1e-10):
    """Return Average and Rear of n random rays, rear light by position, and their standard errors [%]."""
    half = stone.reach
    side = int(np.sqrt(n))
    cells = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    places = ((cells + rng.random(cells.shape)) / side * 2 - 1) * half
    _, point, normal = entries(stone, basis, places)
    both, shares = entered(normal, point, basis, crystal)
    rays = _drawn(both, shares[:, 0], rng)
    intensity, rear, number = np.zeros(len(point)), np.zeros(len(point)), np.arange(len(point))
    for _ in range(MOST):
        found, point = meet(stone, rays, crystal)
        out = found.leaving > 0
        is_rear = point[:, 2] <= ground
        rear[number[out]] = is_rear[out]
        light = rays.entering * found.leaving * found.exit_section
        intensity[number[out]] = np.where(is_rear, 0.0, light)[out]
        inside = np.flatnonzero(~out)
        if not len(inside):
            break
        first = found.back[inside, 0] / found.back[inside].sum(axis=1)
        rays, number = _drawn([of.rows(inside) for of in found.goes_on], first, rng), number[inside]
    error = [100 * values.std() / np.sqrt(len(values)) for values in (intensity, rear)]
    return 100 * intensity.mean(), 100 * rear.mean(), *error


def _drawn(both, first, rng):
    """Return of rays of both modes one each, the first with a probability (n,)."""
    which = rng.random(len(first)) >= first
    pairs = zip(vars(both[0]).items(), vars(both[1]).values(), strict=True)
    return Rays(**{name: np.where(_as(which, a), b, a) for (name, a), b in pairs})


def _as(mask, values):
    return mask[:, None] if values.ndim == 2 else mask


def tree(stone, crystal, basis, place, least):
    """Follow all modes of a place (2,) of the view, down to a least share.

    Returns
    -------
    dict
        By the path, facets and modes: the share, the intensity, and the exit direction.
    """
    meets, point, normal = entries(stone, basis, np.array([place]))
    assert meets.all()
    both, shares = entered(normal, point, basis, crystal)
    entry = int(np.argmin(np.abs(stone.solid.planes @ [*point[0], -1.0])))
    waiting = [(both[m], float(shares[0, m]), [(entry, m)]) for m in range(2)]
    out = {}
    while waiting:
        ray, share, path = waiting.pop()
        if share < least:
            continue
        found, _ = meet(stone, ray, crystal)
        here = int(found.surface[0])
        if found.leaving[0] > 0:
            light = float(ray.entering[0] * found.leaving[0] * found.exit_section[0])
            out[(*path, (here, -1))] = (share, light, found.exit_direction[0])
            continue
        waiting += [(found.goes_on[m], share * float(found.back[0, m]), [*path, (here, m)]) for m in range(2)]
    return out
