"""Atlases: plans, stores that are gone on with, and the same bytes whoever measures."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

import gemrender as gem
from gemrender.errors import BackendError, InputError
from gemrender.sweep.atlas import make_atlas, work
from gemrender.sweep.atlas.chunk import chunk_values, measure_chunk
from gemrender.sweep.atlas.export import export_atlas
from gemrender.sweep.atlas.map import cliffs
from gemrender.sweep.atlas.parts import Parts
from gemrender.sweep.atlas.plan import part_shape
from gemrender.sweep.atlas.plan_file import read_plan
from gemrender.sweep.atlas.store import DONE, NO_STONE, TO_DO, AtlasStore, open_atlas
from gemrender.sweep.workers import LostProcessError

#: Few rays: what is tested is not how close the values are to the truth.
BOUND = 5.0
#: Values are kept in single precision, relative.
SINGLE = 1e-6

GRID = """
    stone = "gia-excellent"
    measures = ["inoue", "window"]
    bound = 5
    chunk = 4
    [vary]
    crown_angle = "33:35:1"
    star = [10, 40, 50, 60]
    """
SOBOL = """
    stone = "tolkowsky"
    bound = 5
    chunk = 3
    [vary]
    table = "53:60"
    pavilion_angle = "40:41.5"
    [sobol]
    number = 7
    seed = 5
    """


@pytest.fixture(scope="module")
def whole_grid(tmp_path_factory):
    """The folder of `GRID`'s atlas, made by threads: read by several tests, changed by none."""
    folder = tmp_path_factory.mktemp("grid")
    (folder / "plan.toml").write_text(textwrap.dedent(GRID))
    make_atlas(read_plan(folder / "plan.toml"), str(folder / "a.zarr"))
    return folder / "a.zarr"


@pytest.fixture
def planned(tmp_path):
    """Return what reads a plan from a text."""

    def read(text, name="plan"):
        path = tmp_path / f"{name}.toml"
        path.write_text(textwrap.dedent(text))
        return read_plan(path)

    return read


def contents(store: Path) -> dict[str, bytes]:
    """Return the bytes of every file of a store, by its path."""
    return {
        path.relative_to(store).as_posix(): path.read_bytes()
        for path in sorted(store.rglob("*"))
        if path.is_file()
    }


# ---- Plans ---------------------------------------------------------------------------------------------


def test_chunks_cover_every_stone_once(planned):
    plan = planned(GRID)
    seen = np.zeros(plan.shape, dtype=int)
    for chunk in range(plan.chunks):
        seen[plan.place(chunk)] += 1
    assert (seen == 1).all()


@pytest.mark.parametrize(
    ("most", "expected"), [(1, (1, 1, 1)), (4, (1, 1, 4)), (12, (1, 3, 4)), (99, (2, 3, 4))]
)
def test_parts_are_whole_rows_of_the_last_dimensions(most, expected):
    assert part_shape((2, 3, 4), most) == expected


def test_settings_vary_the_last_parameter_fastest(planned):
    plan = planned(GRID)
    settings = list(plan.settings(plan.place(1)))
    assert settings == [{"crown_angle": 34.0, "star": star} for star in (10.0, 40.0, 50.0, 60.0)]


@pytest.mark.parametrize("text", [GRID, SOBOL, SOBOL.replace("[sobol]", "star = [50, 55]\n[sobol]")])
def test_parts_of_a_chunk_have_the_settings_of_the_whole(planned, text):
    plan = planned(text)
    place = plan.place(1)
    whole = list(plan.settings(place))
    for first in range(len(whole)):
        for last in range(first, len(whole) + 1):
            assert list(plan.settings(place, first, last)) == whole[first:last]


def test_parts_cover_every_chunk_once_however_fast_the_work_is(planned):
    plan = planned(GRID)
    parts, seen = Parts(plan, [0, 2], 2), []
    for part in parts:
        assert 0 < part.last - part.first <= 4
        seen += [(part.chunk, k) for k in range(part.first, part.last)]
        parts.rate *= 3
        parts.rate += 5
    assert seen == [(chunk, k) for chunk in (0, 2) for k in range(4)]


