"""Points and heights of scanners' files: read right in each format, refused clearly where they lie."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from mafsil.collision import HeightMap, PointCloud
from mafsil.errors import FileError
from mafsil.model.scan import ScanLimits, read_heights, read_points

POINTS = np.random.default_rng(1).normal(size=(50, 3)).astype(np.float32).astype(float)


def ply(kind: str, body: bytes, count: int = 50) -> bytes:
    head = f"ply\nformat {kind} 1.0\ncomment made here\nelement camera 1\nproperty uchar id\nelement vertex {count}\n"
    head += "property float x\nproperty float y\nproperty uchar red\nproperty float z\n"
    return (head + "element face 0\nproperty list uchar int vertex_indices\nend_header\n").encode() + body


def rows(order: str) -> bytes:
    return b"\x07" + b"".join(struct.pack(order + "ffBf", x, y, 9, z) for x, y, z in POINTS)


def npy(head: str) -> bytes:
    return b"\x93NUMPY\x01\x00v\x00" + head.encode().ljust(117) + b"\n"


def png(grey: np.ndarray, depth: int, kinds: list[int], colour: int = 0) -> bytes:
    """A picture whose rows are predicted in the given ways, by the textbook's definition."""
    step = depth // 8
    raw = (grey.astype(">u2") if depth == 16 else grey.astype(np.uint8)).view(np.uint8).reshape(len(grey), -1)
    packed, above = b"", [0] * raw.shape[1]
    for row, kind in zip(raw.tolist(), kinds, strict=True):
        coded = []
        for k, value in enumerate(row):
            a, b = row[k - step] if k >= step else 0, above[k]
            c = above[k - step] if k >= step else 0
            p = a + b - c
            paeth = a if abs(p - a) <= min(abs(p - b), abs(p - c)) else b if abs(p - b) <= abs(p - c) else c
            coded.append((value - (0, a, b, (a + b) // 2, paeth)[kind]) % 256)
        packed += bytes([kind, *coded])
        above = row
    head = struct.pack(">IIBBBBB", grey.shape[1], grey.shape[0], depth, colour, 0, 0, 0)
    parts = [(b"IHDR", head), (b"tEXt", b"a\0b"), (b"IDAT", zlib.compress(packed)), (b"IEND", b"")]
    chunks = [struct.pack(">I", len(x)) + n + x + struct.pack(">I", zlib.crc32(n + x)) for n, x in parts]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


@pytest.mark.capability("11-39")
def test_points_are_the_same_in_every_format(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.hstack([POINTS, POINTS]))
    np.save(tmp_path / "camera.npy", np.asfortranarray(POINTS.reshape(5, 10, 3)))
    np.savetxt(tmp_path / "a.xyz", POINTS, header="x y z")
    (tmp_path / "a.csv").write_text("x,y,z\n" + "\n".join(",".join(map(repr, p)) for p in POINTS.tolist()))
    text = "7\n" + "".join(f"{x!r} {y!r} 9 {z!r}\n" for x, y, z in POINTS.tolist())
    (tmp_path / "text.ply").write_bytes(ply("ascii", text.encode()))
    (tmp_path / "little.ply").write_bytes(ply("binary_little_endian", rows("<")))
    (tmp_path / "big.ply").write_bytes(ply("binary_big_endian", rows(">")))
    for path in tmp_path.iterdir():
        np.testing.assert_allclose(read_points(path), POINTS, rtol=1e-12, err_msg=path.name)
    cloud = PointCloud.from_file(tmp_path / "a.npy", 0.01, scale=0.001)
    np.testing.assert_allclose(cloud.points, POINTS / 1000)


@pytest.mark.capability("11-39")
def test_heights_are_the_same_in_every_format(tmp_path: Path) -> None:
    heights = np.random.default_rng(2).integers(0, 256, (10, 7))
    np.save(tmp_path / "a.npy", heights / 255)
    np.savetxt(tmp_path / "a.csv", heights / 255, delimiter=";")
    (tmp_path / "a.png").write_bytes(png(heights[::-1], 8, [0, 1, 2, 3, 4, 4, 3, 2, 1, 0]))
    (tmp_path / "wide.png").write_bytes(png(heights[::-1] * 257, 16, [4, 3, 2, 1, 0, 1, 2, 3, 4, 0]))
    for path in tmp_path.iterdir():
        np.testing.assert_allclose(read_heights(path), heights / 255, atol=1e-12, err_msg=path.name)
    ground = HeightMap.from_file(tmp_path / "a.png", (2.0, 1.0), scale=0.5)
    assert ground.base == pytest.approx(0.5 * heights.min() / 255 - 0.1)
    np.testing.assert_allclose(ground.heights, heights / 510)


PICTURE = png(np.zeros((3, 3), int), 8, [0, 0, 0])
LIES = {
    "a.npy": npy("{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000, 3), }"),
    "object.npy": npy("{'descr': '|O', 'fortran_order': False, 'shape': (1, 3), }"),
    "code.npy": npy("__import__('os')"),
    "spelt.npy": npy("{'descr': '<f8', 'fortran_order': Fa se, 'shape': (1, 3), }"),
    "open.npy": npy("{'descr': '<f8', 'shape': (4, 5\u00e9"),
    "version.npy": npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), }").replace(b"\x01", b"\x09", 1),
    "cut.ply": ply("binary_little_endian", rows("<")[:-3]),
    "many.ply": ply("ascii", b"1 2 3 4\n", 10**15),
    "negative.ply": ply("ascii", b"", -1),
    "short.ply": ply("ascii", b"7\n1 2\n", 2),
    "lists.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar float x\nend_header\n1 1\n",
    "empty.xyz": b"# nothing\n",
    "two.xyz": b"1 2\n3 4\n",
    "uneven.xyz": b"1 2 3\n1 2 3 4\n",
    "words.xyz": b"1 2 3\na b c\n",
    "seen.xyz": b"1 2 3\nnan nan nan\n",
    "a.pcd": b"",
}  # fmt: skip
GROUND_LIES = {
    "cut.png": PICTURE[:-20],
    "flipped.png": PICTURE[:45] + bytes([PICTURE[45] ^ 1]) + PICTURE[46:],
    "colour.png": png(np.zeros((3, 3), int), 8, [0, 0, 0], colour=2),
    "bomb.png": b"\x89PNG\r\n\x1a\n"
    + b"".join(
        struct.pack(">I", len(x)) + n + x + struct.pack(">I", zlib.crc32(n + x))
        for n, x in ((b"IHDR", struct.pack(">IIBBBBB", 2**31, 2**31, 16, 0, 0, 0, 0)), (b"IEND", b""))
    ),
    "no data.png": PICTURE[: PICTURE.index(b"IDAT") - 4] + PICTURE[PICTURE.index(b"IEND") - 4 :],
    "row.csv": b"1 2 3\n",
    "a.jpg": b"",
}


@pytest.mark.parametrize("name", [*LIES, *GROUND_LIES])
def test_files_that_lie_are_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes({**LIES, **GROUND_LIES}[name])
    with pytest.raises(FileError) as refused:
        (read_points if name in LIES else read_heights)(path)
    assert name in refused.value.message("en") != refused.value.message("ar")


def test_limits_are_held(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    np.savetxt(path, POINTS)
    with pytest.raises(FileError, match="at most 20"):
        read_points(path, limits=ScanLimits(points=20))
    with pytest.raises(FileError, match="at most 20"):
        read_heights(path.rename(tmp_path / "a.txt"), limits=ScanLimits(heights=20))
    with pytest.raises(FileError, match="larger than 10 bytes"):
        read_points(tmp_path / "a.txt", limits=ScanLimits(bytes=10))
    with pytest.raises(FileError):
        read_points(tmp_path)
