"""Parts of a sweep on the workers of a dask cluster: lost workers' parts are done again, killers of workers named."""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import itertools
import logging
import queue
import re
import time
import warnings
from asyncio import CancelledError
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from ....codegen.batch import CompiledLoop
from ...files.errors import ClusterError
from ...files.quote import shown
from ..computing import Compute, Computed, cores
from ..plan import Plan
from ..row import Rows
from .dask import distributed
from .local import local_client
from .worker import order, work

if TYPE_CHECKING:
    from distributed import Client, Future

LOCAL = "local"

_ADDRESS = re.compile(r"(?:(tcp|tls)://)?(\[[0-9a-fA-F:.]+\]|[\w.-]+):(\d{1,5})", re.ASCII)
_ANSWER = 5.0  # seconds that a scheduler may take to answer at first
_PATIENCE = 60.0  # seconds that a cluster may be without a worker
_LOOK = 1.0  # seconds between two looks at a silent cluster
# what becomes of a future whose worker dies after it has finished
_LOST = ("lost", "pending")
_AHEAD = 2  # parts under way for each thread of the cluster


class ClusterWarning(UserWarning):
    """Something about a cluster that should be known."""


@contextlib.contextmanager
def on_cluster(address: str, workers: int | None = None) -> Iterator[Compute]:
    """Parts on the workers of the dask scheduler at `address`, or of a cluster on this machine for `local`.

    workers: processes of a local cluster. ClusterError for what is no address, where no scheduler answers, for workers
    with other code, and when the cluster is lost. Who can reach a port of dask can run code there.
    """
    if address != LOCAL and not _ADDRESS.fullmatch(address):
        raise ClusterError(f"{shown(address)} is no cluster; there are local, tcp://HOST:PORT and tls://HOST:PORT")
    if address != LOCAL and workers is not None:
        raise ClusterError("a cluster has the workers it has; their number is chosen for --cluster local only")
    dask = distributed()
    with dask.utils.silence_logging_cmgr(logging.CRITICAL), contextlib.ExitStack() as stack:
        if address == LOCAL:
            client = stack.enter_context(local_client(workers or cores()))
        else:
            client = stack.enter_context(_connected(address))
            warn_of_open_ports([client.scheduler.address, *client.nthreads()])

        def compute(plan: Plan, compiled: CompiledLoop, parts: Iterable[int]) -> Computed:
            suspects: list[int] = []
            killers: list[int] = []
            told = order(plan, compiled)
            try:
                crew = _Crew(client, address, told)
                yield from crew.run(parts, suspects.append)
                # dask also blames parts that only waited on the same worker: each is tried once more, alone
                for part in suspects:
                    yield from crew.run([part], killers.append)
            except (OSError, CancelledError) as error:
                raise ClusterError(f"the scheduler of {address} is gone") from error
            if killers:
                raise ClusterError(_blame(plan, killers))

        yield compute


