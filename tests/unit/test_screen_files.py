"""Pictures for the screen besides PNG: which ending is what, JPEG, WebP, GIF and animated WebP."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from PIL import Image

import gemrender
from gemrender.errors import InputError
from gemrender.render.film_files import check_film, encode_film, frame_times_ms
from gemrender.render.formats import Background, output_kind
from gemrender.render.picture_files import write_png
from gemrender.render.web_files import write_jpeg, write_webp

SOFTWARE = f"gemrender {gemrender.__version__}"
TITLE, DESCRIPTION = "Größe <3> & 日本 (diamond)", "set-up Studio, 8 samples"
#: JPEG at quality 95 [of 255]: rms of a picture of smooth colours, and of one pixel's saturated colour.
JPEG_RMS, JPEG_FIRE = 2.0, 30.0
#: 255 colours and a dither of 8 for three ramps [of 255].
GIF_RMS = 8.0
#: Animated WebP at quality 90 [of 255], of ramps with a step: its colour has half the resolution.
WEBP_RMS = 9.0
EXIF, COLOUR_SPACE, SRGB = 0x8769, 0xA001, 1


def ramps(shift=0, alpha=False):
    """A smooth picture (48, 64, 3 or 4); with alpha a disc."""
    y, x = np.mgrid[:48, :64]
    rgb = np.stack([(4 * x + shift) % 256, 5 * y, 255 - 2 * (x + y)], axis=-1).clip(0, 255)
    if alpha:
        cover = np.clip(20.5 - np.hypot(x - 31.5, y - 23.5), 0, 1)
        rgb = np.dstack([rgb, np.rint(255 * cover)])
    return rgb.astype(np.uint8)


def rms(a, b):
    return float(np.sqrt(np.mean((np.asarray(a, float) - np.asarray(b, float)) ** 2)))


def read(path):
    with Image.open(path) as image:
        image.load()
        return image.copy(), image.getexif(), image.info


def xmp_texts(packet):
    tree = ElementTree.fromstring(packet)
    return {element.tag.rpartition("}")[2]: "".join(element.itertext()) for element in tree[0][0]}


# ---- Which ending is what ------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".jpeg", ".webp", ".exr", ".JPG"])
def test_without_frames_it_is_a_still_picture(suffix):
    assert output_kind(f"a{suffix}") == "still"


@pytest.mark.parametrize("suffix", [".mp4", ".gif", ".webp", ".GIF"])
def test_with_frames_it_is_a_film(suffix):
    assert output_kind(f"a{suffix}", frames=3) == "film"


@pytest.mark.parametrize("name", ["a.png", "a.webp", "a.exr"])
def test_a_background_may_be_transparent(name):
    assert output_kind(name, transparent=Background("transparent") is Background.TRANSPARENT) == "still"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"path": "a.bmp"}, "out = 'a.bmp': must end in .png, .jpg, .jpeg, .webp, .exr, .mp4, .gif"),
        ({"path": "a"}, "out = 'a': must end in "),
        ({"path": "a.mp4"}, "frames: missing: a film needs a number of frames"),
        (
            {"path": "a.gif"},
            "frames: missing: a film needs a number of frames; still pictures end in .png or .webp",
        ),
        ({"path": "a.jpg", "frames": 9}, "frames = 9: go with a film, a file that ends in .mp4, .gif, .webp"),
        ({"path": "a.jpg", "transparent": True}, "background = 'transparent': has no place in a .jpg file"),
        (
            {"path": "a.mp4", "frames": 9, "transparent": True},
            "background = 'transparent': has no place in a .mp4 file; take .png, .webp, .exr or .gif",
        ),
        (
            {"path": "a.webp", "size": (16384, 9)},
            "size = '16384x9': must be up to 16383 for a .webp file",
        ),
    ],
)
def test_what_no_file_can_be_is_one_line(arguments, words):
    with pytest.raises(InputError) as caught:
        output_kind(**arguments)
    assert str(caught.value).startswith(words)


# ---- Still pictures ------------------------------------------------------------------------------------


def test_a_jpeg_keeps_its_colours(tmp_path):
    write_jpeg(tmp_path / "a.jpg", ramps())
    image, _, _ = read(tmp_path / "a.jpg")
    assert (image.format or "JPEG", image.mode) == ("JPEG", "RGB")
    assert rms(image, ramps()) < JPEG_RMS


def test_a_jpeg_keeps_the_colour_of_a_single_pixel(tmp_path):
    """Fire: with colour at half resolution a red pixel among greys would be a quarter as red."""
    picture = np.full((16, 16, 3), 90, np.uint8)
    picture[7, 7] = (230, 40, 40)
    write_jpeg(tmp_path / "a.jpg", picture)
    seen = np.asarray(read(tmp_path / "a.jpg")[0], float)[7, 7]
    np.testing.assert_allclose(seen, picture[7, 7], atol=JPEG_FIRE)


@pytest.mark.parametrize("alpha", [False, True])
def test_a_webp_is_the_picture(tmp_path, alpha):
    picture = ramps(alpha=alpha)
    write_webp(tmp_path / "a.webp", picture)
    seen = np.asarray(read(tmp_path / "a.webp")[0])
    shown = picture[..., -1] > 0 if alpha else np.ones(picture.shape[:2], bool)
    assert seen.shape == picture.shape
    np.testing.assert_array_equal(seen[shown], picture[shown])
    if alpha:
        np.testing.assert_array_equal(seen[..., 3], picture[..., 3])


def test_a_png_has_straight_alpha(tmp_path):
    write_png(tmp_path / "a.png", ramps(alpha=True))
    image, _, _ = read(tmp_path / "a.png")
    assert image.mode == "RGBA"
    np.testing.assert_array_equal(image, ramps(alpha=True))


@pytest.mark.parametrize(("name", "write"), [("a.jpg", write_jpeg), ("a.webp", write_webp)])
def test_a_picture_tells_what_it_is(tmp_path, name, write):
    write(tmp_path / name, ramps(), title=TITLE, description=DESCRIPTION)
    _, exif, info = read(tmp_path / name)
    assert exif[0x0131] == SOFTWARE
    assert exif[0x010E] == DESCRIPTION
    assert exif.get_ifd(EXIF)[COLOUR_SPACE] == SRGB
    assert xmp_texts(info["xmp"]) == {"CreatorTool": SOFTWARE, "title": TITLE, "description": DESCRIPTION}


@pytest.mark.parametrize(("name", "write"), [("a.jpg", write_jpeg), ("a.webp", write_webp)])
def test_names_that_no_metadata_can_hold_are_no_hindrance(tmp_path, name, write):
    write(tmp_path / name, ramps(), title="a\0b\ud800\n" + "&" * 70_000, description="\x1b[2J")
    texts = xmp_texts(read(tmp_path / name)[2]["xmp"])
    assert texts["title"].startswith("a\ufffdb\ufffd &&&")
    assert texts["description"] == "\ufffd[2J"


@pytest.mark.parametrize(("name", "write"), [("a.jpg", write_jpeg), ("a.webp", write_webp)])
def test_bad_pictures_are_refused(tmp_path, name, write):
    for bad in (ramps().astype(float), ramps()[0], ramps()[..., :2], ramps()[:0]):
        with pytest.raises(InputError, match=r"rgb8 = .*: must be an array \(h, w, 3\) of uint8"):
            write(tmp_path / name, bad)
    with pytest.raises(InputError, match="none: cannot be written: No such file"):
        write(tmp_path / "none" / name, ramps())
    assert not list(tmp_path.iterdir())


def test_a_jpeg_takes_no_alpha(tmp_path):
    with pytest.raises(InputError, match=r"must be an array \(h, w, 3\) of uint8$"):
        write_jpeg(tmp_path / "a.jpg", ramps(alpha=True))


@pytest.mark.parametrize(("name", "write"), [("a.jpg", write_jpeg), ("a.webp", write_webp)])
def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch, name, write):
    (tmp_path / name).write_bytes(b"before")

    def full(self, path, *_, **__):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("PIL.Image.Image.save", full)
        with pytest.raises(InputError, match=f"{name}: cannot be written: No space left on device"):
            write(tmp_path / name, ramps())
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"before"]


# ---- Films ---------------------------------------------------------------------------------------------


@pytest.fixture
def frames(tmp_path):
    """Write frames as PNG; returns their files and what they show."""

    def write(n=5, *, alpha=False, still=False):
        pictures = [ramps(0 if still else 8 * k, alpha) for k in range(n)]
        return [write_png(tmp_path / f"{k}.png", p) for k, p in enumerate(pictures)], pictures

    return write


def film(path):
    """Return a film's frames (h, w, 4), how long each is shown [ms], and how often it goes round."""
    shown, times = [], []
    with Image.open(path) as image:
        for k in range(image.n_frames):
            image.seek(k)
            image.load()
            times.append(image.info["duration"])
            shown.append(np.asarray(image.convert("RGBA")))
        return shown, times, image.info


