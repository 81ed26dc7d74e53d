"""Stone files of every kind: told by content, named by .toml files, written by `save_stone`."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from any_stones import facets_in
from thorough import some

import gemrender
from gemrender.cuts.content import READ_KINDS, kind_of
from gemrender.cuts.convert import WRITTEN_KINDS, design_of, save_stone
from gemrender.cuts.load import load_design_file, read_design
from gemrender.cuts.mesh_stone import stone_of_triangles
from gemrender.cuts.round_girdle import girdle_planes
from gemrender.errors import InputError
from gemrender.stone.facets import Facet, side_of
from gemrender.stone.frame import in_frame
from gemrender.stone.polyhedron import intersect
from gemrender.stone.solid import convex_solid
from gemrender.stone.stone import Stone

CASES = Path(__file__).parents[1] / "cases" / "stones"
#: Facets of emerald.asc.
EMERALD_FACETS = sum(facets_in("emerald"))
DESIGNS = sorted(path for path in CASES.iterdir() if path.suffix != ".json")
#: Rounding of numbers of 64 and of 32 bits, a few of them.
ROUNDING = {"glb": 1e-6}
LEAST_ROUNDING = 1e-13


def planes_of(stone):
    return np.column_stack([stone.facet_normals, stone.facet_offsets])


def missing(stone, again):
    """How far the planes of a stone are from the nearest ones of the other, at most."""
    apart = np.abs(planes_of(stone)[:, None] - planes_of(again)[None]).max(axis=2)
    return float(apart.min(axis=1).max())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A stone in every kind that is written."""
    folder = tmp_path_factory.mktemp("kinds")
    stone = load_design_file(CASES / "emerald.asc")
    for kind in WRITTEN_KINDS:
        if kind != "csv":
            save_stone(stone, folder / f"emerald.{kind}")
    save_stone(gemrender.load_stone("tolkowsky"), folder / "tolkowsky.csv")
    return folder


# ---- Content -------------------------------------------------------------------------------------------


#: Each kind, and each ending; each with each is slow.
ENDINGS = (".toml", ".csv", "", ".STL", ".gem", ".txt")
NAMED = [(kind, ending) for kind in WRITTEN_KINDS if kind != "csv" for ending in ENDINGS]


@pytest.mark.parametrize(("kind", "ending"), some(NAMED, len(ENDINGS) - 1))
def test_content_tells_before_the_ending(kind, ending, folder, tmp_path):
    shutil.copy(folder / f"emerald.{kind}", tmp_path / f"stone{ending}")
    stone = gemrender.load_stone(tmp_path / f"stone{ending}")
    assert len(stone.facets) == EMERALD_FACETS
    assert stone.name == "stone"
    assert stone.source == str(tmp_path / f"stone{ending}")


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.name)
def test_designs_as_people_keep_them(path):
    data = path.read_bytes()
    for ending in (path.suffix, "", ".toml"):
        assert kind_of(data, len(data), ending) == path.suffix[1:]


def test_what_has_no_mark_is_what_its_name_ends_in():
    for kind in READ_KINDS:
        assert kind_of(b"nothing known", 13, f".{kind.upper()}") == kind
    assert kind_of(b"nothing known", 13, ".txt") is None
    assert kind_of(b"name = 'a'\n[angles]\n", 20, ".txt") == "toml"
    assert kind_of(b"g 96 0.0\na 45.0 0.7 12 24\n", 20, ".txt") == "asc"


