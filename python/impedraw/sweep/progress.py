"""The progress line: "robustness  37/225 runs, 2 failed, 3:12 left"."""

import sys
import time


class Progress:
    """Redrawn on a terminal, else a line every ten seconds. Writes to stderr."""

    def __init__(self, name: str, total: int, kept: int, failed: int) -> None:
        self.name, self.total, self.kept = name, total, kept
        self.done, self.failed = 0, failed
        self.terminal = sys.stderr.isatty()
        self.start = time.monotonic()
        self.next = self.start

    def count(self, done: int, failed: int) -> None:
        self.done += done
        self.failed += failed

    def draw(self, last: bool = False) -> None:
        now = time.monotonic()
        if now < self.next and not last:
            return
        self.next = now + (0.2 if self.terminal else 10.0)
        left = "-:--"
        if self.done:
            rest = self.total - self.kept - self.done
            left = clock((now - self.start) * rest / self.done)
        line = (f"{self.name}  {self.kept + self.done}/{self.total} runs, {self.failed} failed, "
                f"{left} left")
        if self.terminal:
            print("\r" + line, end="\x1b[K" if not last else "\x1b[K\n", file=sys.stderr,
                  flush=True)
        else:
            print(line, file=sys.stderr, flush=True)


def clock(seconds: float) -> str:
    """75 → "1:15", 4000 → "1:06:40"."""
    whole = max(0, round(seconds))
    hours, minutes, rest = whole // 3600, whole // 60 % 60, whole % 60
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
