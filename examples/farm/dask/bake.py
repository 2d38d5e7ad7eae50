"""Bakes the tasks of a plan with Dask.

    bake farm plan MESHES --out PACKS > plan.jsonl
    python bake.py plan.jsonl [SCHEDULER]

Without the address of a scheduler, two worker processes are started on this machine. Dask repeats a
task whose worker has died. That is safe: packs are complete or absent, and fresh ones are left alone.
"""

import os
import subprocess
import sys

from dask.distributed import Client, LocalCluster, as_completed

BAKE = os.environ.get("BAKE", "bake")


def bake(task: str, folder: str) -> tuple[int, str]:
    """Bakes one task, in the folder where it was planned; returns exit code and messages."""
    words = [BAKE, "farm", "task", "-", "--jobs", "1", "--quiet"]
    done = subprocess.run(words, input=task, cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stderr


def main() -> int:
    if len(sys.argv) > 2:
        client = Client(sys.argv[2])
    else:
        client = Client(LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None))
    with open(sys.argv[1]) as plan:
        # Tasks are not pure functions: they write files.
        tasks = client.map(bake, list(plan), folder=os.getcwd(), pure=False, retries=3)
    worst = 0
    for _, (code, messages) in as_completed(tasks, with_results=True):
        print(messages, end="", file=sys.stderr)
        worst = max(worst, abs(code))
    client.close()
    return worst


if __name__ == "__main__":
    sys.exit(main())
