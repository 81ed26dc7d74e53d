"""Whatever the input: a valid watertight stone, or an InputError of one line."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from solids import BRILLIANTS, assert_closed, half_space_volume, mesh_volume
from thorough import examples
from tolerances import MESH_VOLUME, PLANE, QUADRATURE_VOLUME, ROUNDING

from gemrender.cuts import RoundBrilliant, bundled_stones, load_stone, stone_from_vertices
from gemrender.cuts.files import save_vertices
from gemrender.cuts.round_brilliant.proportions import ANGLE_RANGES, RANGES
from gemrender.errors import InputError
from gemrender.stone import Stone, tessellate

# The same examples in every run; no deadline, since machines differ.
REPEATABLE = {"derandomize": True, "deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
#: Rounding of where facets meet the girdle, over the least slope of a facet, 0.01 of a crown of 0.5 %.
LEVEL_ROUNDING = 100 * ROUNDING
#: Pieces of round girdles here.
PIECES = 128

ANYTHING = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(),
    st.sampled_from([math.nan, math.inf, -math.inf, 0, -0.0, 5e-324, 1e308, 10**400, True, None, "54", [1]]),
)


def within(low: float, high: float) -> st.SearchStrategy[float]:
    return st.one_of(st.floats(low, high), st.sampled_from([low, high]))


def near(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low - 0.2 * (high - low), high + 0.2 * (high - low))


@st.composite
def mostly_good(draw: st.DrawFn, ranges: dict[str, tuple[float, float]]) -> dict[str, object]:
    """Values within their ranges, but for one or two of them."""
    values: dict[str, object] = {key: draw(within(*ranges[key])) for key in ranges}
    for key in draw(st.lists(st.sampled_from(list(ranges)), max_size=2)):
        values[key] = draw(st.one_of(near(*ranges[key]), ANYTHING))
    return values


@contextlib.contextmanager
def one_line_or_stone():
    """Let an InputError of one line pass; anything else fails."""
    try:
        yield
    except InputError as error:
        line = str(error)
        assert line
        assert len(line.splitlines()) == 1


def assert_valid(stone: Stone) -> None:
    """Watertight; convex and of the right volume where it is symmetric."""
    mesh = tessellate(stone, PIECES)
    assert_closed(mesh)
    volume = mesh_volume(mesh)
    assert volume > 0
    assert np.abs(np.linalg.norm(stone.solid.planes[:, :3], axis=1) - 1).max() < ROUNDING
    assert np.abs(np.linalg.norm(mesh.corner_normals, axis=-1) - 1).max() < ROUNDING
    if stone.proportions is not None:
        assert (mesh.vertices @ stone.facet_normals.T - stone.facet_offsets).max() < PLANE
        assert np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]).max() < 1 + LEVEL_ROUNDING


# ---- Proportions ---------------------------------------------------------------------------------------


@examples(40, 150, given(st.fixed_dictionaries({key: within(*RANGES[key]) for key in RANGES})), **REPEATABLE)
def test_proportions_within_the_ranges_are_a_stone_or_have_too_short_a_star(values):
    try:
        stone = Stone.from_proportions(RoundBrilliant(**values))
    except InputError as error:
        if error.key == "star" and "the star tips would lie above the table" in str(error):
            return
        raise
    assert_valid(stone)


@settings(max_examples=20, **REPEATABLE)
@given(
    st.fixed_dictionaries(
        # Slopes stay of order 1 here, as the quadrature needs.
        {
            "table": st.floats(30, 75),
            "star": st.floats(45, 80),
            "lower_girdle_contact": st.floats(5, 60),
            "crown_height": st.floats(3, 25),
            "pavilion_depth": st.floats(10, 60),
            "girdle_thickness": st.floats(0, 10),
        }
    )
)
def test_volume_is_that_of_half_spaces_and_cylinder(values):
    proportions = RoundBrilliant(**values)
    expected = half_space_volume(proportions)
    mesh = tessellate(Stone.from_proportions(proportions))
    lacking = expected - mesh_volume(mesh)
    assert -QUADRATURE_VOLUME < lacking < MESH_VOLUME + QUADRATURE_VOLUME


@examples(40, 150, given(mostly_good(RANGES)), **REPEATABLE)
def test_proportions_of_any_kind(values):
    with one_line_or_stone():
        assert_valid(Stone.from_proportions(RoundBrilliant(**values)))


_REPORT = {key: (RANGES | ANGLE_RANGES)[key] for key in
           ("table", "crown_angle", "pavilion_angle", "star", "lower_half", "girdle_thickness")}  # fmt: skip


@examples(40, 150, given(mostly_good(_REPORT)), **REPEATABLE)
def test_angles_of_any_kind(values):
    with one_line_or_stone():
        assert_valid(Stone.from_proportions(RoundBrilliant.from_angles(**values)))


# ---- Damaged files -------------------------------------------------------------------------------------

#: What may come in a number's place, or anywhere.
TOKENS = [
    b"nan", b"inf", b"-1", b"0", b"1e400", b"0x" + b"f" * 900, b"true", b'"54"', b"''", b"[]", b"{}",
    b"[[", b"]", b"=", b"#", b",", b";", b'"', b"\n", b"\r", b"\0", b"\xff", b"\xef\xbb\xbf",
    b"\xe2\x80\xa8", b"1979-05-27", b"[proportions]", b"[angles]", b"[material]\n",
    b"vertices = 'v.csv'\n", b"name", b"table = 54\n",
]  # fmt: skip


@st.composite
def damaged(draw: st.DrawFn, texts: list[bytes]) -> bytes:
    """A text after one to four accidents: bytes, tokens and lines lost, changed, doubled or exchanged."""
    text = draw(st.sampled_from(texts))
    for _ in range(draw(st.integers(1, 4))):
        i, j = sorted(draw(st.tuples(*[st.integers(0, max(len(text) - 1, 0))] * 2)))
        lines = text.split(b"\n")
        m, n = draw(st.tuples(*[st.integers(0, len(lines) - 1)] * 2))
        match draw(st.integers(0, 6)):
            case 0:  # one byte changed
                text = text[:i] + draw(st.binary(min_size=1, max_size=1)) + text[i + 1 :]
            case 1:  # a token put in
                text = text[:i] + draw(st.sampled_from(TOKENS)) + text[i:]
            case 2:  # the rest of a line replaced
                separator = b"=" if b"=" in lines[m] else b","
                lines[m] = lines[m].rpartition(separator)[0] + separator + draw(st.sampled_from(TOKENS))
                text = b"\n".join(lines)
            case 3:  # lines exchanged
                lines[m], lines[n] = lines[n], lines[m]
                text = b"\n".join(lines)
            case 4:  # a line lost
                text = b"\n".join(lines[:m] + lines[m + 1 :])
            case 5:  # a line doubled
                text = b"\n".join([*lines[: m + 1], *lines[m:]])
            case 6:  # a piece lost
                text = text[:i] + text[j:]
    return text


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("damaged")
    save_vertices(load_stone("inoue-2"), folder / "v.csv")
    return folder


def load(path: Path, text: bytes) -> None:
    path.write_bytes(text)
    try:
        stone = load_stone(path)
    except InputError as error:
        line = str(error)
        assert line.startswith((str(path), str(path.parent)))
        assert len(line.splitlines()) == 1
        return
    assert stone.name.isprintable()
    assert_valid(stone)


SCENES = [Path(load_stone(name).source or "").read_bytes() for name in bundled_stones()]
MATERIAL = [text + b"\n[material]\nindex = 2.4\n" for text in SCENES[:2]]
SIZES = [
    b"[report]\nshape = 'Oval Brilliant'\ntable = 57\ndepth = 62.2\ngirdle = 'medium'\nculet = 'none'\n"
    b"[size]\nmeasurements = '8.10 x 5.95 x 3.70 mm'\ncarat = 1.08\n",
    b"[cut]\nfamily = 'emerald'\nlength_to_width = 1.39\n[size]\nlength_mm = 7.5\nwidth_mm = 5.40\n",
    b"[report]\ntable = 57\ncrown_angle = 34.5\npavilion_angle = 40.8\n"
    b"[size]\ndiameter_mm = 6.5\ndepth_mm = 4\n",
]


@examples(
    100,
    400,
    given(
        text=damaged(
            [*SCENES, *MATERIAL, *SIZES, b"name = 'x'\nvertices = 'v.csv'\n[material]\nname = 'diamond'\n"]
        )
    ),
    **REPEATABLE,
)
def test_damaged_toml(folder, text):
    load(folder / "stone.toml", text)


ROWS = [
    b"label,x,y,z\n" + b"\n".join(b",".join([b"v", *(repr(c).encode() for c in row)]) for row in rows)
    for rows in (load_stone("inoue-3").vertices.tolist(), (3.2 * load_stone("inoue-1").vertices).tolist())
]


@examples(60, 200, given(text=damaged(ROWS)), **REPEATABLE)
def test_damaged_csv(folder, text):
    load(folder / "measured.csv", text)


@settings(max_examples=50, **REPEATABLE)
@given(text=st.one_of(st.binary(max_size=300), st.text(max_size=300).map(str.encode)))
def test_files_of_anything(folder, text):
    load(folder / "anything.toml", text)
    load(folder / "anything.csv", text)


# ---- Measured vertices ---------------------------------------------------------------------------------

VERTICES = [load_stone(name).vertices for name in BRILLIANTS]


@examples(
    20,
    60,
    given(
        vertices=st.sampled_from(VERTICES),
        exponent=st.floats(-15, -1),
        seed=st.integers(0, 2**32 - 1),
    ),
    **REPEATABLE,
)
def test_jittered_vertices(vertices, exponent, seed):
    jitter = np.random.default_rng(seed).normal(scale=10**exponent, size=vertices.shape)
    with one_line_or_stone():
        assert_valid(stone_from_vertices(vertices + jitter))


@examples(
    30,
    100,
    given(
        vertices=st.sampled_from(VERTICES),
        row=st.integers(0, 56),
        column=st.integers(0, 2),
        value=ANYTHING.filter(lambda value: value is not None),
    ),
    **REPEATABLE,
)
def test_one_vertex_anywhere(vertices, row, column, value):
    rows = vertices.tolist()
    rows[row][column] = value
    with one_line_or_stone():
        assert_valid(stone_from_vertices(rows))


@settings(max_examples=50, **REPEATABLE)
@given(
    vertices=st.sampled_from(VERTICES),
    order=st.permutations(range(57)).filter(lambda order: order != [*range(57)]),
)
def test_vertices_in_another_order_are_refused(vertices, order):
    with pytest.raises(InputError) as caught:
        stone_from_vertices(vertices[order])
    assert len(str(caught.value).splitlines()) == 1
