"""Pictures as JPEG and WebP, for pages and mails: small, 8 bits a channel, sRGB."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from gemrender.render.picture_files import check_picture, file_of, software
from gemrender.writing import write_whole

__all__ = ["described", "plain_text", "write_jpeg", "write_webp"]

#: JPEG at which sparkles and straight edges keep no visible ringing; above it files grow and nothing is
#: gained. Colour at full resolution: fire is a pixel or two across, and half of it would be smeared away.
JPEG_OPTIONS: dict[str, Any] = {"quality": 95, "subsampling": "4:4:4", "optimize": True}
#: WebP without loss: its lossy kind has colour at half resolution only.
WEBP_OPTIONS: dict[str, Any] = {"lossless": True, "quality": 50, "method": 4}

#: Tags of EXIF: description, software, and colour space with its value for sRGB.
_DESCRIPTION, _SOFTWARE, _EXIF_IFD, _COLOUR_SPACE, _SRGB = 0x010E, 0x0131, 0x8769, 0xA001, 1
#: Longest text: XMP must fit into one segment of a JPEG, 64 KiB, at up to 4 bytes a character, two of them.
_LONGEST = 6000


def write_jpeg(path: str | os.PathLike[str], rgb8: Any, *, title: str = "", description: str = "") -> Path:
    """Write a picture as JPEG, sRGB, whole or not at all; return the path.

    Parameters
    ----------
    path : path
        The file, in a folder that is there.
    rgb8 : array_like (h, w, 3) of uint8
        The picture, as of `develop`.
    title, description : str
        What the picture is: in XMP, the description in EXIF too.

    Raises
    ------
    InputError
        Another shape or type, or a file that cannot be written.
    """
    return _write(path, rgb8, "jpeg", JPEG_OPTIONS, title, description, alpha=False)


def write_webp(path: str | os.PathLike[str], rgb8: Any, *, title: str = "", description: str = "") -> Path:
    """Write a picture as WebP, sRGB, without loss, whole or not at all; return the path.

    Parameters
    ----------
    path : path
        The file, in a folder that is there.
    rgb8 : array_like (h, w, 3) or (h, w, 4) of uint8
        The picture, as of `develop`; the fourth channel is alpha, which the others are not multiplied by.
    title, description : str
        What the picture is: in XMP, the description in EXIF too.

    Raises
    ------
    InputError
        Another shape or type, or a file that cannot be written.
    """
    return _write(path, rgb8, "webp", WEBP_OPTIONS, title, description, alpha=True)


def described(title: str, description: str) -> dict[str, Any]:
    """Return what Pillow writes into JPEG and WebP files: EXIF and XMP (ISO 16684-1)."""
    from PIL import Image

    title, description = plain_text(title), plain_text(description)
    exif = Image.Exif()
    exif[_SOFTWARE] = software()
    if description:
        exif[_DESCRIPTION] = description.encode("ascii", "replace").decode()  # EXIF has no more
    exif.get_ifd(_EXIF_IFD)[_COLOUR_SPACE] = _SRGB
    parts = [f"<xmp:CreatorTool>{escape(software())}</xmp:CreatorTool>"]
    for name, text in (("title", title), ("description", description)):
        if text:
            alternative = f'<rdf:Alt><rdf:li xml:lang="x-default">{escape(text)}</rdf:li></rdf:Alt>'
            parts.append(f"<dc:{name}>{alternative}</dc:{name}>")
    packet = (
        '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?><x:xmpmeta xmlns:x="adobe:ns:meta/">'
        '<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description rdf:about="" '
        'xmlns:dc="http://purl.org/dc/elements/1.1/" xmlns:xmp="http://ns.adobe.com/xap/1.0/">'
        f'{"".join(parts)}</rdf:Description></rdf:RDF></x:xmpmeta><?xpacket end="r"?>'
    )
    return {"exif": exif, "xmp": packet.encode()}


def plain_text(text: str) -> str:
    """Return a text that any metadata can hold: on one line, without control characters, not too long."""
    line = " ".join("".join(c if c.isprintable() or c.isspace() else "\ufffd" for c in text).split())
    return line if len(line) <= _LONGEST else line[: _LONGEST - 1] + "…"


def _write(
    path: str | os.PathLike[str],
    rgb8: Any,
    kind: str,
    options: dict[str, Any],
    title: str,
    description: str,
    *,
    alpha: bool,
) -> Path:
    from PIL import Image

    file = file_of(path)
    image = Image.fromarray(check_picture(rgb8, str(file), alpha=alpha))
    about = described(title, description)

    def save(made: Path) -> None:
        image.save(made, kind, **options, **about)

    return write_whole(file.parent, {file.name: save})[0]