def test_points_of_a_design_do_not_depend_on_which_are_asked_for(planned):
    plan = planned(SOBOL)
    every = plan.points(slice(0, 7))
    apart = np.concatenate([plan.points(slice(k, min(k + 3, 7))) for k in (0, 3, 6)])
    np.testing.assert_array_equal(apart, every)
    assert ((every >= [53, 40]) & (every < [60, 41.5])).all()


def test_points_fill_the_range_as_sobol_points_do(planned):
    """Each of 2^k equal parts of every range has just one of 2^k points."""
    plan = planned(SOBOL.replace("number = 7", "number = 16"))
    unit = (plan.points(slice(0, 16)) - [53, 40]) / [7, 1.5]
    for column in unit.T:
        assert sorted(np.floor(16 * column)) == list(range(16))


def test_plans_of_families_take_their_parameters_and_materials(planned):
    plan = planned("""
        material = "sapphire"
        [cut]
        family = "emerald"
        [vary]
        index = [1.6, 1.7]
        """)
    stone = plan.made({"index": 1.6})
    assert plan.stone.material == "sapphire"
    assert stone.material == 1.6


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("bound", "bond"), "bond = 5: unknown key"),
        (("star", "culett"), "vary.culett"),
        (("star =", "lower_half = 80\ncrown_height ="), "crown_angle and crown_height are one thing"),
        (('"window"', '"glitter"'), "measures = 'glitter'"),
        (('"window"', '"facets"'), "has no numbers"),
        (('"window"]', '"wlr-like"]\ntilts = [0, 10]'), "has no tilt"),
        (("bound = 5", "bound = 50"), "bound = 50"),
        (("bound = 5", "tilts = [90]"), "tilts = 90"),
        (("bound = 5", "tilts = [5, [5, 0]]"), "has a view twice"),
        (("bound = 5", 'material = "glass of water"'), "material = 'glass of water'"),
        (("gia-excellent", "nowhere.toml"), "stone = 'nowhere.toml': no such file"),
        (('stone = "gia-excellent"', ""), "needs exactly one of stone"),
        (("chunk = 4", "chunk = 0"), "chunk = 0"),
        (("33:35:1", "33:35"), "[sobol]: missing"),
        (("33:35:1", "35:33"), "must be first:last"),
        (("[10, 40, 50, 60]", "[10, 10]"), "has a value twice"),
        (("[10, 40, 50, 60]", "[true]"), "must be a value, a list"),
        (("[10, 40, 50, 60]", "[1, 2]"), "no stone can be made; crown_angle=33.0 star=1.0"),
        (
            ("33:35:1", '30:40:0.0001"\ntable = "50:60:0.001'),
            "makes 100001 x 10001 x 4 = 4000440004 stones; at most 100000000 are allowed",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_in_a_line(planned, change, said):
    with pytest.raises(InputError) as caught:
        planned(GRID.replace(*change))
    assert said in str(caught.value)
    assert "plan.toml" in str(caught.value)


def test_a_plan_larger_than_the_disk_is_refused(planned, tmp_path, monkeypatch):
    plan = planned(GRID)
    usage = type("Usage", (), {"free": plan.bytes - 1})
    monkeypatch.setattr("shutil.disk_usage", lambda path: usage)
    with pytest.raises(InputError, match="takes up to"):
        make_atlas(plan, str(tmp_path / "atlas.zarr"))
    assert not (tmp_path / "atlas.zarr").exists()


# ---- Values --------------------------------------------------------------------------------------------


def test_a_cell_is_what_a_score_says(whole_grid):
    with open_atlas(str(whole_grid)) as atlas:
        cell = atlas.sel(crown_angle=34, star=50).load()
    stone = gem.vary("gia-excellent", ["crown_angle=34", "star=50"])[0]
    score = gem.score(stone, bound=BOUND, measures="window")
    assert cell.inoue_average == pytest.approx(score.average, rel=SINGLE)
    assert cell.inoue_rear == pytest.approx(score.rear, rel=SINGLE)
    assert cell.inoue_band_60 == pytest.approx(score.bands[1].share, rel=SINGLE)
    assert cell.inoue_bound == pytest.approx(score.bound, rel=SINGLE)
    assert cell.window == pytest.approx(score.measures[0].values["value"], rel=SINGLE)


def test_cells_that_make_no_stone_are_told_and_not_done_again(planned, tmp_path):
    plan = planned(GRID)
    made = make_atlas(plan, str(tmp_path / "a.zarr"))
    assert (made.stones, made.done, made.no_stone, made.failed, made.measured) == (12, 9, 3, 0, 12)
    assert made.refused[0][0] == "crown_angle=33.0 star=10.0"
    assert "star must be at least" in made.refused[0][1]
    with open_atlas(str(tmp_path / "a.zarr")) as atlas:
        is_star = atlas.star.values == 10
        np.testing.assert_array_equal(
            atlas.status.values, np.where(is_star, NO_STONE, DONE) * np.ones((3, 1))
        )
        np.testing.assert_array_equal(np.isnan(atlas.inoue_average.values), np.broadcast_to(is_star, (3, 4)))
    assert make_atlas(plan, str(tmp_path / "a.zarr")).measured == 0


def test_a_measurement_that_fails_does_not_end_the_work(planned, tmp_path, monkeypatch):
    def failing(plan, stone, tilt):
        if "crown_angle=34" in stone.name:
            raise ZeroDivisionError("by nothing")
        return chunk_values(plan, stone, tilt)

    monkeypatch.setattr("gemrender.sweep.atlas.chunk.chunk_values", failing)
    made = make_atlas(planned(GRID.replace("[10, 40, 50, 60]", "[50, 60]")), str(tmp_path / "a.zarr"))
    assert (made.done, made.failed) == (4, 2)
    assert made.refused[0] == ("crown_angle=34.0 star=50.0", "ZeroDivisionError: by nothing")


def test_views_are_a_dimension(planned, tmp_path):
    plan = planned(
        GRID.replace("bound = 5", "bound = 5\ntilts = [0, [10, 90]]").replace("[10, 40, 50, 60]", "50")
    )
    make_atlas(plan, str(tmp_path / "a.zarr"))
    stone = gem.vary("gia-excellent", ["crown_angle=33", "star=50"])[0]
    score = gem.score(stone, bound=BOUND, tilt=10, tilt_azimuth=90)
    with open_atlas(str(tmp_path / "a.zarr")) as atlas:
        assert atlas.inoue_average.dims == ("crown_angle", "star", "view")
        assert atlas.tilt_azimuth.values.tolist() == [0, 90]
        assert atlas.inoue_average.values[0, 0, 1] == pytest.approx(score.average, rel=SINGLE)


def test_attributes_tell_where_the_numbers_come_from(planned, tmp_path):
    plan = planned(GRID)
    AtlasStore(plan, str(tmp_path / "a.zarr"))
    with open_atlas(str(tmp_path / "a.zarr")) as atlas:
        assert atlas.attrs["gemrender_version"] == gem.__version__
        assert atlas.attrs["bound"] == BOUND
        assert atlas.attrs["measures"] == "inoue:1 window:1"
        assert json.loads(atlas.attrs["plan"]) == plan.record
        assert atlas.crown_angle.attrs["units"] == "degree"
        assert atlas.window.attrs["ancillary_variables"] == "window_bound status"
        assert (atlas.status.values == TO_DO).all()
        assert np.isnan(atlas.window.values).all()


# ---- Stores --------------------------------------------------------------------------------------------


def test_bytes_are_the_same_in_any_order_and_number_of_threads(planned, tmp_path):
    for text, name in ((GRID.replace("33:35:1", "33:34:1"), "grid"), (SOBOL, "sobol")):
        plan = planned(text, name)
        make_atlas(plan, str(tmp_path / "one.zarr" / name), threads=1)
        make_atlas(plan, str(tmp_path / "three.zarr" / name), threads=3)
        store = AtlasStore(plan, str(tmp_path / "backwards.zarr" / name))
        for chunk in reversed(store.to_do()):
            store.write(chunk, measure_chunk(plan, chunk))
    expected = contents(tmp_path / "one.zarr")
    assert contents(tmp_path / "three.zarr") == expected
    assert contents(tmp_path / "backwards.zarr") == expected


def test_processes_write_the_same_bytes_though_one_of_them_is_killed(planned, tmp_path, monkeypatch, caplog):
    """They are started after the first stones, which threads have measured."""
    monkeypatch.setattr(work, "TRIAL_S", 0.0)
    monkeypatch.setattr(work, "WORTH_S", 0.0)
    monkeypatch.setattr(work, "usable_processors", lambda: 2)
    plan = planned(SOBOL.replace("number = 7", "number = 20"))
    killed = []

    def kill(share):
        if not killed and (children := multiprocessing.active_children()):
            killed.append(children[0])
            os.kill(children[0].pid, signal.SIGKILL)

    made = make_atlas(plan, str(tmp_path / "processes.zarr"), progress=kill)
    assert killed
    assert made.done == made.measured == 20
    assert "its work is done again" in caplog.text
    make_atlas(plan, str(tmp_path / "threads.zarr"), threads=2)
    assert contents(tmp_path / "processes.zarr") == contents(tmp_path / "threads.zarr")


def test_where_processes_are_lost_again_and_again_what_is_done_is_kept(planned, tmp_path, monkeypatch):
    def lost(function, parts, processes):
        for part in parts:
            if part.chunk == 2:
                raise LostProcessError("a process was ended by signal 9")
            yield function(part)

    plan, where = planned(GRID), str(tmp_path / "a.zarr")
    with monkeypatch.context() as patched:
        patched.setattr(work, "in_processes", lost)
        with pytest.raises(LostProcessError, match="what is done is kept in"):
            make_atlas(plan, where, processes=2)
    assert AtlasStore(plan, where).to_do() == [2]
    assert make_atlas(plan, where).measured == 4


def test_an_interruption_keeps_what_is_done(planned, tmp_path, whole_grid):
    plan = planned(GRID)
    where = str(tmp_path / "a.zarr")

    def interrupt(share):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_atlas(plan, where, threads=1, progress=interrupt)
    assert len(AtlasStore(plan, where).to_do()) == 2
    assert make_atlas(plan, where).measured == 8
    assert contents(tmp_path / "a.zarr") == contents(whole_grid)


def test_the_status_of_many_chunks_is_read_some_at_a_time(planned, tmp_path, monkeypatch):
    plan = planned(GRID.replace("chunk = 4", "chunk = 3"))
    store = AtlasStore(plan, str(tmp_path / "a.zarr"))
    for chunk in range(plan.chunks):
        shape = tuple(part.stop - part.start for part in plan.place(chunk))
        store.write(chunk, {"status": np.full(shape, 1 + chunk % 3, dtype=np.int8)})
    whole = store.status()
    assert len(np.unique(whole)) == 3
    for number in (1, 2, 4):
        monkeypatch.setattr("gemrender.sweep.atlas.store.CHUNKS_AT_ONCE", number)
        np.testing.assert_array_equal(store.status(), whole)


def test_a_damaged_chunk_is_done_again(planned, tmp_path, whole_grid):
    plan = planned(GRID)
    shutil.copytree(whole_grid, tmp_path / "a.zarr")
    expected = contents(tmp_path / "a.zarr")
    (tmp_path / "a.zarr" / "status" / "c" / "1" / "0").write_bytes(b"(\xb5/\xfd")
    assert make_atlas(plan, str(tmp_path / "a.zarr")).measured == 4
    assert contents(tmp_path / "a.zarr") == expected


def test_a_process_killed_with_9_goes_on(planned, tmp_path, whole_grid):
    """It is killed after the values of its second chunk and before their status."""
    plan = planned(GRID)
    code = """
        import os, signal, sys
        from gemrender.sweep.atlas import make_atlas
        from gemrender.sweep.atlas.plan_file import read_plan
        from gemrender.sweep.atlas.store import AtlasStore

        write = AtlasStore.write
        def killed(store, chunk, found):
            if chunk == 1:
                write(store, chunk, {key: values for key, values in found.items() if key != "status"})
                os.kill(os.getpid(), signal.SIGKILL)
            write(store, chunk, found)
        AtlasStore.write = killed
        make_atlas(read_plan(sys.argv[1]), sys.argv[2], threads=1)
        """
    arguments = [str(tmp_path / "plan.toml"), str(tmp_path / "a.zarr")]
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code), *arguments], check=False)
    assert done.returncode == -signal.SIGKILL
    (tmp_path / "a.zarr" / "status" / "c" / "2").mkdir(parents=True)
    (tmp_path / "a.zarr" / "status" / "c" / "2" / "0.1234.partial").write_bytes(b"half")  # as zarr leaves it
    assert make_atlas(plan, str(tmp_path / "a.zarr")).measured == 8
    assert contents(tmp_path / "a.zarr") == contents(whole_grid)


