"""Better faceters' designs: tiers varied with meets kept or loose; known answers, and their files."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gemrender
from gemrender.cli.program import app, run
from gemrender.cuts import load_stone
from gemrender.cuts.design import Design, Tier
from gemrender.cuts.meets import KEPT, Meets
from gemrender.cuts.stone_file import save_stone_file, stone_file_text
from gemrender.errors import InputError
from gemrender.sweep.improve import improve
from gemrender.sweep.improve.ranges import ranges_of
from gemrender.sweep.improve.rough import Box
from gemrender.sweep.improve.varied import angles_that_followed, remaker, varied_figures

CASES = Path(__file__).parents[1] / "cases" / "stones"
ROUND = load_stone(CASES / "round.asc")
#: Sums taken in another order [%].
ROUNDING = 1e-9
#: A grid of two angles, whose every stone can be measured.
SMALL = ("1 angle=42.4:43.6:0.4", "A angle=33:35:1")


def simple(material=1.54) -> gemrender.Stone:
    """A square with four pavilion facets that meet in a point, four of the crown, and a table."""
    return Design(
        tiers=(
            Tier(angle_deg=-90.0, distance=1.0, indices=(96, 24, 48, 72)),
            Tier(angle_deg=-42.0, distance=0.7, indices=(96, 24, 48, 72)),
            Tier(angle_deg=35.0, distance=0.75, indices=(96, 24, 48, 72)),
            Tier(angle_deg=0.0, distance=0.5, indices=(96,)),
        )
    ).stone(name="simple", material=material)


def test_the_figures_of_a_design_are_its_tiers():
    """Angles from the girdle plane, distances in per cent of half the length."""
    figures = varied_figures(simple())
    assert figures == pytest.approx({
        "G1 distance": 100.0, "P1 angle": 42.0, "P1 distance": 70.0, "C1 angle": 35.0, "C1 distance": 75.0,
        "T distance": 50.0,
    })  # fmt: skip


def test_ranges_of_tiers():
    p1, c1, t = ranges_of(simple(), ["P1  angle=40:43:0.5", "C1 angle", "T distance"])
    assert (p1.name, p1.low, p1.high, p1.step) == ("P1 angle", 40.0, 43.0, 0.5)
    assert (c1.low, c1.high, c1.step) == pytest.approx((32.0, 38.0, 0.1))
    assert (t.low, t.high, t.step) == pytest.approx((45.0, 55.0, 0.5))
    (as_written,) = ranges_of(simple(), ["P1 angle=-43:-40"])  # as .asc files write pavilions
    assert (as_written.low, as_written.high) == pytest.approx((40.0, 43.0))


def test_letters_of_tiers_keep_their_case():
    """Pavilion and crown of this one differ by nothing else; of proportions case does not count."""
    assert ranges_of(ROUND, ["A angle"])[0].name == "A angle"
    with pytest.raises(
        InputError, match=r"vary = 'a angle': unknown parameter; must be one of .*did you mean"
    ):
        ranges_of(ROUND, ["a angle"])


@pytest.mark.parametrize(
    ("chosen", "said"),
    [
        ("P1", "vary = 'P1': unknown parameter; must be one of G1 distance, P1 angle, "),
        ("P9 angle", "vary = 'P9 angle': unknown parameter"),
        ("T angle", "vary = 'T angle': unknown parameter"),
        ("P1 angle=91:95", "must have a range within 0.1 to 89.9"),
        ("P1 angle=43:40", "must have a range within"),
        ("P1 angle=40", "must be P1 angle=LOW:HIGH or"),
    ],
)
def test_what_is_no_range_of_a_tier_is_told(chosen, said):
    with pytest.raises(InputError, match=said) as caught:
        ranges_of(simple(), [chosen])
    assert "\n" not in str(caught.value)


def test_angles_are_lawful_and_meets_are_kept():
    remade = remaker(ROUND)({"1 angle": 43.1, "A angle": 33.0})
    tiers = dict(zip(remade.cut.tier_names(), remade.cut.tiers, strict=True))
    assert [tiers[name].angle_deg for name in ("1", "2", "A", "B", "C")] == [-43.1, -41.5, 33.0, 28.0, 16.0]
    assert {len(at) for at in Meets(remade.cut).corners} == {len(at) for at in Meets(ROUND.cut).corners}
    assert remade.cut.tiers[0].distance == pytest.approx(ROUND.cut.tiers[0].distance, abs=KEPT)


def test_loose_tiers_move_alone():
    remade = remaker(ROUND, "loose")({"1 angle": 43.1})
    for old, new in zip(ROUND.cut.tiers, remade.cut.tiers, strict=True):
        assert (old == new) == (old.angle_deg != -42.5)


def test_a_tier_that_is_cut_away_is_told():
    with pytest.raises(InputError, match="C1 distance: cuts G1, T away"):
        remaker(simple(), "loose")({"C1 distance": 20.0})


def test_stones_without_tiers_have_no_meets():
    with pytest.raises(InputError, match="meets = 'kept': only designs of tiers have meets"):
        remaker(load_stone("gia-excellent"), "kept")


def test_the_best_of_a_grid_of_two_angles_is_found():
    """Its every stone made and measured by itself."""
    ranges, meets = ranges_of(ROUND, SMALL), Meets(ROUND.cut)
    names = meets.design.tier_names()
    scores = {}
    for one, crown in itertools.product((42.4, 42.8, 43.2, 43.6), (33.0, 34.0, 35.0)):
        angles = {(names.index("1"), "angle_deg"): -one, (names.index("A"), "angle_deg"): crown}
        stone = meets.changed(angles).stone(material=1.54)
        scores[one, crown] = gemrender.score(stone, bound=0.1).average
    found = improve(ROUND, "inoue", ranges, seed=1, rounds=6, details=False)
    best = max(scores, key=scores.__getitem__)
    assert tuple(found.answers[0].values.values()) == best
    assert found.answers[0].goal == pytest.approx(scores[best], abs=ROUNDING)
    assert found.answers[0].goal > found.start.goal
    assert found.tried <= 12


@pytest.mark.parametrize("stone", [ROUND, simple("sapphire"), load_stone(CASES / "slab-chiral.asc")])
def test_the_files_of_a_design_are_the_stone(tmp_path, stone):
    save_stone_file(stone, tmp_path / "s.toml", comments=("found",))
    back = load_stone(tmp_path / "s.toml")
    assert (back.name, back.material) == (stone.name, stone.material)
    np.testing.assert_allclose(back.solid.planes, stone.solid.planes, atol=1e-14)
    assert [tier.indices for tier in back.cut.tiers] == [tier.indices for tier in stone.cut.tiers]
    assert back.facet_names == stone.facet_names


def test_a_design_has_no_stone_file_by_itself():
    with pytest.raises(InputError, match="was made neither from proportions nor of a family"):
        stone_file_text(ROUND)


def test_another_material_is_searched_with_and_kept():
    """Of a square with steeper facets less light leaks out of quartz than of the flat ones for sapphire."""
    ranges = ["P1 angle=38:44:2"]
    quartz, sapphire = (
        improve(simple(material), "inoue", ranges, rounds=2, answers=1, details=False).answers[0]
        for material in ("quartz", "sapphire")
    )
    assert (quartz.stone.material, sapphire.stone.material) == ("quartz", "sapphire")
    for answer in (quartz, sapphire):
        others = {
            angle: gemrender.score(remaker(answer.stone)({"P1 angle": angle}), bound=0.1).average
            for angle in (38.0, 40.0, 42.0, 44.0)
        }
        assert answer.values["P1 angle"] == max(others, key=others.__getitem__)


def test_the_angles_that_follow_can_be_kept_within_limits():
    """Over a rectangle both angles go together: one of them has a range, the other is kept."""
    stone = Design(
        tiers=(
            Tier(angle_deg=-90.0, distance=1.25, indices=(24, 72), names=("GL",)),
            Tier(angle_deg=-90.0, distance=1.0, indices=(96, 48), names=("GW",)),
            Tier(angle_deg=0.0, distance=0.4, indices=(96,)),
            *(
                Tier(
                    angle_deg=-float(np.degrees(np.arctan2(1.0, half))),
                    distance=float(half / np.hypot(1.0, half)),
                    indices=indices, names=(name,),
                )
                for name, half, indices in (("PL", 1.25, (24, 72)), ("PW", 1.0, (96, 48)))
            ),
        )
    ).stone(name="rectangle", material=1.77)  # fmt: skip
    followed = angles_that_followed(stone, remaker(stone)({"PL angle": 40.0}), {"PL angle": 40.0})
    other = np.degrees(np.arctan(1.25 * np.tan(np.radians(40.0))))
    assert followed == (f"PW angle follows: 45 to {other:.6g}",)
    found = improve(
        stone, "volume", ["PL angle=34:44:1"], keep={"PW angle": (40.0, 46.0)}, rounds=3, details=False
    )
    figures = varied_figures(found.answers[0].stone)
    assert figures["PL angle"] == 39.0  # tan 46 / 1.25 is tan 39.6: deeper is larger
    assert np.tan(np.radians(figures["PW angle"])) == pytest.approx(1.25 * np.tan(np.radians(39.0)), abs=1e-9)


def test_the_answers_have_the_size_that_rough_gives():
    """A square of 8 by 8 millimetres; deeper is heavier as far as the box is high."""
    rough = Box((9.0, 8.0, 20.0))
    found = improve(
        simple("quartz"), "carat", ["P1 angle=38:44:1"], rough=rough, rounds=2, answers=1, details=False
    )
    (answer,) = found.answers
    assert answer.values["P1 angle"] == 44.0
    assert answer.stone.size_mm == pytest.approx(8.0)
    assert answer.goal == pytest.approx(answer.stone.solid.volume * 64 * 2.65 / 200)


COMMAND = [
    "improve", str(CASES / "round.asc"), "--goal", "inoue", "--rounds", "2", "--answers", "1",
    "--reach", "0.1",
]  # fmt: skip


def test_the_command_retargets_a_design(monkeypatch):
    monkeypatch.setattr("gemrender.sweep.cliffs.STEPS", 3)  # looked for in a few steps
    result = CliRunner().invoke(app, [*COMMAND, "--vary", SMALL[0], "--material", "quartz", "--json"])
    assert result.exit_code == 0, result.output
    (found,) = json.loads(result.stdout)
    assert found["answers"][0]["goal"] >= found["start"]["goal"]
    values = found["answers"][0]["values"]
    assert set(values) == {"1 angle"}
    made = remaker(replace(ROUND, material="quartz"))(values)
    assert gemrender.score(made, bound=0.1).average == pytest.approx(
        found["answers"][0]["goal"], abs=ROUNDING
    )


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--vary", "P1 angle"], "vary = 'P1 angle': unknown parameter"),
        (["--vary", "1 angle", "--meets", "tight"], "--meets = 'tight': must be one of kept, loose"),
        (["--vary", "1 angle", "--rough", "box=1x1"], "rough = 'box=1x1': must be box=LENGTHxWIDTHxHEIGHT"),
        (["--vary", "1 angle", "--keep", "Z angle=3:4"], "keep = 'Z angle': unknown key"),
        (["--vary", "1 angle=41:41.4:0.1"], "vary: no stone within these ranges can be made"),
    ],
)
def test_what_is_wrong_is_one_line(options, said, capfd):
    assert run([*COMMAND, *options]) == 2
    printed = capfd.readouterr().err.strip().splitlines()
    assert len(printed) == 1
    assert said in printed[0]
