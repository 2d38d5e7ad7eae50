"""Bakes the tasks of a plan with Ray.

    bake farm plan MESHES --out PACKS > plan.jsonl
    python bake.py plan.jsonl [ADDRESS]

Ray repeats a task whose worker has died. That is safe: packs are complete or absent, and fresh ones
are left alone.
"""

import os
import subprocess
import sys

import ray

BAKE = os.environ.get("BAKE", "bake")


@ray.remote(num_cpus=1, max_retries=3, retry_exceptions=False)
def bake(task: str, folder: str) -> tuple[int, str]:
    """Bakes one task, in the folder where it was planned; returns exit code and messages."""
    words = [BAKE, "farm", "task", "-", "--jobs", "1", "--quiet"]
    done = subprocess.run(words, input=task, cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stderr


def main() -> int:
    ray.init(address=sys.argv[2] if len(sys.argv) > 2 else None, log_to_driver=False)
    with open(sys.argv[1]) as plan:
        waiting = [bake.remote(task, os.getcwd()) for task in plan]
    worst = 0
    while waiting:
        [done], waiting = ray.wait(waiting)
        code, messages = ray.get(done)
        print(messages, end="", file=sys.stderr)
        worst = max(worst, abs(code))
    return worst


if __name__ == "__main__":
    sys.exit(main())
