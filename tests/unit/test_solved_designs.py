"""Files of solved designs: GemCad's .gem and Gem Cut Studio's .gcs."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gemrender.cuts.asc import read_asc
from gemrender.cuts.design import Design, Tier
from gemrender.cuts.gcs import parse_gcs, read_gcs, write_gcs
from gemrender.cuts.gem import parse_gem, read_gem, write_gem
from gemrender.errors import InputError

CASES = Path(__file__).parents[1] / "cases" / "stones"
#: Rounding of p = normal / distance, and of angles made from normals.
ROUNDING = 1e-14
#: Rounding of numbers of 32 bits, a few of them.
SINGLE = 5e-7
DESIGNS = sorted(CASES.glob("*.asc"))


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.stem)
@pytest.mark.parametrize(
    ("write", "read"), [(write_gem, read_gem), (write_gcs, read_gcs)], ids=["gem", "gcs"]
)
def test_what_is_written_is_read_again(path, write, read, tmp_path):
    design = read_asc(path)
    write(design, tmp_path / "again")
    again = read(tmp_path / "again")
    if path.stem == "slab-chiral" and read is read_gcs:  # a plane stands twice: the second has no corners
        assert again.n_facets == design.n_facets - 1
        return
    np.testing.assert_allclose(again.planes(), design.planes(), atol=ROUNDING)
    assert again.kinds() == design.kinds()
    assert [tier.instructions for tier in again.tiers] == [tier.instructions for tier in design.tiers]
    assert again.index == design.index
    assert np.array_equal(
        again.planes()[:, 2] == 0, design.planes()[:, 2] == 0
    )  # level facets are exactly so
    if read is read_gem:
        assert [tier.angle_deg for tier in again.tiers] == [tier.angle_deg for tier in design.tiers]
        assert (again.gear, again.offset, again.folds) == (design.gear, design.offset, design.folds)


@pytest.mark.parametrize("name", ["round", "novelty-chiral"])
def test_gem_files_are_written_as_gemcad_writes_them(name, tmp_path):
    """Of the same length: the same names, and as many corners (near meets GemCad has fewer)."""
    path = CASES / f"{name}.gem"
    write_gem(read_gem(path), tmp_path / "again.gem")
    assert (tmp_path / "again.gem").stat().st_size == path.stat().st_size


# ---- .gem ----------------------------------------------------------------------------------------------


def gem(facets: list[tuple[tuple[float, float, float], int, bytes]], tail: bytes | None = None) -> bytes:
    """A .gem file of facets (p, tier, text), without corners."""
    out = b""
    for p, tier, text in facets:
        out += struct.pack("<3di", *p, tier) + bytes([len(text)]) + text + struct.pack("<i", 0)
    end = struct.pack("<diiidIdd", -99999.0, 4, 1, -64, 1.62, 0x7FFF, 16.0, 0.0)[:-8] + b"\0" * 8
    return out + (end if tail is None else tail)


CUBE = [
    ((0.0, 2.0, -6e-17), 1, b"G\tcut level"),
    ((2.0, 0.0, 6e-17), 1, b"\t"),
    ((0.0, -2.0, -6e-17), 1, b"\t"),
    ((-2.0, 0.0, -6e-17), 1, b"\t"),
    ((0.0, 0.0, 2.0), 2, b"T\t"),
    ((0.0, 0.0, -2.0), 3, b"K"),
]


def test_a_gem_files_records():
    design = parse_gem(gem(CUBE))
    assert (design.gear, design.offset, design.index) == (-64, 16, 1.62)
    assert (design.folds, design.is_mirrored) == (4, True)
    assert [(tier.angle_deg, tier.distance, tier.names, tier.instructions) for tier in design.tiers] == [
        (-90.0, 0.5, ("G", "", ""), "cut level"),
        (90.0, 0.5, ("",), ""),  # the sign of pz carries the side
        (0.0, 0.5, ("T",), ""),
        (-0.0, 0.5, ("K",), ""),
    ]
    assert design.stone().solid.volume == pytest.approx(8.0)


def test_a_preform_is_left_out_and_told():
    design = parse_gem(gem(CUBE) + b"\7preform" + gem(CUBE[:2], b""))
    assert design.n_facets == 6
    assert design.notes == ("what stands behind the design (a preform) is left out",)


def test_the_corners_of_a_gem_file_are_not_used():
    """In some files they are scaled by 0.81."""
    data = gem(CUBE)
    at = 28 + 1 + len(CUBE[0][2])
    corner = struct.pack("<i3d", 1, 0.4, 0.4, 0.4)
    assert parse_gem(data[:at] + corner + data[at:]) == parse_gem(data)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (b"OCTONUS\0" * 40, "is no GemCad .gem file (OctoNus has another .gem, which is not read)"),
        (gem(CUBE)[:100], "or is cut short"),
        (gem(CUBE)[:-3], "or is cut short"),
        (gem([]), "has no facets"),
        (gem([((0, 0, 0), 1, b"")]), "byte 0: is no GemCad .gem file"),
        (gem([((float("nan"), 0, 0), 1, b"")]), "byte 0: is no GemCad .gem file"),
        (gem(CUBE).replace(b"\xff\x7f\0\0", b"\0\0\0\0"), "is no GemCad .gem file"),
        (gem(CUBE * 900), "more than 5000 facets"),
        (
            gem(CUBE[:1], b"")[:-4] + struct.pack("<i3d", 1, 0, 0, 0) * 10001 + gem([]),
            "more than 10000 corners",
        ),
    ],
)
def test_what_is_no_gem_file_is_told_in_one_line(data, told):
    with pytest.raises(InputError) as caught:
        parse_gem(data)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_facet_through_the_origin_cannot_be_written_as_gem(tmp_path):
    design = Design(tiers=(Tier(angle_deg=0.0, distance=0.0, indices=(96,)),))
    with pytest.raises(InputError, match="passes through the origin"):
        write_gem(design, tmp_path / "stone.gem")
    assert not list(tmp_path.iterdir())


def test_a_facet_that_is_cut_away_has_no_corners(tmp_path):
    cube = parse_gem(gem(CUBE))
    far = Tier(angle_deg=45.0, distance=9.0, indices=(8,), names=("far",))
    away = replace(cube, tiers=(*cube.tiers, far))
    for write, read in ((write_gem, read_gem), (write_gcs, read_gcs)):
        write(away, tmp_path / "again")
        stone = read(tmp_path / "again").stone()
        assert len(stone.facets) == 6
        assert len(stone.notes) == 1


# ---- .gcs ----------------------------------------------------------------------------------------------


def test_the_gcs_design():
    """Sixteen mains above and below a girdle of sixteen facets, and a table: in the file's own numbers."""
    design = read_gcs(CASES / "round-16-main.gcs")
    assert (design.gear, design.index, design.title) == (96, 1.76, "Demo Stone - 16 Main Brilliant")
    assert [(tier.names[0], len(tier.indices)) for tier in design.tiers] == [
        ("P1", 16), ("g1", 16), ("C1", 16), ("T", 1),
    ]  # fmt: skip
    angles = [tier.angle_deg for tier in design.tiers]
    np.testing.assert_allclose(angles, [-43.0, -90.0, 42.0, 0.0], atol=1e-9)
    assert design.tiers[0].indices == tuple(float(k or 96) for k in range(0, 96, 6))
    stone = design.stone()
    assert len(stone.facets) == 3 * 16 + 1
    assert stone.rear_rule == "position"
    depth = float(np.ptp(stone.vertices[:, 2]))
    assert depth == pytest.approx((0.9145970702377691 + 0.6475238804989729) / 0.9807852804032304)


