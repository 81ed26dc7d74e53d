"""Scenes as files: what Mitsuba reads back renders to the maps of `gemrender.observe`, bit by bit."""

from __future__ import annotations

import textwrap

import numpy as np
import pytest
from observations import ROOT, STONE, run_python
from physics_tolerances import ROUNDING, SINGLE
from scipy.spatial import cKDTree
from solids import cleft_heart

import gemrender
from gemrender.cuts import stone_from_vertices
from gemrender.errors import InputError
from gemrender.observation import MAP_CHANNELS, Model, View
from gemrender.scene import stone_scene
from gemrender.scene.xml import write_scene
from gemrender.stone import Stone

#: The scene that is in the repository, and the command that writes it.
COMMITTED = ROOT / "scenes" / "inoue-3.xml"
RESOLUTION = 512
PEAR = gemrender.load_stone(ROOT / "tests" / "cases" / "stones" / "pear.asc")
COMMAND = f"gemrender scene inoue-3 --out scenes --resolution {RESOLUTION}"


def assert_renders_as(path, observed):
    """Load a scene file as any user of Mitsuba does, render it, and compare every channel."""
    import mitsuba as mi

    scene = mi.load_file(str(path))
    image = np.asarray(mi.render(scene))
    names = scene.integrator().aov_names()
    first = image.shape[-1] - len(names)
    for name, channels in MAP_CHANNELS.items():
        parts = np.moveaxis(np.atleast_3d(getattr(observed, name)), -1, 0)
        for channel, expected in zip(channels, parts, strict=True):
            rendered = image[..., first + names.index(channel)]
            np.testing.assert_array_equal(rendered, expected, err_msg=channel)


def written_anew(folder):
    stone = gemrender.load_stone("inoue-3")
    return write_scene(folder, "inoue-3", stone, View.of(stone, RESOLUTION), Model.of(stone))


def test_the_committed_scene_is_what_the_generator_writes(tmp_path, variant_llvm_ad_mono):
    same = written_anew(tmp_path).read_bytes() == COMMITTED.read_bytes()
    assert same, f"{COMMITTED.name} is out of date; write it anew by: {COMMAND}"


def test_the_committed_mesh_is_what_the_generator_writes(tmp_path, variant_llvm_ad_mono):
    """But for the last bits, in which numpy's sines differ, and for the order, which is Qhull's."""
    (head, *new), (committed_head, *old) = (
        mesh_file(path.with_suffix(".ply")) for path in (written_anew(tmp_path), COMMITTED)
    )
    assert head == committed_head, f"the mesh is out of date; write it anew by: {COMMAND}"
    for (vertices, corners, planes), (others, other_corners, other_planes) in ((new, old), (old, new)):
        assert len(corners) == len(other_corners)
        assert cKDTree(others).query(vertices)[0].max() <= 2 * SINGLE
        assert cKDTree(other_planes).query(planes)[0].max() <= 2 * ROUNDING


def mesh_file(path):
    """Return a PLY file's header, its vertices with their normals, its faces, and their planes."""
    head, _, data = path.read_bytes().partition(b"end_header\n")
    vertices, faces = (int(line.split()[2]) for line in head.decode().splitlines() if "element" in line)
    properties = [line.split()[-1] for line in head.decode().splitlines() if "property float" in line]
    per_face = properties[properties.index("facet_0") :]
    vertex = np.frombuffer(data, dtype=("<f4", 6), count=vertices)
    kind = np.dtype([("n", "u1"), ("corners", "<i4", 3), ("rest", "<f4", len(per_face))])
    face = np.frombuffer(data, dtype=kind, count=faces, offset=vertex.nbytes)
    rest = dict(zip(per_face, face["rest"].T.astype(np.float64), strict=True))
    # Planes are told by two single-precision numbers each: the second is what the first has rounded off.
    planes = [rest[name] + rest[name.replace("high", "low")] for name in per_face if "high" in name]
    return head, vertex, face["corners"], np.array([rest["facet_0"], *planes])


