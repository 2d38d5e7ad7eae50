"""Two pictures for planners: an edge of an arm with its interval of contact, and a smoothed clearance.

    python motion.py [FOLDER]

The first is an arm of two links that turns past a post. The times of a sampler are beside the interval in
which the arm certainly first touches it. The second is the clearance of two boxes while one turns, its
derivative, and the mean of both over nearby angles.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import List, Tuple

import numpy as np

import hullmap

LENGTH, HALF_WIDTH, POST = 1.0, 0.06, 0.03
ARM = f"""<mujoco><worldbody>
  <body name="upper"><joint name="shoulder" axis="0 0 1"/>
    <geom type="box" size="{LENGTH / 2} {HALF_WIDTH} 0.1" pos="{LENGTH / 2} 0 0"/>
    <body name="lower" pos="{LENGTH} 0 0"><joint name="elbow" axis="0 0 1"/>
      <geom type="box" size="{LENGTH / 2} {HALF_WIDTH} 0.1" pos="{LENGTH / 2} 0 0"/></body></body>
</worldbody></mujoco>"""
AT = np.array([0.95, 0.8])
START, END = np.array([-0.35, 0.9]), np.array([1.1, -0.2])
STEPS = 6

INK, SOFT, BLUE, RED, GREEN = "#222", "#666", "#2b6cb0", "#c53030", "#2f855a"


def text(x: float, y: float, words: str, *, colour: str = INK, size: int = 13, anchor: str = "start") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" font-size="{size}" text-anchor="{anchor}">{words}</text>'


def line(points: np.ndarray, colour: str, width: float = 1.5, more: str = "") -> str:
    joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{joined}" fill="none" stroke="{colour}" stroke-width="{width}" {more}/>'


def save(path: Path, width: int, height: int, title: str, parts: List[str]) -> None:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="Helvetica, Arial, sans-serif">'
    body = [head, f"<title>{title}</title>", '<rect width="100%" height="100%" fill="#fff"/>', *parts, "</svg>"]
    path.write_text("\n".join(body) + "\n", encoding="utf-8")


def links(q: np.ndarray) -> List[np.ndarray]:
    """Corners of both links in the plane."""
    found, place, angle = [], np.zeros(2), 0.0
    for joint in q:
        angle += joint
        along = np.array([np.cos(angle), np.sin(angle)])
        across = HALF_WIDTH * np.array([-along[1], along[0]])
        end = place + LENGTH * along
        found.append(np.array([place + across, end + across, end - across, place - across]))
        place = end
    return found


def edge(path: Path) -> None:
    """Draws an edge in joint space, the times of a sampler, and the interval of the first contact."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "arm.xml"
        file.write_text(ARM, encoding="utf-8")
        robot = hullmap.Robot.from_mjcf(file)
    robot = robot.with_obstacles({"post": (hullmap.Cylinder(0.5, POST), hullmap.poses([*AT, 0]))})
    found = robot.clear(START, END)
    times = np.linspace(0, 1, STEPS)
    between = lambda t: START + t * (END - START)
    hits = robot.in_collision(np.array([between(t) for t in times]))
    assert found.verdict == hullmap.Verdict.HIT and not hits.any()

    place = lambda points: np.stack((60 + 190 * points[..., 0], 380 - 190 * points[..., 1]), axis=-1)
    parts = []

    def arm(t: float, colour: str, opacity: float) -> None:
        for corners in links(between(t)):
            joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in place(corners))
            parts.append(f'<polygon points="{joined}" fill="{colour}" fill-opacity="{opacity}" stroke="{colour}" stroke-width="1"/>')

    for t in times:
        arm(t, SOFT, 0.1)
    arm(float(found.t_lower), RED, 0.45)
    (x, y) = place(AT)
    parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{190 * POST:.1f}" fill="{INK}"/>')
    parts.append(text(x + 10, y - 8, "post"))
    tip = np.array([links(between(t))[1][1:3].mean(axis=0) for t in np.linspace(0, 1, 60)])
    parts.append(line(place(tip), BLUE, 1.2, 'stroke-dasharray="4 3"'))
    # The times.
    left, right, height = 60.0, 580.0, 480.0
    at = lambda t: left + (right - left) * t
    parts.append(line(np.array([[left, height], [right, height]]), INK, 1))
    for t in times:
        parts.append(f'<circle cx="{at(t):.1f}" cy="{height}" r="4" fill="{GREEN}"/>')
    lower, upper = at(float(found.t_lower)), at(float(found.t_upper))
    parts.append(f'<rect x="{lower - 1:.1f}" y="{height - 11}" width="{max(2.0, upper - lower):.1f}" height="22" fill="{RED}"/>')
    parts.append(text(lower, height - 18, f"first contact: t from {float(found.t_lower):.5f} to {float(found.t_upper):.5f}", colour=RED, anchor="middle"))
    parts.append(text(left, height + 24, f"t = 0; {STEPS} samples, all free", colour=GREEN))
    parts.append(text(right, height + 24, "t = 1", anchor="end"))
    save(path, 640, 520, "An edge of an arm: the samples are free, the edge is not", parts)


def clearances(angles: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Distance of a box over a box that is turned about y, and its derivative by the angle."""
    zero = np.zeros_like(angles)
    turns = np.stack((zero, np.sin(angles / 2), zero, np.cos(angles / 2)), axis=-1)
    places = np.broadcast_to([0.0, 0.0, 1.2], (*angles.shape, 3))
    found = hullmap.derivatives(hullmap.Box([1, 1, 0.2]), hullmap.Box([0.5, 0.5, 0.5]), hullmap.poses(places, turns), tolerance=0)
    return found.value, found.by_b[..., 4]


def smoothed(path: Path) -> None:
    """Draws a clearance with a kink, and its mean over nearby angles."""
    angles = np.linspace(-0.3, 0.3, 241)
    value, slope = clearances(angles)
    # In opposite pairs.
    near = np.random.default_rng(0).uniform(-0.06, 0.06, size=32)
    mean, mean_slope = (own.mean(axis=0) for own in clearances(angles + np.concatenate((near, -near))[:, None]))
    parts: List[str] = []
    for left, title, exact, smooth in ((60, "clearance", value, mean), (400, "its derivative", slope, mean_slope)):
        low, high = min(exact.min(), smooth.min()), max(exact.max(), smooth.max())
        x = left + 260 * (angles + 0.3) / 0.6
        y = lambda own: 260 - 200 * (own - low) / (high - low)
        parts.append(line(np.array([[left, 275], [left + 260, 275]]), SOFT, 1))
        parts.append(text(left, 40, title, size=15))
        for angle in (-0.3, 0.0, 0.3):
            parts.append(text(left + 260 * (angle + 0.3) / 0.6, 293, f"{angle:g} rad" if angle else "0, parallel faces", colour=SOFT, anchor="middle"))
        parts.append(line(np.stack((x, y(exact)), axis=-1), INK, 1.5))
        parts.append(line(np.stack((x, y(smooth)), axis=-1), BLUE, 2.2))
        parts.append(text(left - 6, y(high) + 4, f"{high:.2f}", colour=SOFT, anchor="end"))
        parts.append(text(left - 6, y(low) + 4, f"{low:.2f}", colour=SOFT, anchor="end"))
    parts.append(text(60, 320, "black: at one pose; blue: mean over 64 angles within 0.06 rad"))
    save(path, 700, 340, "A clearance with a kink, and the mean over nearby poses", parts)


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    edge(folder / "motion_edge.svg")
    smoothed(folder / "motion_smoothed.svg")