def test_an_atlas_of_another_plan_is_refused(planned, tmp_path):
    AtlasStore(planned(GRID), str(tmp_path / "a.zarr"))
    with pytest.raises(InputError, match=r"another plan \(other bound\)"):
        AtlasStore(planned(GRID.replace("bound = 5", "bound = 4")), str(tmp_path / "a.zarr"))


def test_other_folders_and_files_are_left_alone(planned, tmp_path):
    plan = planned(GRID)
    with pytest.raises(InputError, match="is a folder of something else"):
        AtlasStore(plan, str(tmp_path))
    with pytest.raises(InputError, match="is a file"):
        AtlasStore(plan, str(tmp_path / "plan.toml"))
    with pytest.raises(InputError, match="cannot be opened"):
        AtlasStore(plan, "nothing-like-it://bucket")


def test_a_bucket_works_as_a_folder_does(planned, tmp_path):
    plan = planned(SOBOL)
    make_atlas(plan, "memory://atlases/a.zarr", threads=1)
    assert make_atlas(plan, "memory://atlases/a.zarr").measured == 0
    make_atlas(plan, f"file://{tmp_path}/b.zarr")
    with open_atlas("memory://atlases/a.zarr") as one, open_atlas(str(tmp_path / "b.zarr")) as other:
        assert one.load().identical(other.load())


