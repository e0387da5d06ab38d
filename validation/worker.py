"""Running cases in a process of their own, so that a crash or a hang costs one case only.

The parent sends the folder of a case as one line of JSON and gets its rows, or its error, as one
line back. One process serves many cases; it is replaced when it dies or exceeds a time limit.
Several work side by side; results come in the order of the cases.

Depends on: case, compare; starts `validation.serve`.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import queue
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

from validation.case import Case
from validation.compare import Result, compare, failed, skipped

ROOT = Path(__file__).resolve().parent.parent


def run_all(
    cases: Sequence[Case], count: int = 1, tick: Callable[[Sequence[str]], None] | None = None
) -> Iterator[Result]:
    """Results of `cases`, in their order, from `count` processes side by side.

    `tick(names)` is called about five times a second with the cases being computed.
    """
    workers = [Worker() for _ in range(count)]
    idle: queue.SimpleQueue[Worker] = queue.SimpleQueue()
    running: dict[str, None] = {}
    for worker in workers:
        idle.put(worker)

    def one(case: Case) -> Result:
        worker = idle.get()
        running[case.name] = None
        try:
            return worker.run(case)
        finally:
            del running[case.name]
            idle.put(worker)

    pool = ThreadPoolExecutor(max_workers=count)
    try:
        for future in [pool.submit(one, case) for case in cases]:
            while not wait([future], timeout=0.2).done:
                if tick is not None:
                    tick(list(running))
            yield future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.kill()  # whatever still computes is not wanted any more
        pool.shutdown()
        for worker in workers:
            worker.stop()


class Worker:
    """A child process that computes cases, one after the other.

    Examples
    --------
    ``with Worker() as worker: result = worker.run(case)``
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def run(self, case: Case) -> Result:
        """Compute and compare `case`; skip it without the peer that it needs."""
        if case.needs and importlib.util.find_spec(case.needs) is None:
            return skipped(case)
        start = time.perf_counter()
        process = self._started()
        try:
            assert process.stdin is not None
            process.stdin.write(json.dumps(str(case.folder)).encode() + b"\n")
            process.stdin.flush()
            line = self._answer(process, start + case.time_limit_s)
        except TimeoutError:
            self.stop()
            seconds = time.perf_counter() - start
            return failed(case, f"stopped after its time limit of {case.time_limit_s:g} s", seconds)
        except (BrokenPipeError, EOFError):
            reason = _how_it_died(process)
            self.stop()
            return failed(case, reason, time.perf_counter() - start)
        seconds = time.perf_counter() - start
        answer = json.loads(line)
        if "error" in answer:
            return failed(case, answer["error"], seconds, answer["traceback"])
        return compare(case, answer["rows"], seconds)

    def kill(self) -> None:
        """End the child process without waiting for it: a case being computed there fails."""
        if self._process is not None:
            self._process.kill()

    def stop(self) -> None:
        """End the child process, if there is one."""
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self.stop()
            path = os.pathsep.join(p for p in (str(ROOT), os.environ.get("PYTHONPATH")) if p)
            self._process = subprocess.Popen(
                [sys.executable, "-m", "validation.serve"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                # small matrices: threads inside linear algebra would only get in each other's way
                env={"OPENBLAS_NUM_THREADS": "1"} | os.environ | {"PYTHONPATH": path},
            )
        return self._process

    @staticmethod
    def _answer(process: subprocess.Popen[bytes], deadline: float) -> bytes:
        """One line from the child, read piecewise so that a deadline can be kept."""
        assert process.stdout is not None
        pipe, parts = process.stdout.fileno(), []
        while True:
            left = deadline - time.perf_counter()
            if left <= 0.0:
                raise TimeoutError
            ready, _, _ = select.select([pipe], [], [], left)
            if not ready:
                continue
            part = os.read(pipe, 1 << 16)
            if not part:
                raise EOFError
            parts.append(part)
            if part.endswith(b"\n"):
                return b"".join(parts)


def _how_it_died(process: subprocess.Popen[bytes]) -> str:
    status = process.wait()
    if status < 0:
        return f"its process died of signal {-status} ({signal.Signals(-status).name})"
    return f"its process ended by itself with status {status}"
