"""Runs cases in batches, on Ray or in this process, and hands each batch's rows on.

Ray's tasks cost about a millisecond and its scheduler suffers from many small ones, so cases are
sent in batches that should take BATCH_SECONDS. A batch whose worker dies comes back: it is halved
until the case that kills its worker is alone; that one is tried WORKER_DEATHS times and then is a
row. A batch whose node goes away is sent again.
"""

import os
import secrets
import shutil
import signal
import socket
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

from .errors import SweepError
from .runners import Context, make_runner
from .spec import Case

BATCH_SECONDS = 5.0
SERIAL_ROWS_SECONDS = 2.0  # between two tables of a serial sweep
MOST_IN_BATCH = 2000
WORKER_DEATHS = 3
_OBJECT_STORE = 100 * 2**20  # [B]; a batch's rows are at most some megabytes


class Interrupted(Exception):
    """Ctrl-C, or SIGTERM."""


class Stop:
    """Turns SIGINT and SIGTERM into a flag, in the main thread."""

    def __init__(self) -> None:
        self.signal = 0
        self._before = {}
        if threading.current_thread() is not threading.main_thread():
            return  # signals are not this thread's
        for number in (signal.SIGINT, signal.SIGTERM):
            self._before[number] = signal.signal(number, self._requested)

    def _requested(self, number: int, frame: FrameType | None) -> None:
        if self.signal:  # the second time: at once
            os._exit(128 + number)
        self.signal = number

    def restore(self) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)


Rows = Any  # pyarrow.Table
OnRows = Callable[[Rows], None]


def run_serial(context: Context, cases: Iterator[Case], on_rows: OnRows,
               tick: Callable[[], None], stop: Stop) -> None:
    """One case after the other, in this process. The reference for everything else."""
    from .rows import rows_of, table_of

    def until_stopped() -> Iterator[Case]:
        for case in cases:
            if stop.signal:
                raise Interrupted
            yield case

    rows: list[dict[str, Any]] = []
    since = time.monotonic()
    try:
        for row in rows_of(context, make_runner(context), until_stopped()):
            rows.append(row)
            if time.monotonic() - since > SERIAL_ROWS_SECONDS:
                on_rows(table_of(context, rows))
                tick()
                rows, since = [], time.monotonic()
    finally:
        if rows:
            on_rows(table_of(context, rows))
            tick()


