"""The two boxes of `known.txt`, and a refusal to measure an engine that answers them wrongly.

An engine that gets its input in another layout than it expects still returns figures. So each harness proves
itself with `require`, and its line stands above the harness's table.
"""

import pathlib
import sys

# Allowed difference of lengths and volumes, relative for values above 1. Engines in single precision stay far below
# it; input in a wrong layout does not.
TOLERANCE = 1e-3

# Corners of a box are numbered by the signs of x, y and z, from the lowest bit on.
TRIANGLES = [
    (0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4),
    (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5),
]  # fmt: skip


def _read():
    boxes, poses = {}, {}
    for line in pathlib.Path(__file__).with_name("known.txt").read_text(encoding="utf-8").splitlines():
        kind, name, *numbers = line.split()
        if kind == "box":
            boxes[name] = [float(number) for number in numbers]
        elif kind == "pose":
            poses[name] = [float(number) for number in numbers[:7]], float(numbers[7])
    return boxes, poses


# Half-lengths by name; by name, pose of B in A's frame (x y z qx qy qz qw) and gap, which is a depth if negative.
BOXES, POSES = _read()


def corners(box):
    return [[half if i >> k & 1 else -half for k, half in enumerate(BOXES[box])] for i in range(8)]


def volume(points, triangles):
    """The volume within triangles that are counter-clockwise seen from outside."""
    total = 0.0
    for triangle in triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (map(float, points[int(corner)]) for corner in triangle)
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6


VOLUMES = sorted(volume(corners(box), TRIANGLES) for box in BOXES)


def placed(pose):
    """Corners of both boxes in A's frame."""
    (x, y, z, a, b, c, w), _ = POSES[pose]
    turn = [
        [1 - 2 * (b * b + c * c), 2 * (a * b - c * w), 2 * (a * c + b * w)],
        [2 * (a * b + c * w), 1 - 2 * (a * a + c * c), 2 * (b * c - a * w)],
        [2 * (a * c - b * w), 2 * (b * c + a * w), 1 - 2 * (a * a + b * b)],
    ]
    move = lambda p: [at + sum(t * q for t, q in zip(row, p)) for at, row in zip((x, y, z), turn)]
    return [corners("A"), [move(corner) for corner in corners("B")]]


def obj_of(boxes):
    """Text of an OBJ file with boxes, given by their corners, as objects."""
    lines = []
    for index, points in enumerate(boxes):
        lines.append(f"o box_{index}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
        lines += ["f " + " ".join(str(8 * index + corner + 1) for corner in triangle) for triangle in TRIANGLES]
    return "\n".join(lines) + "\n"


def obj(pose):
    """Text of an OBJ file with both boxes in a pose."""
    return obj_of(placed(pose))


def require(engine, answers):
    """The line that proves an engine. Ends the program if an answer is wrong.

    An answer is what was asked, the known value, and the engine's; NaN is wrong.
    """
    shown = lambda value, known: ("yes" if value else "no") if isinstance(known, bool) else f"{float(value):.6g}"
    for what, known, found in answers:
        if not abs(float(found) - float(known)) <= TOLERANCE * max(1.0, abs(float(known))):
            sys.exit(
                f"{engine}, two known boxes: {what} {shown(found, known)} instead of {shown(known, known)}. "
                "Its figures would mean nothing: check how this program passes shapes and poses to it"
            )
    line = f"{engine}, two known boxes: " + ", ".join(f"{what} {shown(found, known)}" for what, known, found in answers)
    print(line, flush=True)
    return line