@pytest.mark.parametrize(("name", "within"), [("a.gif", GIF_RMS), ("a.webp", WEBP_RMS)])
def test_a_film_shows_its_frames_for_ever(tmp_path, frames, name, within):
    files, pictures = frames()
    encode_film(tmp_path / name, files, 10.0)
    shown, times, info = film(tmp_path / name)
    assert times == [100] * 5
    assert info["loop"] == 0
    for seen, picture in zip(shown, pictures, strict=True):
        assert rms(seen[..., :3], picture) < within
        assert (seen[..., 3] == 255).all()


def test_frame_times_add_up():
    assert frame_times_ms(30.0, 6) == [33, 34, 33, 33, 34, 33]
    assert frame_times_ms(30.0, 6, step_ms=10) == [30, 40, 30, 30, 40, 30]
    assert sum(frame_times_ms(24.0, 240, step_ms=10)) == 10_000


def test_what_stands_still_stays_still_in_a_gif(tmp_path, frames):
    """A dither that runs over the picture would flicker below and right of what moves."""
    files, pictures = frames(3, still=True)
    moved = pictures[1].copy()
    moved[:8, :8] = 255 - moved[:8, :8]
    write_png(files[1], moved)
    encode_film(tmp_path / "a.gif", files, 10.0)
    shown, _, _ = film(tmp_path / "a.gif")
    np.testing.assert_array_equal(shown[0][8:], shown[1][8:])
    np.testing.assert_array_equal(shown[0], shown[2])
    assert (shown[0][:8, :8] != shown[1][:8, :8]).any()


