"""The command: ``python -m hullmap build meshes --out baked``."""

from __future__ import annotations

import signal
import sys

from ._hullmap import run_command


def main() -> int:
    """Runs the command with the words of the command line, and returns its exit code."""
    # Python's own handler only sets a flag, which no one reads while the command runs.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_command(["bake", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
