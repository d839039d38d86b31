"""A short sequence in TUM layout with its ground truth, and ways to spoil it."""

import json
import os
import re

import cv2
import numpy as np

TOKENS = ("nan", "inf", "-1", "1e999", "9" * 5000, "\x00", "\x1b[2J", "../..", '"', "{" * 5000, "",
          "/dev/zero", "null", "true")  # fmt: skip
NUMBERS = ("0", "-1", "1e-300", "1e-6", "1e7", "-1e30", "1e30", "1e308", "-1e308", "9" * 400, "nan",
           "inf", "0.4", "5", "160", "7000", "1e20")  # fmt: skip
"""Numbers in the place of others, those that nearly fit among them."""
LISTS = ("associations.txt", "rgb.txt", "depth.txt", "groundtruth.txt", "camera.json")


def write_sequence(folder, associated=True):
    """Four frames of a wall that a camera passes; without `associated`, a list for each kind."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(0)
    wall = rng.integers(0, 255, (40, 60, 3)).astype(np.uint8)
    wall = cv2.resize(wall, (240, 160), interpolation=cv2.INTER_NEAREST)
    kinds = {"rgb": [], "depth": []}
    truth = []
    for i in range(4):
        cv2.imwrite(str(folder / f"{i}.png"), wall[20:140, 20 + 8 * i : 180 + 8 * i])
        cv2.imwrite(str(folder / f"{i}d.png"), np.full((120, 160), 1500, np.uint16))
        kinds["rgb"].append(f"{i / 5} {i}.png")
        kinds["depth"].append(f"{i / 5} {i}d.png")
        truth.append(f"{i / 5} {1 + 0.09 * i} 0 0 0 0 0 1")
    if associated:
        kinds = {"associations": map(" ".join, zip(*kinds.values(), strict=True))}
    for name, rows in {**kinds, "groundtruth": truth}.items():
        (folder / f"{name}.txt").write_text("\n".join(rows) + "\n")
    camera = {"width": 160, "height": 120, "fx": 130.0, "fy": 130.0, "cx": 80.0, "cy": 60.0}
    (folder / "camera.json").write_text(json.dumps(camera | {"depth_scale": 1000}))


def spoil(folder, rng):
    """One or two things that go wrong with files; lists as often as images, which are more."""
    for _ in range(rng.integers(1, 3)):
        names = sorted(each.name for each in folder.iterdir())
        if rng.random() < 0.5:
            names = [name for name in names if name in LISTS] or names
        _spoil_file(folder / str(rng.choice(names)), rng)


def make_strange(folder, rng):
    """Whole files whose numbers are as far out as they may be, so that all of the way is taken."""
    camera = {"width": 160, "height": 120}
    camera |= {key: 160 * 10 ** rng.uniform(-1.3, 1.69) for key in ("fx", "fy")}
    camera |= {key: rng.uniform(-160, 320) for key in ("cx", "cy")}
    camera |= {"depth_scale": 10 ** rng.uniform(1, 6)}
    if rng.random() < 0.7:
        (folder / "camera.json").write_text(json.dumps(camera))
    if rng.random() < 0.5:
        poses = rng.normal(size=(4, 7))
        poses[:, :3] *= rng.choice([1e-300, 1e-7, 1.0, 1e5, 1e7])
        rows = [" ".join(map(str, (i / 5, *pose))) for i, pose in enumerate(poses)]
        (folder / "groundtruth.txt").write_text("\n".join(rows))
    if rng.random() < 0.5:
        spread = rng.choice([1e-300, 1e-12, 1e3, 1e9, 1e18, 1e20])
        stamps = np.sort(rng.uniform(-spread, spread, 4)).tolist()
        for path in folder.glob("*.txt"):  # image i has the stamp i / 5 in all of them
            text = path.read_text()
            for i, stamp in enumerate(stamps):
                text = re.sub(rf"(^|\s)0\.{2 * i}(?=\s)", rf"\g<1>{stamp}", text)
            path.write_text(text)
    for path in sorted(folder.glob("*.png")):
        if rng.random() < 0.4:
            image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
            most = rng.choice([1, 2, 50, np.iinfo(image.dtype).max])
            values = rng.integers(rng.choice([0, most - 1]), most + 1, image.shape)
            cv2.imwrite(str(path), values.astype(image.dtype))


def _spoil_file(path, rng):
    if not path.is_file():
        return
    data, kind = bytearray(path.read_bytes()), rng.integers(12)
    place = int(rng.integers(len(data) + 1))
    if kind == 0:
        for _ in range(rng.integers(1, 20)):
            data[rng.integers(len(data))] ^= 1 << rng.integers(8)
        path.write_bytes(data)
    elif kind == 1:
        path.write_bytes(data[:place])
    elif kind == 2:
        path.write_bytes(data[:place] + rng.bytes(rng.integers(1, 200)) + data[place:])
    elif kind == 3:
        words = data.decode("latin1").split(" ")
        words[rng.integers(len(words))] = str(rng.choice(TOKENS))
        path.write_bytes(" ".join(words).encode())
    elif kind == 4:
        others = [each for each in sorted(path.parent.iterdir()) if each.is_file()]
        path.write_bytes(others[rng.integers(len(others))].read_bytes())
    elif kind < 8:
        path.unlink()
        if kind == 5:
            os.mkfifo(path)
        elif kind == 6:
            path.mkdir()
        elif rng.random() < 0.8:
            path.symlink_to(str(rng.choice(["/dev/zero", "/dev/full", path.name, "nowhere"])))
    else:
        path.write_bytes(_renumbered(bytes(data), rng))


def _renumbered(content, rng):
    """Another number in one to three places, or in a whole column of a list."""
    numbers = list(re.finditer(rb"(?<![\w.])-?\d[\d.]*(?![\w.])", content))
    if not numbers:
        return content
    column, every = int(rng.integers(8)), rng.random() < 0.3
    chosen = rng.permutation(len(numbers))[: rng.integers(1, 4)].tolist()
    number = str(rng.choice(NUMBERS)).encode()
    for index in sorted(range(column, len(numbers), 8) if every else chosen, reverse=True):
        start, end = numbers[index].span()
        content = content[:start] + number + content[end:]
    return content
