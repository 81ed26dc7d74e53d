"""Sarine's .srn files as far as srn-parser tells of them: an SPF container with a mesh of DirectX."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np


def scan_file(vertices: np.ndarray, faces: Sequence[Sequence[int]]) -> bytes:
    """Return the bytes of a scan with these vertices [micrometres] and polygons."""
    points = ",\n".join(";".join(f"{x:.6f}" for x in row) + ";" for row in vertices.tolist())
    polygons = ",\n".join(f"{len(face)};{','.join(map(str, face))};" for face in faces)
    mesh = (
        "xof 0303txt 0032\nHeader {\n1;\n0;\n1;\n}\n"
        f"Mesh {{\n{len(vertices)};\n{points};\n{len(faces)};\n{polygons};\n}}\n"
    )
    sections = {"stone.hdr": b"[data]\r\nstoneName=test\r\n", "smesh.dat": mesh.encode()}
    out = b"SPF ".ljust(32, b"\0") + struct.pack("<I", len(sections))
    for name, data in sections.items():
        out += struct.pack("<II", len(data), len(name)) + name.encode() + data
    return out