# ---- netCDF --------------------------------------------------------------------------------------------


def test_a_netcdf_file_holds_the_whole_atlas(planned, tmp_path):
    plan = planned(
        GRID.replace("star =", 'material = ["diamond", "sapphire"]\nstar =').replace(
            "chunk = 4", "tilts = [5]"
        )
    )
    where = str(tmp_path / "a.zarr")
    store = AtlasStore(plan, where)
    assert export_atlas(where, tmp_path / "half.nc")[1] == plan.stones
    for chunk in store.to_do():
        store.write(chunk, measure_chunk(plan, chunk))
    path, to_do = export_atlas(where, tmp_path / "a.nc")
    assert to_do == 0
    with open_atlas(where) as zarr, open_atlas(str(path)) as netcdf:
        assert sorted(netcdf.variables) == sorted(zarr.variables)
        for name, values in zarr.variables.items():
            np.testing.assert_array_equal(netcdf[name].values.astype(values.dtype), values.values)
            assert netcdf[name].dims == values.dims
        assert netcdf.attrs == zarr.attrs
    first = path.read_bytes()
    assert export_atlas(where, path)[0].read_bytes() == first


@pytest.mark.parametrize("name", ["a.zarr", "a.nc"])
def test_what_is_no_atlas_is_told(tmp_path, name):
    with pytest.raises(InputError, match="is no atlas"):
        open_atlas(str(tmp_path / name))


