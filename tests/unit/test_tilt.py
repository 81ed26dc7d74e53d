"""The tilt study: poses, symmetry, ties, the journal, and what is made of it."""

from __future__ import annotations

import csv
import io
import json
import math

import numpy as np
import pytest
from any_stones import design, hollow_stone

from gemrender import score
from gemrender.cli.program import run
from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.measures import Measure
from gemrender.observation import View
from gemrender.optics.fresnel import reflectance
from gemrender.report.tilt import tilt_figure, tilt_records, tilt_table, write_tilt_figure
from gemrender.report.tilt_film import write_tilt_film
from gemrender.stone.symmetry import NONE
from gemrender.sweep import study_tilt
from gemrender.sweep.poses import Pose, alike, tilt_poses
from gemrender.sweep.tilt import tilt_measures
from tests.any_stones import FOLDER
from tests.observations import run_python

ROUND = load_stone("inoue-3")
EMERALD, PEAR = design("emerald"), design("pear")
TRUTH = json.loads((FOLDER / "truth.json").read_text())
#: Values of polygons [%]: the same but for rounding, multiplied near the critical angle.
SAME = 1e-6
#: Shares of a film's frame: its edges between zones are a pixel wide, and mixed with what leaks.
FRAME = 0.03


def turned(study, measure="inoue", key="average"):
    """Return a value by turn, of a study about one axis."""
    assert len(study.curves()) == 1
    return {found.pose.turn_deg: found.value(measure, key) for found in study.found}


# ---- Poses ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axis", "turn"), [(0.0, 20.0), (0.0, -20.0), (90.0, 20.0), (30.0, -7.0), (0.0, 0.0)]
)
def test_a_pose_is_a_right_handed_turn_of_the_stone(axis, turn):
    """The eye sees the table's normal where Rodrigues' formula turns it to."""
    tilt, azimuth = Pose(axis_deg=axis, turn_deg=turn).eye
    eye = View(resolution=1, tilt_deg=tilt, tilt_azimuth_deg=azimuth).basis()[2]
    about, angle = np.radians([axis, turn])
    k, z = np.array([np.cos(about), np.sin(about), 0.0]), np.array([0.0, 0.0, 1.0])
    back = z * np.cos(angle) - np.cross(k, z) * np.sin(angle)  # the eye, turned back into the stone's frame
    assert eye == pytest.approx(back, abs=1e-14)


def test_turns_are_multiples_of_the_step():
    turns = [pose.turn_deg for pose in tilt_poses("x", 0.35, 0.1, NONE)]
    assert turns == [-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3]
    assert {pose.axis_deg for pose in tilt_poses("both", 2.0, 1.0, NONE)} == {0.0, 90.0}


@pytest.mark.parametrize("stone", [ROUND, EMERALD, PEAR, design("slab-chiral")], ids=lambda stone: stone.name)
def test_rings_of_a_surface_fall_on_their_images(stone):
    poses = tilt_poses("surface", 4.0, 2.0, stone.symmetry)
    ring = [pose for pose in poses if pose.turn_deg == 4.0]
    images = stone.symmetry.fold * (2 if len(stone.symmetry.mirrors) else 1)
    assert len({alike(stone.symmetry, pose) for pose in ring}) <= len(ring) // images + 1
    assert {0.0, 90.0, 180.0, 270.0} <= {pose.eye[1] for pose in ring}


def test_poses_are_alike_by_the_stones_own_symmetry_alone():
    here, there = (Pose(axis_deg=0.0, turn_deg=turn) for turn in (12.0, -12.0))
    is_alike = {
        stone.name: alike(stone.symmetry, here) == alike(stone.symmetry, there)
        for stone in (ROUND, EMERALD, PEAR, design("slab-chiral"))
    }
    # The pear's mirror plane is that of x and z: it has a point, and a round end, along y.
    assert is_alike == {ROUND.name: True, "emerald": True, "pear": False, "slab-chiral": False}


