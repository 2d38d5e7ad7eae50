"""Harnesses refuse to measure MuJoCo and coal if these answer the known boxes wrongly.

    check_refusals.py

Each fault replaces a function of an engine, or of what passes shapes to it, while a harness proves the engine.
"""

import pathlib
import sys
import unittest.mock

try:
    import check_planner
    import mujoco

    sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "benches/peers"))
    import pit_mujoco
except ImportError as error:
    print(f"skipped: refusals: {error}")
    sys.exit()

parts_of, clearance = pit_mujoco.parts_of, check_planner.Reference.clearance
nothing = lambda *_: None

FAULTS = [
    (pit_mujoco, mujoco, "mj_forward", nothing, "depth 0 instead of 0.25"),
    (pit_mujoco, pit_mujoco, "parts_of", lambda path: parts_of(path)[:1], "volume 32 instead of 35"),
    (check_planner, mujoco, "mj_collision", nothing, "hit no instead of yes"),
    (check_planner, check_planner.Reference, "clearance", lambda *of: 2 * clearance(*of), "gap -0.5 instead of -0.25"),
    (check_planner, check_planner.Reference, "collides", lambda *_: True, "hulls, hit yes instead of no"),
]
for harness, place, name, fault, refusal in FAULTS:
    harness.prove()
    try:
        with unittest.mock.patch.object(place, name, fault):
            harness.prove()
    except SystemExit as refused:
        assert refusal in str(refused), refused
    else:
        raise AssertionError(f"{harness.__name__} does not refuse a faulty {name}")
print(f"{len(FAULTS)} faults, all refused")