class Batches:
    """Cuts the cases into batches of about BATCH_SECONDS by the time that runs took so far."""

    def __init__(self, cases: Iterator[Case], total: int) -> None:
        self.cases, self.left = cases, total
        self.again: deque[list[Case]] = deque()
        self.mean: float | None = None  # of a run [s]

    def learn(self, runs: int, seconds: float) -> None:
        mean = seconds / max(runs, 1)
        self.mean = mean if self.mean is None else 0.7 * self.mean + 0.3 * mean

    def next(self, slots: int) -> list[Case] | None:
        if self.again:
            return self.again.popleft()
        if self.mean is None:
            size = 1  # so that the first rows come soon
        else:
            size = int(min(MOST_IN_BATCH, BATCH_SECONDS / max(self.mean, 1e-6) + 1))
            size = max(1, min(size, -(-self.left // max(slots, 1))))  # the last ones are shared
        batch = []
        for case in self.cases:
            batch.append(case)
            if len(batch) >= size:
                break
        self.left -= len(batch)
        return batch or None


def require_cluster(address: str) -> None:
    """Raises SweepError where nobody listens at HOST:PORT: Ray itself would wait for minutes."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536 or "/" in host:
        raise SweepError(f"--address {address}: valid is HOST:PORT, as `ray start --head` tells it")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=5.0).close()
    except OSError as error:
        reason = error.strerror or str(error)
        raise SweepError(f"--address {address}: no cluster is there: {reason}") from None


def start_ray(address: str | None, workers: int | None, folder: str | None) -> int:
    """Starts Ray on this machine, or joins a cluster. Returns how many CPUs are there.

    A local Ray listens on 127.0.0.1 alone, and asks for a token that only this process and its
    children know; its sockets and logs are in `folder`. Raises SweepError.
    """
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    os.environ.setdefault("RAY_DEDUP_LOGS", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    if address is None and "ray" not in sys.modules:
        # Ray replaces 127.0.0.1 by the machine's own address, and listens on every interface,
        # unless clusters are switched off: the switch that it has for Windows and macOS.
        os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"
        os.environ.pop("RAY_ADDRESS", None)
        os.environ["RAY_AUTH_MODE"] = "token"
        os.environ["RAY_AUTH_TOKEN"] = secrets.token_hex(32)
    import ray

    try:
        if ray.is_initialized():
            pass
        elif address is None:
            ray.init(num_cpus=workers or _cores(), num_gpus=0, include_dashboard=False,
                     _node_ip_address="127.0.0.1", _temp_dir=folder,
                     object_store_memory=_OBJECT_STORE,
                     log_to_driver=False, logging_level="ERROR", configure_logging=True)
        else:
            ray.init(address=address, log_to_driver=False, logging_level="ERROR")
    except Exception as error:
        first = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        where = f"--address {address}" if address else "Ray"
        raise SweepError(f"{where}: cannot be started or reached: {first}") from None
    return _slots(ray)


def _ray_folder(out: Path) -> str:
    """For sockets, whose paths must be short, and logs. The data set remembers which it is, so that
    what a killed sweep left is removed by the next one."""
    note, prefix = out / ".ray", "impedraw-ray-"
    left = os.path.basename(note.read_text(encoding="utf-8").strip()) if note.exists() else ""
    if left.startswith(prefix):
        path = os.path.join(tempfile.gettempdir(), left)
        if "ray" in sys.modules and os.path.isdir(path):
            return path  # of this sweep's own Ray, which goes on
        shutil.rmtree(path, ignore_errors=True)
    made = tempfile.mkdtemp(prefix=prefix)
    note.write_text(os.path.basename(made), encoding="utf-8")
    return made


_own: list[bool] = []  # the Ray of this process was started here, and is not the caller's


def _is_running() -> bool:
    return "ray" in sys.modules and bool(sys.modules["ray"].is_initialized())


def _cores() -> int:
    return len(os.sched_getaffinity(0))


def _slots(ray: Any) -> int:
    return max(1, int(ray.cluster_resources().get("CPU", 1)))


_runners: dict[str, Any] = {}  # in a worker: the runner of each sweep, with what it has cached


def _run_batch(identity: str, context: Context, cases: list[Case]) -> tuple[Any, float]:
    from .rows import run_cases

    start = time.perf_counter()
    if identity not in _runners:
        _runners.clear()
        _runners[identity] = make_runner(context)
    table = run_cases(context, _runners[identity], cases)
    return table, time.perf_counter() - start


def run_on_ray(context: Context, cases: Iterator[Case], total: int, on_rows: OnRows,
               tick: Callable[[], None], stop: Stop, address: str | None = None,
               workers: int | None = None, keep_ray: bool = False) -> None:
    """Runs the cases on a local Ray, or on the cluster at `address`. Raises Interrupted."""
    folder = _ray_folder(Path(context.out)) if address is None else None
    foreign = _is_running() and not _own
    slots = start_ray(address, workers, folder)
    import ray

    if address is None and not foreign:
        _own.append(True)
    for number in stop._before:  # ray.init may have put its own handlers
        signal.signal(number, stop._requested)
    try:
        _run(ray, context, Batches(cases, total), slots, on_rows, tick, stop, workers)
    finally:
        if address is None and not foreign and not (keep_ray and not stop.signal):
            ray.shutdown()
            _own.clear()
            shutil.rmtree(folder or "", ignore_errors=True)


def _run(ray: Any, context: Context, batches: Batches, slots: int, on_rows: OnRows,
         tick: Callable[[], None], stop: Stop, workers: int | None) -> None:
    from .rows import failed_table

    identity = secrets.token_hex(8)
    shared = ray.put(context)
    remote = ray.remote(num_cpus=1, max_retries=0, retry_exceptions=False,
                        max_calls=0)(_run_batch)
    deaths: dict[str, int] = {}
    running: dict[Any, list[Case]] = {}
    looked = time.monotonic()
    try:
        while True:
            if stop.signal:
                raise Interrupted
            if time.monotonic() - looked > 5.0:
                looked, slots = time.monotonic(), _slots(ray)
            most = 2 * min(slots, workers or slots)  # one batch waits at each worker
            while len(running) < most and (batch := batches.next(most)):
                running[remote.remote(identity, shared, batch)] = batch
            if not running:
                return
            ready, _ = ray.wait(list(running), num_returns=1, timeout=0.2)
            for reference in ready:
                batch = running.pop(reference)
                try:
                    table, seconds = ray.get(reference)
                except ray.exceptions.RayTaskError as error:
                    told = str(error.cause).strip().splitlines() or [type(error.cause).__name__]
                    raise SweepError(f"a worker: {told[0]}") from error
                except (ray.exceptions.WorkerCrashedError,
                        ray.exceptions.OutOfMemoryError) as error:
                    if len(batch) > 1:
                        half = len(batch) // 2
                        batches.again.extend([batch[:half], batch[half:]])
                        continue
                    case = batch[0]
                    deaths[case.key] = deaths.get(case.key, 0) + 1
                    if deaths[case.key] < WORKER_DEATHS:
                        batches.again.append(batch)
                        continue
                    memory = isinstance(error, ray.exceptions.OutOfMemoryError)
                    on_rows(failed_table(context, case, "crashed",
                                         "crashed: " + ("out of memory" if memory else
                                                        "its worker process ended")
                                         + f", {WORKER_DEATHS} times"))
                except ray.exceptions.RayError:  # the node, or what it kept, is gone
                    batches.again.append(batch)
                    time.sleep(0.1)
                else:
                    batches.learn(len(batch), seconds)
                    on_rows(table)
            tick()
    except Interrupted:
        # What is finished is kept; what runs is given up.
        ready, rest = ray.wait(list(running), num_returns=len(running), timeout=0) if (
            running) else ([], [])
        for reference in ready:
            try:
                on_rows(ray.get(reference)[0])
            except ray.exceptions.RayError:
                pass
        for reference in rest:
            ray.cancel(reference, force=True)
        raise


def content_digest(files: list[Path]) -> str:
    """Hash of the files' contents."""
    import hashlib

    hashed = hashlib.sha256()
    for file in files:
        hashed.update(hashlib.sha256(file.read_bytes()).digest())
    return hashed.hexdigest()[:32]
