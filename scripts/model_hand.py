"""Model the hand of the set-up `hand`: three fingers and the palm, in millimetres.

    pip install scikit-image trimesh fast-simplification
    python scripts/model_hand.py scenes/setups/hand.ply

Bones are capsules that get thinner, blended into one another; their surface is that of a distance field.
The ring's finger runs along y, its tip towards -y, and a ring of 17.3 mm inside, standing on height 0
with its middle at x = y = 0, goes around it. Lengths are those of a slender hand, chosen.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np

#: Height of the ring's middle: half of its inner diameter and its thickness, less a little flesh [mm].
MIDDLE = 10.1
#: Step of the grid, and how many triangles are left of its surface.
STEP, TRIANGLES = 0.7, 9000
#: Joints (x, y, z below or above `MIDDLE`) and the radius there, from the palm to the tip [mm].
FINGERS = (
    ((0, 34, -1, 9.0), (0, 0, 0, 8.35), (0.3, -21, -0.6, 8.7), (0.6, -40, -7, 7.6), (0.6, -52, -15, 6.6)),
    (
        (19.5, 36, 0.3, 9.3), (20, 0, 1, 8.7), (19.8, -24, -0.5, 8.8), (18.8, -45, -8.5, 7.8),
        (18.4, -57, -16, 6.8),
    ),
    (
        (-17.5, 34, -3, 8.0), (-19.5, 2, -4, 7.2), (-20.5, -13, -5, 7.3), (-21, -28, -11, 6.5),
        (-21, -37, -17, 5.8),
    ),
)  # fmt: skip
PALM = (
    ((-15, 48, -6, 11.0), (22, 50, -2, 12.0)),
    ((-14, 66, -6, 11.5), (24, 66, -2, 12.5)),
)
#: How far joints, fingers and palm run into one another [mm].
JOINT, WEB, KNUCKLE, BACK = 3.0, 2.2, 7.0, 8.0


def main() -> None:
    """Model the hand, and write it."""
    import trimesh
    from skimage.measure import marching_cubes

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("file", type=Path, help="mesh file to write, .ply")
    arguments = parser.parse_args()
    axes = [np.arange(*span, STEP) for span in ((-36, 38), (-58, 74), (-22, 26))]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    first, second, third = (_chain(points, joints, JOINT) for joints in FINGERS)
    near, far = (_chain(points, joints, JOINT) for joints in PALM)
    palm = _blend(near, far, BACK)
    hand = _blend(_blend(_blend(first, palm, KNUCKLE), second, WEB), third, WEB)
    hand = np.pad(_blend(hand, palm, JOINT)[1:-1, 1:-1, 1:-1], 1, constant_values=STEP)  # closed at the wrist
    vertices, faces, _, _ = marching_cubes(hand, 0.0, spacing=(STEP,) * 3)
    mesh = trimesh.Trimesh(vertices + [axis[0] for axis in axes], faces)
    mesh = trimesh.smoothing.filter_taubin(mesh, iterations=20)
    mesh = mesh.simplify_quadric_decimation(face_count=TRIANGLES)
    mesh = max(mesh.split(only_watertight=False), key=lambda part: len(part.faces))
    mesh.fix_normals()
    mesh.export(arguments.file, encoding="binary")
    print(f"{arguments.file}: {len(mesh.faces)} triangles")


def _chain(points: np.ndarray, joints: tuple[tuple[float, ...], ...], blend: float) -> np.ndarray:
    """Return the distance from capsules between joints (x, y, z, radius), blended."""
    distance = None
    for start, end in pairwise(joints):
        a, b = (np.add(joint[:3], (0, 0, MIDDLE)) for joint in (start, end))
        share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        to_axis = np.linalg.norm(points - a - share[..., None] * (b - a), axis=-1)
        capsule = to_axis - (start[3] + (end[3] - start[3]) * share)
        distance = capsule if distance is None else _blend(distance, capsule, blend)
    assert distance is not None
    return np.asarray(distance)


def _blend(a: np.ndarray, b: np.ndarray, width: float) -> np.ndarray:
    """Return the smooth minimum of distances: the polynomial one of Quilez (2013)."""
    share = np.clip(0.5 + 0.5 * (b - a) / width, 0, 1)
    blended: np.ndarray = b * (1 - share) + a * share - width * share * (1 - share)
    return blended


if __name__ == "__main__":
    main()