# ---- Values --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["heart", "pear"])
def test_a_turn_about_x_has_the_true_values_of_its_own_sign(name):
    stone, truth = load_stone(str(FOLDER / f"{name}.asc")), TRUTH[name]["tilt_15_deg_about_x"]
    study = study_tilt(stone, measures="inoue,gemray-iso", to_deg=15.0, step_deg=15.0, bound=0.5)
    bound = study.found[-1].bound("gemray-iso") + TRUTH[name]["bounds"]["gemray"]
    assert turned(study, "gemray-iso", "value")[15.0] == pytest.approx(truth["iso_gemray"], abs=bound)
    principal = TRUTH[name]["bounds"]["principal"] + study.found[-1].bound("inoue")
    assert turned(study, key="rear")[15.0] == pytest.approx(truth["rear_by_facet"], abs=principal)
    assert abs(turned(study, "gemray-iso", "value")[-15.0] - truth["iso_gemray"]) > 3.0


def test_upright_it_is_the_score():
    study = study_tilt(EMERALD, measures="inoue,iso,facets", to_deg=2.0, step_deg=2.0)
    scored = score(EMERALD, measures="inoue,iso,facets", bound=0.1)
    upright = next(found for found in study.found if found.pose.turn_deg == 0)
    assert [of.to_dict() for of in upright.measures] == [of.to_dict() for of in scored.measures]


def test_what_symmetry_tells_is_what_is_traced():
    study = study_tilt(ROUND, measures="inoue,iso", to_deg=20.0, step_deg=20.0, bound=0.5)
    scored = score(ROUND, measures="inoue,iso", tilt=20.0, tilt_azimuth=270.0, bound=0.1)
    for measure, key in (("inoue", "average"), ("inoue", "rear"), ("iso", "value")):
        by_turn = turned(study, measure, key)
        [of] = [of for of in scored.measures if of.name == measure]
        assert by_turn[-20.0] == by_turn[20.0]
        assert by_turn[-20.0] == pytest.approx(of.values[key], abs=study.found[0].bound(measure) + of.bound)


class Upwards(Measure):
    """Principal light that goes up in the stone's y: no rotation about the eye leaves it as it is."""

    name, definition, source, follow = "upwards", "share of exits with y > 0", "this test", "principal"

    def contributions(self, light):
        return light.is_exit * (light.paths.exit_direction[:, 1] > 0)


def test_a_measure_that_tells_symmetric_poses_apart_is_traced_in_each():
    study = study_tilt(EMERALD, measures=[Upwards()], to_deg=10.0, step_deg=10.0)
    by_turn = turned(study, "upwards", "value")
    assert by_turn[-10.0] + by_turn[10.0] == pytest.approx(100.0, abs=SAME)
    assert abs(by_turn[10.0] - 50.0) > 1.0


def test_a_surface_holds_the_curves():
    surface = study_tilt(PEAR, axis="surface", to_deg=4.0, step_deg=4.0)
    curves = study_tilt(PEAR, axis="both", to_deg=4.0, step_deg=4.0)
    at = {found.pose.eye: found.value("inoue", "average") for found in surface.found}
    for found in curves.found:
        assert at[found.pose.eye] == pytest.approx(found.value("inoue", "average"), abs=SAME)


def test_a_tied_pose_is_named_with_what_is_tied():
    """At a tilt of half the head's angle the table mirrors the edge of the head."""
    study = study_tilt(EMERALD, measures="iso", to_deg=6.0, step_deg=1.0)
    eye = View(resolution=1, tilt_deg=5.0, tilt_azimuth_deg=90.0).basis()[2]
    facing = np.maximum(EMERALD.solid.planes[:, :3] @ eye, 0.0)
    areas = EMERALD.solid.polyhedron.areas[: len(facing)] * facing
    table = areas[EMERALD.facet_names.index("T")] / areas.sum()
    amount = 100.0 * table * float(reflectance(np.cos(np.radians(5.0)), EMERALD.material))
    ties = {tie.pose.turn_deg: tie.amount for tie in study.ties() if abs(tie.pose.turn_deg) == 5.0}
    assert ties == pytest.approx({-5.0: amount, 5.0: amount}, abs=SAME)
    assert not {tie.pose.turn_deg for tie in study.ties()} & {-3.0, 0.0, 3.0}
    words = " ".join(note.text for note in tilt_table([study]).notes)
    assert f"{amount:.2g} about x by -5, " in words