def gcs(*facets: str, tier: str = "", rest: str = "") -> bytes:
    """A .gcs file of a tier of facets, and other text."""
    body = "".join(f"<facet {facet}</facet>" for facet in facets)
    return (
        f'<GemCutStudio version="1000"><index gear="96" base="0"/>'
        f'<tier angle="0" depth="1" name="A" instructions="cut" {tier}>{body}</tier>{rest}</GemCutStudio>'
    ).encode()


TABLE = (
    'nx="0" ny="0" nz="1"><vertex x="1" y="0" z="0.3"/><vertex x="0" y="1" z="0.3"/>'
    '<vertex x="-1" y="0" z="0.3"/>'
)


def test_the_vertices_of_a_gcs_file_say_where_the_plane_is():
    """The depth of a tier is measured otherwise in some files."""
    design = parse_gcs(gcs(TABLE))
    assert design.tiers == (
        Tier(angle_deg=0.0, distance=0.3, indices=(96.0,), names=("A",), instructions="cut"),
    )
    assert design.notes == ("nothing is no refractive index above 1; it is left out",)


def test_guides_and_facets_without_corners_are_left_out():
    bare = 'nx="0" ny="1" nz="0"><vertex x="1" y="0" z="0.3"/>'
    assert "1 facets without three vertices" in parse_gcs(gcs(TABLE, bare)).notes[0]
    with pytest.raises(InputError, match="no facets with three vertices"):
        parse_gcs(gcs(TABLE, tier='guide="true"'))