@pytest.mark.parametrize(
    "data", [b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", b"%PDF-1.7\n", b"ISO-10303-21;\nHEADER;\n"]
)
def test_what_no_reader_knows_is_told_the_kinds_that_are_read(data, tmp_path):
    (tmp_path / "stone.xyz").write_bytes(data)
    with pytest.raises(InputError) as caught:
        gemrender.load_stone(tmp_path / "stone.xyz")
    assert str(caught.value) == (
        f"{tmp_path / 'stone.xyz'}: is none of the kinds of stone file that are read: "
        ".toml, .csv, .tsv, .asc, .gem, .gcs, .stl, .obj, .ply, .glb, .srn"
    )


def test_octonus_gem_is_refused_in_one_line(tmp_path):
    (tmp_path / "stone.gem").write_bytes(b"\x01\x02OctoNus DiamCalc" + bytes(range(200)))
    with pytest.raises(InputError, match=r"OctoNus has another .gem, which is not read"):
        gemrender.load_stone(tmp_path / "stone.gem")


@pytest.mark.parametrize("kind", READ_KINDS)
def test_what_is_not_there_or_empty_is_told(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=f"^none.{kind}: no such file, and no bundled stone"):
        gemrender.load_stone(f"none.{kind}")
    Path(f"empty.{kind}").write_bytes(b"")
    with pytest.raises(InputError, match="is empty"):
        gemrender.load_stone(f"empty.{kind}")
    Path(f"folder.{kind}").mkdir()
    with pytest.raises(InputError, match=r"cannot be read|must be a file"):
        gemrender.load_stone(f"folder.{kind}")


def test_a_design_is_no_mesh(folder):
    with pytest.raises(InputError, match=r"is a \.stl file; a design is one of \.asc, \.gem, \.gcs"):
        read_design(folder / "emerald.stl")
    assert read_design(folder / "emerald.gem").n_facets == EMERALD_FACETS
    with pytest.raises(InputError, match="up = 'z': is of meshes only"):
        load_design_file(folder / "emerald.asc", up="z")


def test_the_material_of_a_design_is_its_index():
    assert gemrender.load_stone(CASES / "checkerboard-round.asc").material == 1.72


# ---- Named by .toml files ------------------------------------------------------------------------------


def toml(folder: Path, text: str) -> Path:
    (folder / "stone.toml").write_text(text)
    return folder / "stone.toml"


@pytest.mark.parametrize(
    "text",
    [
        'design = "emerald.asc"',
        'design = "emerald.gcs"',
        'mesh = "emerald.stl"',
        '[mesh]\nfile = "emerald.glb"',
        '[mesh]\nfile = "emerald.ply"\nup = "z"',
    ],
)
def test_toml_files_name_designs_and_meshes(text, folder):
    path = toml(folder, f'name = "Smaragd"\n{text}\n[material]\nindex = 1.58\n')
    stone = gemrender.load_stone(path)
    assert (stone.name, stone.material, stone.source) == ("Smaragd", 1.58, str(path))
    assert len(stone.facets) == EMERALD_FACETS
    assert missing(load_design_file(CASES / "emerald.asc"), stone) < 1e-6


def test_a_designs_index_stands_unless_the_toml_file_has_a_material(folder):
    assert gemrender.load_stone(toml(folder, 'design = "emerald.asc"')).material == 1.54


def test_the_way_up_of_a_mesh(folder):
    stone = gemrender.load_stone(toml(folder, '[mesh]\nfile = "emerald.stl"\nup = "-z"'))
    upright = gemrender.load_stone(folder / "emerald.stl")
    assert stone.facet_sides.count("crown") == upright.facet_sides.count("pavilion")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('design = "none.asc"', "none.asc: no such file; named by design in {toml}"),
        ('mesh = "none.stl"', "none.stl: no such file; named by mesh in {toml}"),
        ('design = "emerald.stl"', "is a .stl file; here it must be one of .asc, .gem, .gcs"),
        ('mesh = "emerald.asc"', "is a .asc file; here it must be one of .stl, .obj, .ply, .glb, .srn"),
        ("design = 3", "design = 3: must be the name of a file .asc, .gem, .gcs"),
        (
            "mesh = 3",
            "mesh = 3: must be the name of a file .stl, .obj, .ply, .glb, .srn, or a section [mesh]",
        ),
        ('[mesh]\nup = "z"', "[mesh]: missing file; needs file"),
        ("[mesh]\nfile = 1", "mesh.file = 1: must be the name of a file .stl, .obj, .ply, .glb, .srn"),
        ('[mesh]\nfile = "a.stl"\nup = "w"', "mesh.up = 'w': must be one of x, y, z, -x, -y, -z"),
        ('[mesh]\nfile = "a.stl"\nupp = "z"', "mesh.upp = 'z': unknown key; must be one of file, up"),
        (
            'design = "emerald.asc"\nmesh = "emerald.stl"',
            "needs exactly one of [proportions], [angles], [report], [cut], vertices, design and mesh; "
            "has design and mesh",
        ),
    ],
)
def test_what_a_toml_file_names_badly_is_told_in_one_line(text, told, folder):
    path = toml(folder, text)
    with pytest.raises(InputError) as caught:
        gemrender.load_stone(path)
    assert told.format(toml=path) in str(caught.value)
    assert "\n" not in str(caught.value)


