"""Progress of a bake: a bar on a terminal, or calls of a function of the user."""

from __future__ import annotations

import sys
import time
from contextlib import contextmanager
from typing import Callable, Iterator, Optional, Union

from ._hullmap import BakeError

Report = Callable[[float], object]
Progress = Union[None, bool, Report]

BAR_AFTER = 0.3
"""Seconds after which there is a bar. Before that, it would only flicker."""

BAR_WIDTH = 30
"""Characters of a whole bar."""


@contextmanager
def shown(progress: Progress, name: str) -> Iterator[Optional[Report]]:
    """Progress callback of a bake: receives the fraction done."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        bar = _Bar(name)
        try:
            yield bar if sys.stderr is not None and sys.stderr.isatty() else None
        finally:
            bar.clear()
    elif callable(progress):
        yield progress
    else:
        raise BakeError(f"progress: expected True or a function of the share that is done, found {progress!r}")


class _Bar:
    """A bar on standard error, in one line."""

    def __init__(self, name: str) -> None:
        self.name = "".join(letter if letter.isprintable() else "?" for letter in name)
        self.start, self.width = time.monotonic(), 0

    def __call__(self, share: float) -> None:
        seconds = time.monotonic() - self.start
        if seconds >= BAR_AFTER:
            bar = "#" * int(share * BAR_WIDTH)
            self._write(f"{self.name} [{bar:<{BAR_WIDTH}}] {share:4.0%}, {seconds:.0f} s")

    def clear(self) -> None:
        if self.width > 0:
            self._write("")
            sys.stderr.write("\r")
            sys.stderr.flush()

    def _write(self, line: str) -> None:
        sys.stderr.write(f"\r{line:<{self.width}}")
        sys.stderr.flush()
        self.width = len(line)
