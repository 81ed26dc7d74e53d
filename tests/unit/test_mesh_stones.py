"""Stones from meshes, as they are found: soup, wound both ways, rounded, any way up, open, not convex."""

from __future__ import annotations

import struct
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from scan_files import scan_file

from gemrender.cuts.asc import read_asc
from gemrender.cuts.mesh_facets import UP, turned_up
from gemrender.cuts.mesh_files import MESH_KINDS, parse_mesh, read_mesh, write_mesh
from gemrender.cuts.mesh_stone import stone_of_triangles
from gemrender.cuts.scans import read_scan
from gemrender.errors import BackendError, InputError
from gemrender.stone.solid import ConvexSolid, MeshSolid
from gemrender.stone.stone import Stone

CASES = Path(__file__).parents[1] / "cases" / "stones"
#: Six digits of coordinates make planes of narrow facets this uncertain.
SIX_DIGITS = 1e-4
#: Numbers of 32 bits.
SINGLE = 1e-6
#: Rounding of numbers of 64 bits, a few of them.
ROUNDING = 1e-13

CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def fans(polygons) -> np.ndarray:
    """Triangles of convex polygons."""
    return np.array([(p[0], p[k], p[k + 1]) for p in polygons for k in range(1, len(p) - 1)])


TRIANGLES = fans(QUADS)
FLAT = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


@pytest.fixture(scope="module")
def pear() -> Stone:
    return read_asc(CASES / "pear.asc").stone()


def triangles_of(stone: Stone) -> tuple[np.ndarray, np.ndarray]:
    body = stone.solid.polyhedron
    return body.vertices, fans([body.polygon(k) for k in range(len(body.planes))])


def apart(stone: Stone, other: Stone) -> float:
    """How far each plane of a stone is from the nearest of another, at most; both have as many."""
    one, two = (np.column_stack([s.facet_normals, s.facet_offsets]) for s in (stone, other))
    assert len(one) == len(two)
    return float(np.abs(one[:, None] - two[None]).max(axis=2).min(axis=1).max())


def test_a_cube():
    stone = stone_of_triangles(CUBE, TRIANGLES, name="cube")
    assert isinstance(stone.solid, ConvexSolid)
    assert stone.solid.volume == pytest.approx(8.0)
    assert stone.facet_kinds == ("T", "G1", "G1", "G1", "G1", "K")
    assert stone.facet_names == ("T", "G1_1", "G1_2", "G1_3", "G1_4", "K")
    assert stone.facet_normals[1:3].tolist() == [[0, 1, 0], [1, 0, 0]]  # as the index runs
    assert stone.notes == ("the largest facet was taken for the table: z is up",)
    assert stone.assumed == ("diamond (no material in the file)",)


def test_all_faces_inwards_are_turned_and_it_is_told():
    stone = stone_of_triangles(CUBE, TRIANGLES[:, ::-1], up="z")
    assert stone.notes == ("all triangles faced inwards; turned",)
    assert apart(stone, stone_of_triangles(CUBE, TRIANGLES, up="z")) == 0


def test_faces_of_both_windings_are_turned_and_it_is_told():
    mixed = TRIANGLES.copy()
    mixed[::3] = mixed[::3, ::-1]
    stone = stone_of_triangles(CUBE, mixed, up="z")
    assert stone.notes == ("4 of 12 triangles faced inwards; turned",)
    assert stone.solid.volume == pytest.approx(8.0)


def test_soup_doubled_and_degenerate_triangles():
    soup = CUBE[np.concatenate([TRIANGLES, TRIANGLES[:2], [[0, 0, 1], [0, 1, 1]]])].reshape(-1, 3)
    stone = stone_of_triangles(soup, np.arange(len(soup)).reshape(-1, 3), up="z")
    assert stone.notes == ("2 triangles stand twice, once is used",)
    assert stone.solid.volume == pytest.approx(8.0)