# ---- Written -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", some(DESIGNS, 3), ids=lambda path: path.name)
def test_there_and_back_in_every_format(path, tmp_path):
    stone = gemrender.load_stone(path)
    for kind in WRITTEN_KINDS:
        if kind == "csv":
            continue
        assert save_stone(stone, tmp_path / f"again.{kind}") == ()
        again = gemrender.load_stone(tmp_path / f"again.{kind}")
        assert len(again.facets) == len(stone.facets), kind
        assert missing(stone, again) < ROUNDING.get(kind, LEAST_ROUNDING), kind
        assert again.rear_rule == stone.rear_rule
        if kind in ("asc", "gem", "gcs"):
            assert again.material == stone.material
            assert again.facet_kinds == stone.facet_kinds


def tangent(seed: int) -> Stone:
    """A stone of planes that touch an ellipsoid at random."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(int(rng.integers(12, 60)), 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    axes = rng.uniform(0.5, 2.0, 3)
    planes = np.column_stack([normals, np.linalg.norm(normals * axes, axis=1)])
    solid, left = convex_solid(in_frame(planes)[0], np.arange(len(planes)))
    facets = (Facet(f"f {k}", "f", side_of(planes[k, 2])) for k in left)
    return Stone(solid=solid, facets=tuple(facets), material=1.7)


@pytest.mark.parametrize("seed", some(range(12), 4))
def test_random_convex_solids_there_and_back(seed, tmp_path):
    stone = tangent(seed)
    for kind in ("asc", "gem", "gcs", "stl", "obj", "ply"):
        save_stone(stone, tmp_path / f"again.{kind}")
        again = gemrender.load_stone(tmp_path / f"again.{kind}")
        assert len(again.facets) == len(stone.facets), kind
        assert missing(stone, again) < 1e3 * LEAST_ROUNDING, kind  # small facets far from the middle
        assert again.solid.volume == pytest.approx(stone.solid.volume)


@pytest.mark.parametrize(
    ("kind", "turn"),
    some([("asc", 1.23), *((kind, 0.0) for kind in WRITTEN_KINDS if kind != "csv"), ("obj", 1.23)], 3),
)
def test_a_round_girdle_becomes_level_facets_and_it_is_told(kind, turn, tmp_path):
    stone = gemrender.load_stone("inoue-3").rotated(turn)
    is_design = kind in ("asc", "gem", "gcs")
    pieces = 96 if is_design else 1024
    told = save_stone(stone, tmp_path / f"again.{kind}")
    assert told == (f"the round girdle became {pieces} level facets",)
    again = gemrender.load_stone(tmp_path / f"again.{kind}")
    assert missing(stone, again) < ROUNDING.get(kind, LEAST_ROUNDING)
    assert again.solid.volume == pytest.approx(stone.solid.volume, rel=4 / pieces**2)
    if turn == 0:
        assert len(again.facets) == 57 + pieces
    if is_design:
        assert again.facet_kinds == (*stone.facet_kinds[:57], *["girdle"] * pieces)
        assert again.material == pytest.approx(2.4173, abs=1e-4)


def test_csv_holds_the_57_vertices_to_the_last_bit(folder, tmp_path):
    stone = gemrender.load_stone("tolkowsky")
    again = gemrender.load_stone(folder / "tolkowsky.csv")
    np.testing.assert_allclose(again.vertices, stone.vertices, atol=LEAST_ROUNDING)
    with pytest.raises(InputError, match=r"only the 57 vertices of round brilliants are written as .csv"):
        save_stone(load_design_file(CASES / "emerald.asc"), tmp_path / "emerald.csv")


def test_a_stone_without_a_design_gets_one_by_the_kinds_of_its_facets():
    stone = load_design_file(CASES / "emerald.asc").rotated(7.5)  # two teeth of 96
    design, told = design_of(stone)
    assert told == ()
    assert design.gear == 96
    assert design.index == 1.54
    assert [float(i).is_integer() for tier in design.tiers for i in tier.indices] == [True] * 49
    assert set(design.kinds()) == set(stone.facet_kinds)
    np.testing.assert_allclose(
        np.sort(design.planes()[:, 3]), np.sort(stone.facet_offsets), atol=LEAST_ROUNDING
    )


def test_a_stone_that_stands_on_its_girdle_is_written(tmp_path):
    """A rose cut's base passes through the origin, where it has no side."""
    lines = "GemCad 5.0\ng 96 0.0\ny 6 n\nI 1.5\na 30 0.5 16 32 48 64 80 96\na 70 0.8 8 24 40 56 72 88\n"
    (tmp_path / "rose.asc").write_text(lines + "a -0 0.1 96\n")
    stone = gemrender.load_stone(tmp_path / "rose.asc").rotated(0.0)
    assert min(stone.facet_offsets) == pytest.approx(0.0, abs=LEAST_ROUNDING)
    for kind in ("asc", "gem", "gcs"):
        save_stone(stone, tmp_path / f"again.{kind}")
        assert missing(stone, gemrender.load_stone(tmp_path / f"again.{kind}")) < LEAST_ROUNDING
        assert len(read_design(tmp_path / f"again.{kind}").tiers) == 3


