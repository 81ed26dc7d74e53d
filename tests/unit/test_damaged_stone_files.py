"""Damaged files of designs, meshes and scans make a stone, or one line that says what is wrong."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from any_stones import facets_in
from damage import damaged
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scan_files import scan_file
from thorough import chosen

from gemrender.cuts.convert import save_stone
from gemrender.cuts.load import load_design_file
from gemrender.errors import InputError

CASES = Path(__file__).parents[1] / "cases" / "stones"
#: Files of each kind; more by the environment, as `GEMRENDER_DAMAGED=1000 pytest ...`.
ASKED = os.environ.get("GEMRENDER_DAMAGED")
EXAMPLES = [int(ASKED)] if ASKED else chosen([20, 60], [20])
KINDS = ("asc", "gem", "gcs", "stl", "obj", "ply", "glb", "srn")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The right contents of a file of each kind, of one stone."""
    folder = tmp_path_factory.mktemp("whole")
    stone = load_design_file(CASES / "square-barion.asc")
    for kind in KINDS[:-1]:
        save_stone(stone, folder / f"stone.{kind}")
    body = stone.solid.polyhedron
    faces = [body.polygon(plane).tolist() for plane in range(len(body.planes))]
    (folder / "stone.srn").write_bytes(scan_file(1000.0 * body.vertices, faces))
    contents = {kind: (folder / f"stone.{kind}").read_bytes() for kind in KINDS}
    contents["quirky asc"] = (CASES / "novelty-chiral.asc").read_bytes()
    return contents


@pytest.mark.parametrize("examples", EXAMPLES)
@pytest.mark.parametrize("kind", [*KINDS, "quirky asc"])
def test_a_damaged_file_makes_a_stone_or_one_line(kind, examples, whole, tmp_path):
    path = tmp_path / f"stone.{kind.split()[-1]}"
    path.write_bytes(whole[kind])
    own = "novelty-chiral" if kind == "quirky asc" else "square-barion"
    assert len(load_design_file(path).facets) == sum(facets_in(own))

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        # The same ones every time, unless more are asked for.
        derandomize=not ASKED,
        suppress_health_check=list(HealthCheck),
    )
    @given(data=st.data())
    def check(data):
        path.write_bytes(data.draw(damaged(whole[kind])))
        refusal = stone = None
        try:
            stone = load_design_file(path)
        except InputError as error:
            refusal = str(error)
        if stone is None:
            assert refusal.startswith(str(path))
            assert "\n" not in refusal
            return
        assert np.isfinite(stone.solid.volume)
        assert len(set(stone.facet_names)) == len(stone.facets) == stone.solid.n_facets

    check()