def test_another_engine_knows_no_bound():
    options = {"engine": "reference", "resolution": 8}
    study = study_tilt(hollow_stone(), to_deg=20.0, step_deg=20.0, **options, processes=2)
    assert [math.isnan(found.bound("inoue")) for found in study.found] == [True] * 3
    assert study.to_dict()["poses"][0]["measures"]["inoue"]["bound"] is None
    alone = score(hollow_stone(), measures="inoue", tilt=20.0, tilt_azimuth=90.0, **options)
    assert turned(study)[20.0] == alone.measures[0].values["average"]


def test_threads_begin_when_kernels_are_there():
    """Of a process's first kernel numba makes the types without a lock."""
    code = (
        "from gemrender import load_stone; from gemrender.sweep import study_tilt;"
        "study_tilt(load_stone('inoue-3'), measures='iso', to_deg=7, bound=1.0, processes=8)"
    )
    done = run_python("-c", code)
    assert (done.returncode, done.stderr) == (0, "")


def test_what_an_engine_does_not_tell_is_not_defined():
    """Only the exact engine knows virtual facets."""
    options = {"engine": "reference", "resolution": 4}
    study = study_tilt(EMERALD, measures="facets", to_deg=2.0, step_deg=2.0, **options, processes=1)
    assert np.isnan(study.values("facets", "number")).all()
    assert tilt_table([study]).rows[0][3:] == ["–"] * 7
    assert tilt_figure(study).axes[0].texts[0].get_text() == "not defined for this stone"


# ---- Refusals ------------------------------------------------------------------------------------------


def test_all_measures_are_those_with_a_tilt():
    names = [of.name for of in tilt_measures("all")]
    assert "wlr-like" not in names
    assert {"inoue", "iso", "aset", "facets"} <= set(names)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"measures": "wlr-like"}, "measures = 'wlr-like': wlr-like is a sum over all views and has no tilt"),
        ({"axis": "z"}, "axis = 'z': must be one of x, y, both, surface, or the azimuth of an axis [deg]"),
        ({"axis": True}, "axis = True: must be one of"),
        ({"to_deg": 90.0}, "to = 90.0: must be above 0 and below 90 [deg]"),
        ({"to_deg": math.nan}, "to = nan: must be above 0"),
        ({"step_deg": 31.0}, "step = 31.0: must be above 0, and 30 at the most [deg]"),
        ({"step_deg": 1e-4}, "step = 0.0001: makes more than 100000 poses; must be larger, or --to smaller"),
        ({"head": 90.0}, "head = 90.0: must be from 0 to below 90 [deg]"),
    ],
)
def test_a_wrong_value_is_refused(wrong, said):
    with pytest.raises(InputError) as refused:
        study_tilt(EMERALD, **wrong)
    assert str(refused.value).startswith(said)


# ---- The journal ---------------------------------------------------------------------------------------

#: A study with values that are not defined, numbers that are no sums, and notes to keep.
KEPT = {"measures": "inoue,gemray-iso,dispersion,facets", "to_deg": 6.0, "step_deg": 2.0}


def lines(journal):
    return journal.read_text().splitlines()


def test_an_interrupted_study_goes_on_to_the_same_end(tmp_path):
    journal, whole = tmp_path / "tilt.jsonl", study_tilt(PEAR, **KEPT)

    def interrupt(share):
        if share > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        study_tilt(PEAR, **KEPT, journal=journal, progress=interrupt)
    done = lines(journal)
    assert 1 < len(done) < 8
    with journal.open("a") as file:
        file.write("[0.0, 6")  # stopped while writing
    assert study_tilt(PEAR, **KEPT, journal=journal).to_dict() == whole.to_dict()
    assert lines(journal)[: len(done)] == done
    assert len(lines(journal)) == 8, "the head, and each of seven poses once"


def test_a_journal_serves_other_poses_and_symmetric_ones(tmp_path):
    journal = tmp_path / "tilt.jsonl"
    study_tilt(EMERALD, to_deg=4.0, step_deg=2.0, journal=journal)
    assert len(lines(journal)) == 1 + 3
    study_tilt(EMERALD, to_deg=4.0, step_deg=1.0, axis=180.0, journal=journal)
    assert len(lines(journal)) == 1 + 5


def test_the_journal_of_another_study_is_refused(tmp_path):
    journal = tmp_path / "tilt.jsonl"
    small = {"to_deg": 2.0, "step_deg": 2.0, "journal": journal}
    study_tilt(EMERALD, **small)
    for stone, other in ((PEAR, {}), (EMERALD, {"head": 5.0}), (EMERALD, {"bound": 0.2})):
        with pytest.raises(InputError, match="is the journal of another study"):
            study_tilt(stone, **small, **other)