def test_the_committed_scene_renders_to_the_observed_maps(variant_llvm_ad_mono):
    assert_renders_as(COMMITTED, gemrender.observe(STONE, engine="mitsuba", resolution=RESOLUTION))


def test_a_scene_renders_alike_in_every_variant(tmp_path, variants_all):
    view = View.of(STONE, 64)
    path = write_scene(tmp_path, "stone", STONE, view, Model.of(STONE))
    assert_renders_as(path, gemrender.observe(STONE, engine="mitsuba", resolution=64, variant=variants_all))


def test_all_options_survive(tmp_path, variant_llvm_ad_mono):
    stone = Stone.from_proportions(STONE.proportions, name="a sapphire", material="sapphire")
    view = View.of(stone, 64, tilt_deg=20.5, tilt_azimuth_deg=-33.3)
    model = Model.of(stone, fresnel="exact", rear="direction", intensity="radiance")
    path = write_scene(tmp_path, "stone", stone, view, model)
    assert_renders_as(path, gemrender.observe(stone, engine="mitsuba", view=view, model=model))


def test_a_crystal_survives(tmp_path, variant_llvm_ad_mono):
    """To the last bit: the same random numbers draw the same modes."""
    import mitsuba as mi

    stone = Stone.from_proportions(STONE.proportions, name="a topaz", material="topaz")
    view, model = View.of(stone, 48), Model.of(stone)
    path = write_scene(tmp_path, "stone", stone, view, model, birefringence=True)
    read, made = mi.load_file(str(path)), mi.load_dict(stone_scene(stone, view, model, birefringence=True))
    images = [np.asarray(mi.render(scene, spp=2, seed=3)) for scene in (read, made)]
    assert images[0][..., 1].max() > 0
    np.testing.assert_array_equal(*images)


@pytest.mark.parametrize("stone", [PEAR, cleft_heart()], ids=["pear", "heart"])
def test_stones_of_other_cuts_survive(tmp_path, variant_llvm_ad_mono, stone):
    model = Model.of(stone, index=1.54)
    path = write_scene(tmp_path, "stone", stone, View.of(stone, 64), model)
    assert_renders_as(path, gemrender.observe(stone, engine="mitsuba", resolution=64, model=model))


def test_names_may_be_of_any_script(tmp_path, variant_llvm_ad_mono):
    stone = stone_from_vertices(STONE.vertices, name="石 <№ 1> & --- co")
    path = write_scene(tmp_path / "ü 石", "石-1", stone, View.of(stone, 16), Model.of(stone))
    assert_renders_as(path, gemrender.observe(stone, engine="mitsuba", resolution=16))


def test_the_committed_scene_says_how_to_read_it():
    comment = COMMITTED.read_text(encoding="utf-8").partition("-->")[0]
    title, *code = textwrap.dedent(comment).splitlines()
    assert title.startswith("<!-- Inoue sample 3, ")
    code = textwrap.dedent("\n".join(code)) + "\nprint(scene.integrator().aov_names()[0])"
    done = run_python("-c", code, cwd=COMMITTED.parent)
    assert done.stdout == "primary.intensity\n", done.stderr


def test_nothing_else_is_left_behind(tmp_path, variant_llvm_ad_mono):
    write_scene(tmp_path, "x", STONE, View.of(STONE, 16), Model())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["x.ply", "x.xml"]


def test_a_file_in_the_place_of_the_folder_is_told(tmp_path, variant_llvm_ad_mono):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file: cannot be made: File exists"):
        write_scene(tmp_path / "file", "x", STONE, View.of(STONE, 16), Model())


def test_a_folder_in_the_place_of_the_mesh_is_told(tmp_path, variant_llvm_ad_mono):
    (tmp_path / "x.ply").mkdir()
    with pytest.raises(InputError, match=r"x\.ply: cannot be written: Is a directory"):
        write_scene(tmp_path, "x", STONE, View.of(STONE, 16), Model())
    assert [path.name for path in tmp_path.iterdir()] == ["x.ply"]