def test_numbers_of_32_bits_make_whole_tiers(tmp_path):
    """As Gem Cut Studio writes them: the facets of a tier differ by rounding, and are one tier still."""
    design = read_asc(CASES / "pear.asc")
    write_gcs(design, tmp_path / "double.gcs")
    text = (tmp_path / "double.gcs").read_text().split('"')
    rounded = [repr(float(np.float32(w))) if k % 2 and "." in w[:3] else w for k, w in enumerate(text)]
    single = parse_gcs('"'.join(rounded).encode())
    assert len(single.tiers) == len(design.tiers)
    assert [tier.indices for tier in single.tiers] == [tier.indices for tier in design.tiers]
    np.testing.assert_allclose(single.planes(), design.planes(), atol=SINGLE)
    assert len(single.stone().facets) == len(design.stone().facets)


def test_an_origin_outside_the_stone_is_moved_inside(tmp_path):
    write_gcs(parse_gem(gem(CUBE)), tmp_path / "cube.gcs")
    text = (tmp_path / "cube.gcs").read_text()
    for z in ("0.5", "-0.5"):
        text = text.replace(f'z="{z}"', f'z="{float(z) + 7}"')
    stone = parse_gcs(text.encode()).stone()
    assert stone.solid.volume == pytest.approx(8.0)
    assert "the origin is outside the stone; it was moved to its middle" in stone.notes


BOMB = b'<!DOCTYPE a [<!ENTITY b "bbbbbbbb"><!ENTITY c "&b;&b;&b;">]><GemCutStudio>&c;</GemCutStudio>'


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (BOMB, "has a document type or entities, which no Gem Cut Studio file has"),
        (b"<a></b>", "is no Gem Cut Studio file: mismatched tag"),
        (b"<svg/>", "is no Gem Cut Studio file: its root is svg, not GemCutStudio"),
        (b"", "is no Gem Cut Studio file: no element found"),
        (b'<?xml version="1.0" encoding="nix"?><a/>', "is no Gem Cut Studio file"),
        (gcs(), "has no facets with three vertices"),
        (gcs(TABLE).replace(b'nz="1"', b'nz="x"'), "tier 1 facet 1 nz = 'x': must be a number"),
        (gcs(TABLE).replace(b'nz="1"', b""), "tier 1 facet 1 nz = None: must be a number"),
        (gcs(TABLE).replace(b'nz="1"', b'nz="0"'), "tier 1 facet 1: the normal must not be 0"),
        (gcs(TABLE).replace(b'z="0.3"', b'z="1e99"', 1), "tier 1 facet 1 z = '1e99': must be a number"),
        (gcs(TABLE).replace(b'"96"', b'"0"'), "index = (0.0, 0.0): the number of teeth must be 1 to 100000"),
    ],
)
def test_what_is_no_gcs_file_is_told_in_one_line(data, told):
    with pytest.raises(InputError) as caught:
        parse_gcs(data)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