def test_an_open_surface_is_refused_and_it_is_said_where():
    with pytest.raises(InputError) as caught:
        stone_of_triangles(CUBE, TRIANGLES[:-2])
    assert str(caught.value) == "is an open surface: a hole with 4 edges round it near (0, 0, 1)"
    with pytest.raises(InputError, match="3 edges round it"):
        stone_of_triangles(CUBE, TRIANGLES[1:])
    with pytest.raises(InputError, match="2 holes, the largest with 4 edges"):
        stone_of_triangles(CUBE, TRIANGLES[3:])


def test_an_edge_that_neighbours_divide_otherwise_is_no_hole():
    """A side in two halves, whose common edge ends on an edge of its neighbour."""
    vertices = np.concatenate([CUBE, [[0.0, -1.0, 1.0], [0.0, 1.0, 1.0]]])
    halves = fans([(1, 8, 9, 3), (8, 5, 7, 9)])
    stone = stone_of_triangles(vertices, np.concatenate([TRIANGLES[:-2], halves]), up="z")
    assert len(stone.facets) == 6
    assert stone.solid.volume == pytest.approx(8.0)


@pytest.mark.parametrize("up", UP)
def test_the_way_up_that_is_given(up):
    block = CUBE * (1.0, 2.0, 3.0)
    stone = stone_of_triangles(block, TRIANGLES, up=up)
    long, wide, deep = {"x": (3, 2, 1), "y": (3, 1, 2), "z": (2, 1, 3)}[up[-1]]
    box = np.ptp(stone.vertices, axis=0)
    assert sorted(box[:2])[::-1] == pytest.approx([2.0, 2.0 * wide / long])
    assert box[2] == pytest.approx(2.0 * deep / long)
    assert stone.notes == ()


@pytest.mark.parametrize("up", UP)
def test_ways_up_are_rotations(up):
    turn = turned_up(np.array(UP[up]))
    np.testing.assert_allclose(turn @ UP[up], [0, 0, 1])
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_what_is_no_way_up_is_refused():
    with pytest.raises(InputError, match="up = 'w': must be one of x, y, z, -x, -y, -z"):
        stone_of_triangles(CUBE, TRIANGLES, up="w")


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
@pytest.mark.parametrize("unit", [0.0254, 1.0, 1000.0])
def test_meshes_as_found(pear, up, unit):
    """Soup of six digits, wound both ways, any way up, in any unit: the design's facets, the table up."""
    vertices, triangles = triangles_of(pear)
    turned = unit * vertices @ turned_up(np.array(UP[up]))
    corners = np.array([[float(f"{x:.6g}") for x in v] for v in turned.tolist()])[triangles]
    rng = np.random.default_rng(5)
    flipped = rng.random(len(corners)) < 0.3
    corners[flipped] = corners[flipped, ::-1]
    stone = stone_of_triangles(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    assert stone.notes[1] == f"the largest facet was taken for the table: {up} is up"
    assert Counter(stone.facet_sides) == Counter(pear.facet_sides)
    # The outline may come turned by quarters: the first axis across is another.
    assert min(apart(stone, pear.rotated(turn)) for turn in (0, 90, 180, 270)) < SIX_DIGITS or unit != 1
    assert stone.solid.volume == pytest.approx(pear.solid.volume, rel=SIX_DIGITS)


def test_an_oblique_mesh_is_turned_up(pear):
    vertices, triangles = triangles_of(pear)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    stone = stone_of_triangles(vertices @ turn.T, triangles)
    assert stone.facet_kinds[0] == "T"
    assert stone.facet_normals[0] == pytest.approx([0, 0, 1])
    assert stone.facet_sides.count("girdle") == pear.facet_sides.count("girdle") > 0


def test_a_girdle_of_many_facets_stays_as_it_is():
    """A drum of 512 level facets; neighbours differ by 0.7 degrees."""
    angle = np.arange(512) * (2 * np.pi / 512)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(512)])
    vertices = np.concatenate([ring, ring + np.array([0.0, 0.0, 0.5])])
    sides = [(k, (k + 1) % 512, 512 + (k + 1) % 512, 512 + k) for k in range(512)]
    caps = [tuple(range(511, -1, -1)), tuple(range(512, 1024))]
    vertices = np.round(vertices, 6)
    stone = stone_of_triangles(vertices, fans([*sides, *caps]))
    assert Counter(stone.facet_sides) == {"crown": 1, "girdle": 512, "pavilion": 1}
    assert (stone.facet_normals[1:513, 2] == 0).all()