@pytest.mark.parametrize("package", ["xarray", "zarr"])
def test_a_missing_package_is_told_with_the_cure(tmp_path, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(BackendError, match=r"pip install 'gemrender\[atlas\]'"):
        open_atlas(str(tmp_path / "a.zarr"))


# ---- The command ---------------------------------------------------------------------------------------


def test_the_command_makes_goes_on_and_exports(gemrender, folder):
    (folder / "grid.toml").write_text(textwrap.dedent(GRID))
    status, out, err = gemrender("atlas", "grid.toml", "--processes", 2, "--dry-run")
    assert (status, err) == (0, "")
    assert "stones    12\n" in out
    assert "chunks    3, of at most 4 stones\n" in out
    assert " processes, measured on 12 of them\n" in out
    assert not (folder / "grid.zarr").exists()
    status, _, err = gemrender("atlas", "grid.toml", "--threads", 2)
    assert status == 0
    assert "3 of 12 make no stone (status 2 in the atlas)" in err
    assert "written: grid.zarr (9 stones, 12 of them now" in err
    status, _, err = gemrender("atlas", "export", "grid.zarr")
    assert (status, err) == (0, "written: grid.nc\n")


def test_an_interrupted_command_ends_with_130(gemrender, folder, monkeypatch):
    (folder / "grid.toml").write_text(textwrap.dedent(GRID))

    def interrupt(store):
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(AtlasStore, "tidy", interrupt)  # once all is measured
    assert gemrender("atlas", "grid.toml")[0] == 130
    assert len(list((folder / "grid.zarr" / "status" / "c").iterdir())) == 3


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nowhere.toml",), "nowhere.toml: no such file"),
        (("grid.toml", "grid.toml"), "is one plan too many"),
        (("grid.toml", "--threads", "0"), "--threads"),
        (("grid.toml", "--processes", "0"), "--processes"),
        (("grid.toml", "--threads", "2", "--processes", "2"), "cannot be given together with --processes"),
        (("grid.toml", "--threads", "2", "--dask", "local"), "cannot be given together with --dask"),
        (("grid.toml", "--processes", "2", "--dask", "local"), "cannot be given together with --dask"),
        (("grid.toml", "--dask", "nowhere"), "must be the address of a scheduler"),
        (("grid.toml", "--dask", "local:0"), "with N from 1"),
        (("export",), "must be one atlas"),
        (("export", "nowhere", "-o", "a.nc"), "nowhere: is no atlas"),
        (("export", "nowhere", "-o", "a.txt"), "must end in .nc"),
    ],
)  # fmt: skip
def test_bad_arguments_are_one_line(gemrender, folder, arguments, said):
    (folder / "grid.toml").write_text(textwrap.dedent(GRID))
    status, _, err = gemrender("atlas", *arguments)
    assert status == 2
    assert said in err
    assert err.count("\n") == 1