def test_a_gif_has_colours_for_fire(tmp_path, frames):
    """One saturated pixel in a thousand, among many greys."""
    files, _ = frames(2)
    picture = np.repeat(np.arange(64, dtype=np.uint8)[None, :, None] * 3, 48, axis=0).repeat(3, axis=2)
    picture[10, 10:13] = (0, 60, 255), (255, 120, 0), (40, 255, 120)
    for file in files:
        write_png(file, picture)
    encode_film(tmp_path / "a.gif", files, 10.0)
    seen = film(tmp_path / "a.gif")[0][0][10, 10:13, :3]
    np.testing.assert_allclose(seen.astype(float), picture[10, 10:13], atol=2 * GIF_RMS)


def test_a_gif_is_opaque_or_not(tmp_path, frames):
    files, pictures = frames(3, alpha=True)
    encode_film(tmp_path / "a.gif", files, 10.0)
    for seen, picture in zip(film(tmp_path / "a.gif")[0], pictures, strict=True):
        opaque = picture[..., 3] >= 128
        np.testing.assert_array_equal(seen[..., 3], 255 * opaque)
        assert rms(seen[opaque][:, :3], picture[opaque][:, :3]) < GIF_RMS


def test_an_animated_webp_has_alpha(tmp_path, frames):
    files, pictures = frames(3, alpha=True)
    encode_film(tmp_path / "a.webp", files, 10.0)
    for seen, picture in zip(film(tmp_path / "a.webp")[0], pictures, strict=True):
        np.testing.assert_array_equal(seen[..., 3], picture[..., 3])
        opaque = picture[..., 3] == 255
        assert rms(seen[opaque][:, :3], picture[opaque][:, :3]) < 2 * WEBP_RMS


def test_films_tell_what_they_are(tmp_path, frames):
    files, _ = frames(2)
    for name in ("a.gif", "a.webp"):
        encode_film(tmp_path / name, files, 10.0, title=TITLE, description=DESCRIPTION)
    assert film(tmp_path / "a.gif")[2]["comment"].decode() == "; ".join(
        (TITLE.encode("ascii", "replace").decode(), DESCRIPTION, SOFTWARE)
    )
    texts = xmp_texts(film(tmp_path / "a.webp")[2]["xmp"])
    assert texts == {"CreatorTool": SOFTWARE, "title": TITLE, "description": DESCRIPTION}


def test_an_mp4_tells_what_it_is(tmp_path, frames):
    av = pytest.importorskip("av")
    files, _ = frames(2)
    encode_film(tmp_path / "a.mp4", files, 10.0, title=TITLE, description=DESCRIPTION)
    with av.open(str(tmp_path / "a.mp4")) as opened:
        assert opened.metadata["title"] == TITLE
        assert opened.metadata["comment"] == DESCRIPTION


@pytest.mark.parametrize("name", ["a.mp4", "a.gif", "a.webp"])
def test_a_film_is_written_whatever_its_stones_are_called(tmp_path, frames, name):
    if name == "a.mp4":
        pytest.importorskip("av")
    files, _ = frames(2)
    encode_film(tmp_path / name, files, 10.0, title="a\0b\ud800\n" + "&" * 70_000, description="\x1b[2J")
    assert (tmp_path / name).stat().st_size > 0


@pytest.mark.parametrize("name", ["a.gif", "a.webp"])
def test_gif_and_webp_need_no_film_library_and_no_even_size(tmp_path, name, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    check_film(tmp_path / name, 15, 15, 2, 30.0)


def test_a_gif_is_not_faster_than_players_play_it(tmp_path):
    check_film(tmp_path / "a.gif", 16, 16, 2, 50.0)
    with pytest.raises(
        InputError, match=r"^fps = 60.0: must be from 1 to 50 \[frames a second\] in a .gif file$"
    ):
        check_film(tmp_path / "a.gif", 16, 16, 2, 60.0)