# ---- Not convex ----------------------------------------------------------------------------------------


def dented() -> tuple[np.ndarray, np.ndarray]:
    """The cube with a pyramid dug into its top."""
    vertices = np.concatenate([CUBE, [[0.0, 0.0, 0.5]]])
    return vertices, np.concatenate([TRIANGLES[:-2], fans([(1, 5, 8), (5, 7, 8), (7, 3, 8), (3, 1, 8)])])


def test_a_mesh_that_is_not_convex_is_a_mesh():
    stone = stone_of_triangles(*dented(), up="z")
    assert isinstance(stone.solid, MeshSolid)
    assert stone.solid.volume == pytest.approx(8.0 - 4.0 * 0.5 / 3.0)
    assert Counter(stone.facet_sides) == {"crown": 4, "girdle": 4, "pavilion": 1}
    assert stone.facet_kinds[:4] == ("C1",) * 4
    assert stone.notes == ("it is not convex",)
    assert not stone.is_convex
    rises = stone.solid.planes[:, 2]
    for number, facet in enumerate(stone.facets):
        of_facet = rises[stone.solid.facet == number]
        assert {"crown": 1, "girdle": 0, "pavilion": -1}[facet.side] == np.sign(of_facet[0].round(9))


def test_a_dented_mesh_is_mended_and_refused_as_others_are():
    vertices, triangles = dented()
    mixed = triangles.copy()
    mixed[::2] = mixed[::2, ::-1]
    stone = stone_of_triangles(vertices, mixed, up="z")
    assert stone.solid.volume == pytest.approx(8.0 - 4.0 * 0.5 / 3.0)
    assert "7 of 14 triangles faced inwards; turned" in stone.notes
    stone = stone_of_triangles(vertices, triangles[:, ::-1], up="z")
    assert "all triangles faced inwards; turned" in stone.notes
    with pytest.raises(InputError, match="is an open surface: a hole with 3 edges"):
        stone_of_triangles(vertices, triangles[:-1])
    two = np.concatenate([vertices, vertices + 5.0])
    with pytest.raises(InputError, match="is 2 closed surfaces; a stone is one"):
        stone_of_triangles(two, np.concatenate([triangles, triangles + len(vertices)]))
    fin = np.concatenate([triangles, [[0, 1, 8]]])
    with pytest.raises(InputError, match="belong to more than two triangles, one near"):
        stone_of_triangles(vertices, fin)


def test_a_surface_that_runs_through_itself_and_encloses_nothing_is_refused():
    """A cube whose upper half is the mirror image of a cube's: what it encloses above is negative."""
    vertices = CUBE * np.where(CUBE[:, 2:] > 0, (1.0, -1.0, 1.0), 1.0)
    with pytest.raises(InputError, match="encloses no volume"):
        stone_of_triangles(vertices, TRIANGLES)


def test_a_moebius_strip_has_no_inside():
    ring = [(0, 1, 2), (1, 2, 3), (2, 3, 4), (3, 4, 0), (4, 0, 1)]
    angle = np.arange(5) * 2.0
    vertices = np.column_stack([np.cos(angle), np.sin(angle), np.cos(2 * angle)])
    with pytest.raises(InputError, match=r"twisted|open"):
        stone_of_triangles(vertices, ring)