def test_what_is_not_convex_is_no_design(tmp_path):
    corners = np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)] + [[0, 0, 0.5]])
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)]
    faces += [(0, 2, 6), (0, 6, 4), (1, 5, 8), (5, 7, 8), (7, 3, 8), (3, 1, 8)]
    stone = stone_of_triangles(corners, faces, up="z")
    with pytest.raises(InputError, match=r"is not convex, and so no design; .stl, .obj, .ply and .glb can"):
        save_stone(stone, tmp_path / "stone.asc")


def test_kinds_that_are_not_written_are_told(tmp_path):
    with pytest.raises(
        InputError, match=r"must end in one of .asc, .gem, .gcs, .stl, .obj, .ply, .glb, .csv"
    ):
        save_stone(gemrender.load_stone("tolkowsky"), tmp_path / "stone.step")


@pytest.mark.parametrize("turn", [0.0, 1.23, 20.0])
def test_girdle_planes_touch_the_girdle(turn):
    """And keep the stone's frame: the box, and the lowest point of the girdle's lower edge."""
    solid = gemrender.load_stone("inoue-3").rotated(turn).solid
    girdle = girdle_planes(solid, 96)
    assert (girdle[:, 2] == 0).all()
    np.testing.assert_allclose(np.hypot(girdle[:, 0], girdle[:, 1]), 1.0, atol=1e-15)
    body = intersect(np.concatenate([solid.planes, girdle]))
    box = np.ptp(body.vertices[:, :2], axis=0)
    assert box == pytest.approx(2.0, abs=1e-15)