@pytest.mark.parametrize(
    "line",
    [
        [0.0, 90.0, [[[1.0], 0.1, {}]], []],
        [0.0, "5", [[[1.0], 0.1, {}]], []],
        [0.0, 5.0, [], []],
        [0.0, 5.0, [[[1.0, 2.0], 0.1, {}]], []],
        [0.0, 5.0, [[["1"], 0.1, {}]], []],
        [0.0, 5.0, [[[1.0], 0.1, {"colour": 1}]], []],
        [0.0, 5.0, [[[1.0], 0.1, []]], []],
        [0.0, 5.0, [[[1.0], 0.1, {}]], "note"],
        [0.0, 5.0, [[1.0]]],
        {},
        5,
    ],
)
def test_a_line_that_is_no_poses_is_left_out(line, tmp_path, caplog):
    journal = tmp_path / "tilt.jsonl"
    small = {"measures": "window", "to_deg": 2.0, "step_deg": 2.0, "journal": journal}
    whole, text = study_tilt(EMERALD, **small), journal.read_text()
    journal.write_text(f"{text}{json.dumps(line)}\n")
    assert study_tilt(EMERALD, **small).to_dict() == whole.to_dict()
    assert "a line that is no entry is left out" in caplog.text
    assert journal.read_text() == text


# ---- What is made of it --------------------------------------------------------------------------------


def test_records_have_every_value_pose_by_pose():
    study = study_tilt(EMERALD, measures="inoue,iso", to_deg=2.0, step_deg=1.0)
    records = tilt_records(study)
    assert [record["turn_deg"] for record in records] == [-2.0, -1.0, 0.0, 1.0, 2.0]
    assert records[0]["iso"] == study.values("iso", "value")[0]
    assert records[0]["inoue_rear"] == study.values("inoue", "rear")[0]
    assert {"name", "axis_deg", "tilt_deg", "tilt_azimuth_deg", "iso_bound", "iso_tied"} <= set(records[0])


def test_the_table_tells_the_extremes_and_where_they_are():
    study = study_tilt(PEAR, axis="both", to_deg=10.0, step_deg=5.0)
    about_x = study.curves()[0.0]
    values = [found.value("inoue", "average") for found in about_x]
    row = tilt_table([study]).rows[0]
    assert row[:4] == ["pear", "x", "inoue average", f"{values[2]:.2f}"]
    assert row[4:8] == [
        f"{min(values):.2f}",
        f"{about_x[int(np.argmin(values))].pose.turn_deg:g}",
        f"{max(values):.2f}",
        f"{about_x[int(np.argmax(values))].pose.turn_deg:g}",
    ]
    assert row[8] == f"{np.mean(values):.2f}"


def test_the_mean_of_a_surface_is_by_solid_angle():
    study = study_tilt(EMERALD, axis="surface", to_deg=6.0, step_deg=3.0)
    rings = {tilt: [] for tilt in (0.0, 3.0, 6.0)}
    for found in study.found:
        rings[found.pose.eye[0]].append(found.value("inoue", "average"))
    weights = np.sin(np.radians(list(rings)))
    mean = np.average([np.mean(ring) for ring in rings.values()], weights=weights)
    assert tilt_table([study]).rows[0][8] == f"{mean:.2f}"


def test_curves_are_drawn_with_their_values_bounds_and_ties(tmp_path):
    study = study_tilt(EMERALD, measures="iso,dispersion", to_deg=6.0, step_deg=1.0)
    figure = tilt_figure(study)
    iso, dispersion = figure.axes
    curve, rings = iso.lines[0], iso.lines[1]
    assert curve.get_ydata() == pytest.approx(study.values("iso", "value"))
    assert set(rings.get_xdata()) == {tie.pose.turn_deg for tie in study.ties()}
    assert [text.get_text() for text in dispersion.texts] == ["not defined for this stone"]
    assert write_tilt_figure(study, tmp_path / "tilt.png").read_bytes().startswith(b"\x89PNG")