@pytest.mark.parametrize(
    ("vertices", "triangles", "told"),
    [
        (CUBE, np.zeros((0, 3), int), "has no triangles"),
        (CUBE, [[0, 1, 99]], "a face names a vertex that is not there; there are 8"),
        (CUBE, [[0, 1, -1]], "a face names a vertex that is not there; there are 8"),
        (CUBE * np.nan, TRIANGLES, "the vertices must be finite numbers"),
        (CUBE * 1e60, TRIANGLES, "the vertices must be finite numbers"),
        (CUBE * 0, TRIANGLES, "all vertices are one point"),
        (FLAT, [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]], "is flat: its vertices lie in one plane"),
        (CUBE, TRIANGLES[:2], "has 2 triangles; a closed surface has at least four"),
    ],
)
def test_what_bounds_no_stone_is_told_in_one_line(vertices, triangles, told):
    with pytest.raises(InputError) as caught:
        stone_of_triangles(vertices, triangles)
    assert str(caught.value) == told


# ---- Files ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", MESH_KINDS)
def test_what_is_written_is_read_again(kind, pear, tmp_path):
    path = tmp_path / f"pear.{kind}"
    write_mesh(pear, path)
    again = read_mesh(path)
    assert again.notes == ()  # the file says which way is up
    assert apart(again, pear) < (SINGLE if kind == "glb" else ROUNDING)


@pytest.mark.parametrize("kind", MESH_KINDS)
def test_a_mesh_that_is_not_convex_is_written_and_read_again(kind, tmp_path):
    stone = stone_of_triangles(*dented(), up="z")
    write_mesh(stone, tmp_path / f"dented.{kind}")
    again = read_mesh(tmp_path / f"dented.{kind}")
    assert again.facet_names == stone.facet_names
    assert again.solid.volume == pytest.approx(stone.solid.volume)


def test_obj_files_keep_the_facets_names_and_order(pear, tmp_path):
    write_mesh(pear, tmp_path / "pear.obj")
    groups = [line[2:] for line in (tmp_path / "pear.obj").read_text().split("\n") if line[:2] == "g "]
    assert groups == list(pear.facet_names)


@pytest.mark.parametrize("kind", ["stl", "ply", "glb", "obj"])
def test_trimesh_writes_what_is_read(kind, pear):
    """Binary .stl and .ply, and what other programs make of a mesh."""
    trimesh = pytest.importorskip("trimesh")
    vertices, triangles = triangles_of(pear)
    data = trimesh.Trimesh(vertices, triangles, process=False).export(file_type=kind)
    read, faces = parse_mesh(data.encode() if isinstance(data, str) else bytes(data), kind)
    assert apart(stone_of_triangles(read, faces, up="z"), pear) < SIX_DIGITS


def obj(*lines: str, faces: str = "{}") -> bytes:
    vertices = [f"v {x} {y} {z}" for x, y, z in CUBE]
    polygons = ["f " + " ".join(faces.format(k + 1) for k in quad) for quad in QUADS]
    polygons.insert(3, "usemtl blue\ng other")
    return "\n".join([*lines, *vertices, *polygons]).encode()


def ascii_stl(first: str) -> bytes:
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {:.6E} {:.6E} {:.6E}\n".format(*CUBE[k]) for k in triangle)
        + "endloop\nendfacet\n"
        for triangle in TRIANGLES
    ]
    half = "".join(facets[:5]) + f"endsolid\n{first}\n" + "".join(facets[5:])
    return f"{first}\n{half}endsolid\n".encode()


def binary_stl(head: bytes) -> bytes:
    rows = (struct.pack("<12fH", 0, 0, 0, *CUBE[triangle].reshape(-1), 0) for triangle in TRIANGLES)
    return head.ljust(80) + struct.pack("<I", len(TRIANGLES)) + b"".join(rows)


PLY = b"""ply
format binary_big_endian 1.0
element vertex 8
property float x
property float y
property float z
property uchar red
element face 6
property list uchar int vertex_indices
end_header
"""