class _Crew:
    """The workers of one cluster at the parts of one sweep."""

    def __init__(self, client: Client, address: str, told: str) -> None:
        self._client, self._address = client, address
        # a task, not data: dask computes it again if the worker that holds it is lost
        self._told = client.submit(str, told, pure=False)
        self._ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._seen = time.monotonic()  # when there was a worker or a result

    def run(self, parts: Iterable[int], killed: Callable[[int], None]) -> Iterator[tuple[int, Rows]]:
        """Parts in the order in which they end; `killed` is called with those whose workers died again and again."""
        waiting = iter(parts)
        running: dict[object, tuple[int, Future]] = {}
        while True:
            # a sweep of a million parts has no million futures
            for part in itertools.islice(waiting, max(0, self._room() - len(running))):
                future = self._client.submit(work, self._told, part, pure=False)
                running[future.key] = part, future
                future.add_done_callback(self._ended.put)
            if not running:
                return
            for future in self._batch():
                part, _ = running.pop(future.key)
                if (rows := self._rows(future)) is not None:
                    yield part, rows
                elif future.status in _LOST:
                    waiting = itertools.chain([part], waiting)
                elif future.status == "error" and type(future.exception()).__name__ == "KilledWorker":
                    killed(part)
                else:
                    raise self._failure(future)

    def _rows(self, future: Future) -> Rows | None:
        """The rows of a future that has ended; None if it has none, or if the worker that holds them is lost."""
        if future.status != "finished":
            return None
        try:
            rows: Rows = self._client.gather(future)
        except CancelledError:
            if future.status in _LOST:
                return None
            raise
        return rows

    def _room(self) -> int:
        """How many parts may be under way."""
        threads: int = sum(self._client.nthreads().values())
        return _AHEAD * max(1, threads)

    def _batch(self) -> list[Future]:
        """The futures that have ended, at least one. ClusterError if the cluster has had no worker for too long."""
        while True:
            with contextlib.suppress(queue.Empty):
                batch = [self._ended.get(timeout=_LOOK)]
                while not self._ended.empty():
                    batch.append(self._ended.get())
                self._seen = time.monotonic()
                return batch
            if self._client.nthreads():
                self._seen = time.monotonic()
            elif time.monotonic() - self._seen > _PATIENCE:
                raise ClusterError(f"the cluster {self._address} has had no worker for {_PATIENCE:g} s")

    def _failure(self, future: Future) -> BaseException:
        """Why a part has no numbers."""
        error = future.exception() if future.status == "error" else CancelledError()
        if isinstance(error, ClusterError | CancelledError):
            return error
        return ClusterError(f"a worker of {self._address} failed: {type(error).__name__}: {error}")


@contextlib.contextmanager
def _connected(address: str) -> Iterator[Client]:
    dask = distributed()

    async def knock() -> None:
        """Connect once: dask's own client waits forever for anything that is not a scheduler."""
        security = dask.Security().get_connection_args("client")
        comm = await asyncio.wait_for(dask.comm.connect(address, timeout=_ANSWER, **security), _ANSWER)
        await comm.close()

    try:
        # in a thread of its own: a notebook already runs an event loop in this one
        ThreadPoolExecutor(1).submit(lambda: asyncio.run(knock())).result()
        client = dask.Client(address, timeout=_ANSWER, set_as_default=False)
    except TypeError as error:
        raise ClusterError(f"for {address} dask has no certificates; see docs/scaling.md") from error
    except (OSError, ValueError, RuntimeError) as error:
        reason = str(error) or f"no word of its protocol within {_ANSWER:g} s"
        raise ClusterError(f"no scheduler of dask answers at {address}: {reason}") from error
    with client:
        yield client


def warn_of_open_ports(addresses: Iterable[str]) -> None:
    """Warn of the first address where anyone on the network can read what is sent, and run code."""
    for address in addresses:
        known = _ADDRESS.fullmatch(address)
        if known and known[1] != "tls" and not _is_loopback(known[2].strip("[]")):
            message = (
                f"{address} is open: who can reach its port can run code there and read what is sent; "
                "use tls://, see docs/scaling.md"
            )
            warnings.warn(message, ClusterWarning, stacklevel=4)
            return


def _is_loopback(host: str) -> bool:
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


def _blame(plan: Plan, parts: list[int]) -> str:
    """The parts that ended their workers, and what the runs of the first have in common."""
    runs = plan.members(parts[0])
    columns = [*zip(plan.axes.paths, plan.points(runs).T, strict=True), ("seed", plan.seeds_of(runs))]
    where = ", ".join(f"{name} = {_span(values.tolist())}" for name, values in columns)
    others = len(parts) - 1
    more = f"; {others} more part{'s' if others > 1 else ''} did too" if others else ""
    return f"part {parts[0]} ended every worker that took it: runs {runs[0]:,} to {runs[-1]:,}, {where}{more}"


def _span(values: list[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:.6g}" if low == high else f"{low:.6g} … {high:.6g}"
