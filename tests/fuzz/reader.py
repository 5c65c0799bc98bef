# SPDX-License-Identifier: BSD-3-Clause
"""The sanitized program that reads one file after the other, and what is wrong about its answers."""

import contextlib
import os
import select
import subprocess
import time
from pathlib import Path

CPU_LIMIT = 5.0  # s that it may compute for one file
WALL_LIMIT = 120.0  # s, where it only waits
MEMORY_LIMIT = 1024  # MB
# libraries ask for room without measure and know what to do where there is none; what does not, ends
SANITIZERS = {
    "ASAN_OPTIONS": f"hard_rss_limit_mb={MEMORY_LIMIT}:max_allocation_size_mb={MEMORY_LIMIT}:detect_leaks=1:"
    "allocator_may_return_null=1:fast_unwind_on_malloc=1:handle_abort=1",
    "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    "LSAN_OPTIONS": f"suppressions={Path(__file__).with_name('lsan.supp')}:print_suppressions=0",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}


class SilenceError(Exception):
    """No answer in time."""


class Reader:
    """A process; the next one starts where it ends."""

    def __init__(self, program: Path, kind: str, folder: Path) -> None:
        self.command = [program, kind]
        self.report = folder / "report.txt"
        self.environment = os.environ | SANITIZERS
        self.start()

    def start(self) -> None:
        self.arrived = b""
        with self.report.open("wb") as report:
            self.process = subprocess.Popen(
                self.command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=report,
                env=self.environment,
            )

    def send(self, paths: list[Path]) -> None:
        """Asks for some files. A process that has ended shows when its answers are missing."""
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write("".join(f"{path}\n" for path in paths).encode())
            self.process.stdin.flush()

    def answer(self) -> tuple[str, str]:
        """The answer to the next file, and what is wrong about it (empty where nothing is)."""
        try:
            words = self.take_line().split()
            if words == [b"accepted"]:
                return "accepted", ""
            if len(words) != 2 or words[0] != b"refused":
                return "", self.end("the reader ended")
            sentence = self.take(int(words[1]) + 1)
        except SilenceError:
            self.process.kill()
            return "", self.end(f"no answer after {CPU_LIMIT:g} s of computing, or after {WALL_LIMIT:g} s")
        return "refused", "" if len(sentence.split()) > 2 else f"a refusal without a sentence: {sentence}"

    def take_line(self) -> bytes:
        """Up to the end of a line, or of the answers."""
        while b"\n" not in self.arrived and self.wait():
            pass
        line, _, self.arrived = self.arrived.partition(b"\n")
        return line

    def take(self, n: int) -> bytes:
        while len(self.arrived) < n and self.wait():
            pass
        piece, self.arrived = self.arrived[:n], self.arrived[n:]
        return piece

    def wait(self) -> bool:
        """Whether more arrived; nothing does any more where the process has ended."""
        start_cpu, start = self.cpu_seconds(), time.monotonic()
        while not select.select([self.process.stdout], [], [], 1.0)[0]:
            if self.cpu_seconds() - start_cpu > CPU_LIMIT or time.monotonic() - start > WALL_LIMIT:
                raise SilenceError
        more = os.read(self.process.stdout.fileno(), 65536)
        self.arrived += more
        return bool(more)

    def cpu_seconds(self) -> float:
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self, reason: str = "") -> str:
        """Ends the process and starts the next one; the reason with what a sanitizer said, empty where all is well."""
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        try:
            status = self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        self.process.stdout.close()
        told = self.report.read_text(errors="replace")
        self.start()
        return f"{reason}\nexit code {status}\n{told}" if reason or status != 0 else ""