def test_a_polar_map_has_each_value_where_it_was_found():
    study = study_tilt(PEAR, axis="surface", to_deg=6.0, step_deg=3.0)
    axes = tilt_figure(study).axes[0]
    [mesh] = axes.collections
    places = mesh.get_coordinates().reshape(-1, 2)
    drawn = {
        (round(math.degrees(azimuth)) % 360, round(tilt)): value
        for (azimuth, tilt), value in zip(places, np.asarray(mesh.get_array()).ravel(), strict=True)
        if abs(math.degrees(azimuth) / 15 - round(math.degrees(azimuth) / 15)) < 1e-9
    }
    for found in study.found:
        tilt, azimuth = found.pose.eye
        if azimuth % 15 == 0:
            assert drawn[round(azimuth), round(tilt)] == pytest.approx(found.value("inoue", "average"))


def test_a_film_goes_to_and_fro(tmp_path):
    from PIL import Image

    study = study_tilt(EMERALD, measures="aset", to_deg=20.0, step_deg=20.0)
    path = write_tilt_film(study, EMERALD, tmp_path / "tilt.webp")
    frames = []
    with Image.open(path) as film:
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), dtype=float)[:, :540])  # the map
    assert len(frames) == 4  # upright, one side, upright, the other
    assert np.abs(frames[0] - frames[2]).mean() < 3.0 < np.abs(frames[0] - frames[1]).mean()
    for frame, found in zip(frames, study.found[1:], strict=False):  # zones by their strongest colour
        inside = frame[60:][np.ptp(frame[60:], axis=-1) > 100]
        shares = np.bincount(inside.argmax(axis=-1), minlength=3) / len(inside)
        values = np.array([found.value("aset", key) for key in ("red", "green", "blue")])
        assert shares == pytest.approx(values / values.sum(), abs=FRAME)


# ---- The command ---------------------------------------------------------------------------------------


def test_command_prints_json(capsys):
    words = ["--measures", "inoue,iso", "--to", "5", "--step", "5", "--json"]
    assert run(["tilt", str(FOLDER / "emerald.asc"), *words]) == 0
    (study,) = json.loads(capsys.readouterr().out)
    assert list(study) == ["name", "axis", "head_deg", "engine", "poses", "ties"]
    first = study["poses"][0]
    assert [first[key] for key in ("axis_deg", "turn_deg", "tilt_deg", "tilt_azimuth_deg")] == [0, -5, 5, 270]
    assert list(first["measures"]) == ["inoue", "iso"]
    assert first["measures"]["iso"]["bound"] <= 0.1
    assert {(tie["measure"], tie["turn_deg"]) for tie in study["ties"]} == {("iso", -5.0), ("iso", 5.0)}


def test_command_prints_csv_and_writes_a_figure_and_a_journal(capsys, tmp_path):
    stone = str(FOLDER / "emerald.asc")
    assert run(["tilt", stone, "--to", "2", "--format", "csv", "-o", str(tmp_path)]) == 0
    out = capsys.readouterr()
    rows = list(csv.DictReader(io.StringIO(out.out)))
    assert [float(row["turn_deg"]) for row in rows] == [-2, -1, 0, 1, 2]
    assert {path.name for path in tmp_path.iterdir()} == {"emerald-tilt.jsonl", "emerald-tilt.png"}
    assert f"written: {tmp_path / 'emerald-tilt.png'}" in out.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["--axis", "z"],
            "--axis = 'z': must be one of x, y, both, surface, or the azimuth of an axis in degrees",
        ),
        (["--to", "90"], "--to = 90.0: must be above 0 and below 90 [deg]"),
        (
            ["--measures", "wlr-like"],
            "--measures = 'wlr-like': wlr-like is a sum over all views and has no tilt",
        ),
        (["--film", "f.png"], "--film = 'f.png': must end in .mp4, .gif, .webp"),
        (["--film", "f.gif", "--axis", "both"], "--film = 'f.gif': shows turns about one axis"),
        (["--film", "f.gif", "--measures", "all"], "--film = 'f.gif': shows up to 4 measures"),
        (["inoue-1", "--film", "f.gif"], "--film = 'f.gif': shows one stone; name only one"),
    ],
)
def test_bad_input_is_one_line(words, said, capsys):
    assert run(["tilt", "inoue-3", *words]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"gemrender: {said}")
    assert err.count("\n") == 1
