"""The command: ``python -m hullmap build meshes --out baked``."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from ._hullmap import run_command


def main() -> int:
    """Runs the command with the words of the command line, and returns its exit code."""
    # Python's own handler only sets a flag, which no one reads while the command runs.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Help texts call the program as the user did: by the installed script, or by the module.
    program = "python -m hullmap" if Path(sys.argv[0]).name == "__main__.py" else "hullmap"
    return run_command([program, *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