@pytest.mark.parametrize(
    ("kind", "data"),
    {
        "quads": ("obj", obj()),
        "materials and textures": ("obj", obj("mtllib a.mtl", "vt 0 0", "vn 0 0 1", faces="{}/1/1")),
        "lines that end in CRLF": ("obj", obj().replace(b"\n", b"\r\n")),
        "two solids in one file": ("stl", ascii_stl("solid part")),
        "capitals": ("stl", ascii_stl("solid part").upper()),
        "binary": ("stl", binary_stl(b"made by hand")),
        "binary that begins as text": ("stl", binary_stl(b"solid made by hand")),
        "big-endian quads": (
            "ply",
            PLY
            + b"".join(struct.pack(">3fB", *corner, 3) for corner in CUBE)
            + b"".join(struct.pack(">B4i", 4, *quad) for quad in QUADS),
        ),
    }.values(),
)
def test_a_cube_as_programs_write_it(kind, data):
    stone = stone_of_triangles(*parse_mesh(data, kind), up="z")
    assert stone.notes == ()
    assert len(stone.facets) == 6
    assert stone.solid.volume == pytest.approx(8.0)


def test_a_scene_of_a_glb_file_is_put_together():
    """Facets as meshes of their own, each with its place."""
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    for number in range(0, 12, 2):
        mesh = trimesh.Trimesh(CUBE - (5, 0, 0), TRIANGLES[number : number + 2], process=True)
        scene.add_geometry(mesh, transform=trimesh.transformations.translation_matrix((5, 0, 0)))
    stone = stone_of_triangles(*parse_mesh(scene.export(file_type="glb"), "glb"), up="z")
    assert stone.solid.volume == pytest.approx(8.0)


@pytest.mark.parametrize("kind", MESH_KINDS)
@pytest.mark.parametrize("data", [b"", b"nothing", b"solid\n", b"ply\n", b"glTF" + b"\0" * 40, b"v 1 2\nf 1"])
def test_what_is_no_mesh_is_told_in_one_line(kind, data, tmp_path, capfd):
    path = tmp_path / f"bad.{kind}"
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_mesh(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_glb_file_that_asks_for_the_earth_gets_nothing():
    content = b'{"accessors": [{"count": 99999999999}]}'
    head = b"glTF" + (2).to_bytes(4, "little") + (20 + len(content)).to_bytes(4, "little")
    with pytest.raises(InputError, match="says that it has more than it holds"):
        parse_mesh(head + len(content).to_bytes(4, "little") + b"JSON" + content, "glb")


def test_without_trimesh_the_cure_is_told(monkeypatch, tmp_path):
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    (tmp_path / "stone.stl").write_bytes(b"solid")
    with pytest.raises(BackendError, match=r"to cure it: pip install 'gemrender\[mesh\]'$"):
        read_mesh(tmp_path / "stone.stl")


# ---- Scans ---------------------------------------------------------------------------------------------


def test_a_scan(pear, tmp_path):
    body = pear.solid.polyhedron
    faces = [body.polygon(k).tolist() for k in range(len(body.planes))]
    (tmp_path / "pear.srn").write_bytes(scan_file(3000.0 * body.vertices, faces))
    stone = read_scan(tmp_path / "pear.srn", up="z")
    assert apart(stone, pear) < SIX_DIGITS
    assert stone.notes[0] == "a scan, which is read experimentally; its longest side is 6.000 mm"


@pytest.mark.parametrize("data", [b"", b"SPF ", b"SPF ".ljust(36, b"\xff"), b"SPF ".ljust(60, b"\0")])
def test_what_is_no_scan_is_told_in_one_line(data, tmp_path):
    (tmp_path / "bad.srn").write_bytes(data)
    with pytest.raises(InputError, match=r"bad\.srn: (is no readable \.srn file|has no triangles)"):
        read_scan(tmp_path / "bad.srn")


def test_without_the_parser_the_cure_is_told(monkeypatch, tmp_path):
    monkeypatch.setitem(__import__("sys").modules, "srn_parser", None)
    (tmp_path / "stone.srn").write_bytes(b"SPF ")
    with pytest.raises(BackendError, match=r"to cure it: pip install 'gemrender\[scan\]'$"):
        read_scan(tmp_path / "stone.srn")