# ---- The atlas that comes with gemrender ---------------------------------------------------------------

COMMITTED = Path(__file__).parents[2] / "docs" / "atlas" / "round-brilliants.nc"


def test_the_atlas_of_round_brilliants_is_complete_and_of_its_plan():
    plan = read_plan(COMMITTED.with_suffix(".toml"))
    with open_atlas(str(COMMITTED)) as atlas:
        assert json.loads(atlas.attrs["plan"]) == plan.record
        assert (atlas.status.values == DONE).all()
        assert float(atlas.iso_bound.max()) <= plan.bound
    assert COMMITTED.stat().st_size < 15 * 2**20


@pytest.mark.parametrize("cell", [(0, 0, 0, 0), (9, 16, 2, 2), (16, 28, 4, 4)])
def test_cells_of_the_atlas_of_round_brilliants_are_what_is_measured_now(cell):
    """Within both bounds of each other, wherever the committed file was made."""
    plan = read_plan(COMMITTED.with_suffix(".toml"))
    setting = next(plan.settings(tuple(slice(k, k + 1) for k in cell)))
    now = chunk_values(plan, plan.made(setting), (0.0, 0.0))
    with open_atlas(str(COMMITTED)) as atlas:
        there = [float(atlas[of.name].values[cell]) for of in plan.variables]
    np.testing.assert_allclose(now, there, atol=2 * plan.bound)


def test_the_atlas_of_round_brilliants_has_the_leak_that_comes_at_once():
    """At a crown of 35 degrees and lower halves of 80 %, just above a pavilion of 41.1 degrees."""
    with open_atlas(str(COMMITTED)) as atlas:
        leak = atlas.aset_leak.sel(crown_angle=35, lower_half=80, table=55)
        steps = cliffs(atlas.pavilion_angle.values, leak.values, atlas.aset_bound.sel(leak.coords).values)
    lower = leak.pavilion_angle.values[:-1][steps]
    assert np.isclose(lower, 41.1).any()
    assert float(leak.sel(pavilion_angle=41.1, method="nearest")) < 5
    assert float(leak.sel(pavilion_angle=41.2, method="nearest")) > 11
