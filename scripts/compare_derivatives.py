"""Compare derivatives of every measure by every parameter with central differences of the scores.

    python scripts/compare_derivatives.py [--stones 20] [--seed 1] [--least 1e-4] [--parameters N]

Random stones of five cuts in turn: round brilliants, emeralds, princesses, ovals, and a faceter's design
whose tiers are moved a little; in diamond, sapphire, quartz and others. Each is differentiated by every
parameter, and made anew with the parameter a step smaller and larger. All light is followed to the same least
share of the view: values are sums over polygons, and `left` is the light that is left to rays, which has a
derivative of its own (what rays find in it has a bound instead, and measures over all views are differences
of rays already).

Derivatives are off by no more than 1e-5 of themselves, or of 1 % per unit where they are smaller. The step
with the smallest difference counts. Where the virtual facets, or the zones and bands that they are in, are
not the same ones on both sides of every step, scores jump or bend between them: such places are named,
and count for nothing. The exit status is 1 if one of the others is off by more.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gemrender.beam import beam_stone
from gemrender.beam.by_parameters import changes_of
from gemrender.beam.by_proportions import PROPORTIONS, by_angles, proportion_planes
from gemrender.beam.by_tiers import design_unit, parameters_of_stone, tier_planes
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import smooth_values
from gemrender.beam.polygons import Traced
from gemrender.beam.sensitivity import smooth_measures
from gemrender.beam.totals import channel_sums, facet_sides, trace_planes
from gemrender.cuts import load_stone
from gemrender.cuts.design import Design
from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.cuts.random import random_brilliant, random_member
from gemrender.errors import InputError
from gemrender.measures import Light, Measure, contributions
from gemrender.measures.evaluate import light_of
from gemrender.measures.tally import Tally
from gemrender.observation import Model, RayStatus, View
from gemrender.optics.fresnel import transmittance
from gemrender.paths import Paths
from gemrender.stone import Stone
from gemrender.sweep.cliffs import parameters_of

DESIGNS = Path(__file__).parents[1] / "tests" / "cases" / "stones"
CUTS = ("round brilliant", "emerald", "princess", "oval", "square-barion.asc")
MATERIALS = ("diamond", "sapphire", "quartz", "spinel", "cubic zirconia")
#: Steps of central differences [% or deg; of ratios a hundredth]: of large ones the third order is off, of
#: small ones rounding.
STEPS = (1e-6, 1e-7, 1e-5, 1e-8)
#: Allowed difference, of the larger of the derivative and 1 % per unit.
ALLOWED = 1e-5


class Left(Measure):
    """Light that polygons leave to rays [% of the light at the eye]."""

    name, version, smooth_keys, is_axial = "left", 1, ("value",), True

    def contributions(self, light: Light) -> np.ndarray:
        """Return the share of the light that is in cells of what has been reflected in part, (n,)."""
        paths = light.paths
        is_left = (paths.status == RayStatus.MISSED) & (paths.partial_reflections > 0)
        share = paths.weight * transmittance(paths.cos_entry, light.model.index)
        return np.where(is_left, share, 0.0)


@dataclass(frozen=True)
class Moving:
    """A parameter: planes with their derivatives by it, a factor, the stone with it changed, and a step."""

    name: str
    planes: np.ndarray
    scale: float
    moved: Callable[[float], Stone]
    step: float


@dataclass(frozen=True)
class Difference:
    """How far a derivative is off, and of which value; whether it lies between jumps."""

    stone: str
    parameter: str
    value: str
    slope: float
    error: float
    is_smooth: bool


def random_stones(number: int, seed: int) -> Iterator[Stone]:
    """Yield so many stones, of five cuts in turn."""
    rng = np.random.default_rng(seed)
    for k in range(number):
        cut, material = CUTS[k % len(CUTS)], MATERIALS[(k + k // len(CUTS)) % len(MATERIALS)]
        name = f"{cut} {k // len(CUTS) + 1} of {material}"
        if cut == CUTS[0]:
            yield Stone.from_proportions(random_brilliant(rng), name=name, material=material)
        elif cut.endswith(".asc"):
            yield replace(_design(load_stone(DESIGNS / cut), rng), name=name, material=material)
        else:
            yield replace(random_member(families()[cut], rng).stone(), name=name, material=material)


def _design(stone: Stone, rng: np.random.Generator) -> Stone:
    """Return a design with its tiers moved at random, by half a degree and half a per cent or so."""
    design = stone.cut
    assert isinstance(design, Design)
    for k, tier in enumerate(design.tiers):
        is_facet = 0.0 < abs(tier.angle_deg) < 90.0
        design = design.with_tier(
            k,
            angle_deg=tier.angle_deg + is_facet * rng.normal(0.0, 0.5),
            distance=tier.distance * (1.0 + rng.normal(0.0, 0.005)),
        )
    return design.stone()


def moving(stone: Stone) -> list[Moving]:
    """Return every parameter that a stone is differentiated by, where there is room to either side."""
    cut = stone.cut
    found: list[tuple[np.ndarray, float]] = []
    if isinstance(cut, Design):
        unit = design_unit(stone, cut)
        for tier, quantity in parameters_of_stone(stone, cut):
            scale = 1.0 if quantity == "angle_deg" else 0.01 * unit
            found.append((tier_planes(stone, cut, tier, quantity), scale))
    elif isinstance(cut, Family):
        found = [(change.planes(cut), 1.0) for change in changes_of(cut)]
    else:
        by = {name: proportion_planes(stone.proportions, name) for name in PROPORTIONS}
        found = [(planes, 1.0) for planes in by.values()]
        real = found[0][0].real
        for _, chain in by_angles(stone.proportions).values():
            found.append((real + 1j * sum(part * by[name].imag for name, part in chain.items()), 1.0))
    out = []
    for of, (planes, scale) in zip(parameters_of(stone), found, strict=True):
        step = 0.01 if of.unit == "" else 1.0
        try:
            of.moved(-max(STEPS) * step), of.moved(max(STEPS) * step)
        except InputError:  # at the end of its range, such as a culet that there is none of
            continue
        out.append(Moving(f"{of.name} ({of.kept} kept)", planes, scale, of.moved, step))
    return out


class Compared:
    """A stone, and how its values are compared.

    Parameters
    ----------
    stone : Stone
        The stone.
    least : float
        Share of the view down to which all light is followed.
    model : Model, optional
        The optical model; by default that of its material.
    """

    def __init__(self, stone: Stone, least: float, model: Model | None = None) -> None:
        self.stone, self._convex, self._least = stone, beam_stone(stone), least
        model = model or Model.of(stone, fresnel="exact")
        self._whole = isinstance(stone.cut, Design)
        if self._whole:
            model = replace(model, rear="facet")  # the girdle's edge does not stay level
        one_view = [of for of in smooth_measures("all") if of.views == "one"]
        self._tally = Tally(View(resolution=1), model, [*one_view, Left()])
        self._names = [f"{of.name} {key}" for of in self._tally.measures for key in of.smooth_keys]

    def differences(self, of: Moving) -> list[Difference]:
        """Compare the derivatives of all values by a parameter."""
        sides = facet_sides(
            self._convex, of.planes, self._tally, whole=self._whole, least=self._least, walls_move=True
        )
        slopes = of.scale * np.mean([self._values(side.totals).imag for side in sides], axis=0) / STEP
        best, is_smooth = np.full(len(slopes), np.inf), False
        for step in STEPS:
            traced = [self._trace(of.moved(by * of.step * step)) for by in (-1, 1)]
            low, high = (self._values(channel_sums(self._tally, paths)) for _, paths in traced)
            quotient = (high - low) / (2.0 * of.step * step)
            best = np.fmin(best, np.abs(quotient - slopes) / np.maximum(1.0, np.abs(slopes)))
            if np.nanmax(best) <= ALLOWED:
                is_smooth = True
                break
            is_smooth |= len({self._topology(*each) for each in traced}) == 1 and len(sides) == 1
        return [
            Difference(self.stone.name, of.name, name, float(slope), float(error), is_smooth)
            for name, slope, error in zip(self._names, slopes, best, strict=True)
            if not np.isnan(slope)
        ]

    def _trace(self, stone: Stone) -> tuple[Traced, Paths]:
        if stone.facet_names != self.stone.facet_names:
            raise InputError("has other facets", source=stone.name)
        planes = np.array(stone.solid.planes)
        traced, paths, _ = trace_planes(
            self._convex, planes, self._tally, self._whole, self._least, walls_move=True
        )  # fmt: skip
        return traced, paths

    def _values(self, totals: np.ndarray) -> np.ndarray:
        return smooth_values(self._tally, totals[2] + totals[3], totals[4:])

    def _topology(self, traced: Traced, paths: Paths) -> int:
        """Return a number that tells virtual facets, and what each adds to, from others."""
        light = self._tally.light(paths)
        added = [contributions(of, light_of(of, light)) != 0.0 for of in self._tally.measures]
        parts = [traced.facts, traced.nodes, traced.ends, *added]
        return hash(tuple(part.tobytes() for part in parts))


def main() -> int:
    """Compare, print a line for each stone, and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stones", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--least", type=float, default=1e-4)
    parser.add_argument("--parameters", type=int, help="of each stone no more than so many, by default all")
    options = parser.parse_args()
    worst: list[Difference] = []
    for number, stone in enumerate(random_stones(options.stones, options.seed), start=1):
        compared, parameters = Compared(stone, options.least), moving(stone)[: options.parameters]
        found = []
        for done, of in enumerate(parameters, start=1):
            if sys.stderr.isatty():
                print(f"\r{number}/{options.stones} {done}/{len(parameters)} ", end="", file=sys.stderr)
            found += compared.differences(of)
        smooth = [of for of in found if of.is_smooth]
        jumps = {of.parameter for of in found if not of.is_smooth and of.error > ALLOWED}
        largest = max(smooth, key=lambda of: of.error, default=None)
        worst += [largest] if largest is not None else []
        words = (
            "" if largest is None else f"worst {largest.error:.1e}: {largest.value} by {largest.parameter}"
        )
        print(f"{stone.name}: {len(parameters)} parameters, {len(smooth)} derivatives, {words}", flush=True)
        for name in sorted(jumps):
            print(f"  jumps within every step: {name}", flush=True)
    last = max(worst, key=lambda of: of.error)
    print(
        f"worst of all: {last.error:.1e} of max(1, |slope|), {last.stone}, {last.value} by {last.parameter}: "
        f"{last.slope:.6g} per unit; allowed {ALLOWED:g}"
    )
    return int(last.error > ALLOWED)


if __name__ == "__main__":
    sys.exit(main())
