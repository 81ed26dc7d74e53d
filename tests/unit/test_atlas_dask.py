"""Atlases by Dask: the same bytes as in-process, though workers are killed and schedulers end."""

from __future__ import annotations

import logging
import signal
import subprocess
import sys
import textwrap
from importlib.util import find_spec

import pytest
from observations import environment

from gemrender.errors import BackendError, InputError
from gemrender.sweep.atlas import make_atlas
from gemrender.sweep.atlas.plan_file import read_plan
from gemrender.sweep.atlas.store import AtlasStore

if find_spec("distributed") is None:
    pytest.skip("distributed is not installed", allow_module_level=True)

PLAN = """
    stone = "gia-excellent"
    bound = 5
    chunk = 3
    [vary]
    crown_angle = "33:35:1"
    pavilion_angle = "40:40.8:0.1"
    """


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    path = tmp_path_factory.mktemp("plan") / "plan.toml"
    path.write_text(textwrap.dedent(PLAN))
    return read_plan(path)


@pytest.fixture(scope="module")
def expected(plan, tmp_path_factory):
    folder = tmp_path_factory.mktemp("threads")
    make_atlas(plan, str(folder / "threads.zarr"))
    return contents(folder / "threads.zarr")


def contents(store):
    return {path.relative_to(store): path.read_bytes() for path in store.rglob("*") if path.is_file()}


def cluster(**options):
    """Start a scheduler and its workers on loopback."""
    import distributed

    return distributed.LocalCluster(
        host="127.0.0.1",
        protocol="tcp://",
        dashboard_address="127.0.0.1:0",
        threads_per_worker=1,
        silence_logs=logging.CRITICAL,
        **options,
    )


def after_first_chunk(action):
    """Return a progress callback that does something once a first chunk is written."""
    done = []

    def progress(share):
        if share > 0 and not done:
            done.append(share)
            action()

    return progress


def test_a_worker_killed_in_the_middle_has_its_chunk_done_again(plan, tmp_path, expected):
    """By the other one, which is in this process and so at work long before it."""
    from distributed import Client

    with cluster(n_workers=1, processes=False) as two, Client(two.scheduler_address) as client:
        options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
        process = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_worker", two.scheduler_address, *options],
            env=environment({}), stderr=subprocess.DEVNULL,
        )  # fmt: skip
        held = {}

        def kill():
            held.update(client.processing())
            process.kill()

        try:
            client.wait_for_workers(2)
            made = make_atlas(
                plan, str(tmp_path / "a.zarr"), dask=two.scheduler_address,
                progress=after_first_chunk(kill),
            )  # fmt: skip
            assert process.wait() == -signal.SIGKILL
            del held[two.workers[0].address]
        finally:
            process.kill()
            process.wait()
    [at_work] = held.values()
    assert at_work
    assert made.done == plan.stones == made.measured
    assert contents(tmp_path / "a.zarr") == expected


def test_an_adaptive_cluster_starts_workers_for_it(plan, tmp_path, expected):
    """It has none until there is work."""
    with cluster(n_workers=0, processes=False) as adaptive:
        adaptive.adapt(minimum=0, maximum=1, interval="50ms")
        made = make_atlas(plan, str(tmp_path / "a.zarr"), dask=adaptive.scheduler_address)
    assert made.done == plan.stones
    assert contents(tmp_path / "a.zarr") == expected


def test_a_scheduler_without_workers_is_told(plan, tmp_path, monkeypatch):
    monkeypatch.setattr("gemrender.sweep.atlas.cluster.WORKERS_S", 0.2)
    with cluster(n_workers=0, processes=False) as empty, pytest.raises(InputError, match="has no worker"):
        make_atlas(plan, str(tmp_path / "a.zarr"), dask=empty.scheduler_address)


def test_after_the_scheduler_has_ended_another_one_goes_on(plan, tmp_path, expected, monkeypatch, caplog):
    monkeypatch.setattr("gemrender.sweep.atlas.cluster.ANSWER_S", 1)
    where = str(tmp_path / "a.zarr")
    one = cluster(n_workers=1, processes=False)
    with pytest.raises(BackendError, match="was lost; what is done is kept"):
        make_atlas(plan, where, dask=one.scheduler_address, progress=after_first_chunk(one.close))
    assert not [of for of in caplog.records if of.name == "distributed.client"]
    left = len(AtlasStore(plan, where).to_do())
    assert 0 < left < plan.chunks
    with cluster(n_workers=1, processes=False) as other:
        made = make_atlas(plan, where, dask=other.scheduler_address)
    assert made.measured == 3 * left
    assert contents(tmp_path / "a.zarr") == expected


def test_a_scheduler_that_is_not_there_is_told(plan, tmp_path, monkeypatch):
    monkeypatch.setattr("gemrender.sweep.atlas.cluster.ANSWER_S", 0.2)
    with pytest.raises(InputError, match="no scheduler answers there"):
        make_atlas(plan, str(tmp_path / "a.zarr"), dask="tcp://127.0.0.1:9")


def test_without_distributed_the_cure_is_told(plan, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(BackendError, match=r"pip install 'gemrender\[dask\]'"):
        make_atlas(plan, str(tmp_path / "a.zarr"), dask="local")
