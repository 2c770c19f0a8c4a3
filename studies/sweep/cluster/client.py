"""Parts of a sweep on the workers of a dask cluster: lost workers' parts are done again, killers of workers named."""

from __future__ import annotations

import asyncio
import contextlib
import importlib
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

from ...files.errors import ClusterError
from ...files.quote import shown

if TYPE_CHECKING:
    from distributed import Client, Future

    from ....codegen.batch import CompiledLoop
    from ....model.arrays import Array
    from ..computing import Compute, Computed
    from ..plan import Plan

LOCAL = "local"

_ADDRESS = re.compile(r"(?:(tcp|tls)://)?(\[[0-9a-fA-F:.]+\]|[\w.-]+):(\d{1,5})", re.ASCII)
_ANSWER = 5.0  # seconds that a scheduler may take to answer at first
_PATIENCE = 60.0  # seconds that a cluster may be without a worker
_LOOK = 1.0  # seconds between two looks at a silent cluster
_AHEAD = 2  # parts under way for each thread of the cluster


class ClusterWarning(UserWarning):
    """Something about a cluster that should be known."""


@contextlib.contextmanager
def on_cluster(address: str, workers: int | None = None) -> Iterator[Compute]:
    """Parts on the workers of the dask scheduler at `address`, or of a cluster on this machine for `local`.

    workers: processes of a local cluster. ClusterError for what is no address, where no scheduler answers, for workers
    with other code, and when the cluster is lost. Who can reach a port of a scheduler or worker can run code there.
    """
    if address != LOCAL and not _ADDRESS.fullmatch(address):
        raise ClusterError(f"{shown(address)} is no cluster; there are local, tcp://HOST:PORT and tls://HOST:PORT")
    if address != LOCAL and workers is not None:
        raise ClusterError("a cluster has the workers it has; their number is chosen for --cluster local only")
    try:
        dask = importlib.import_module("distributed")
    except ImportError as error:
        raise ClusterError("a cluster needs dask: pip install 'hillobs[cluster]'") from error
    from ..computing import cores
    from .local import local_client

    with dask.utils.silence_logging_cmgr(logging.CRITICAL), contextlib.ExitStack() as stack:
        if address == LOCAL:
            client = stack.enter_context(local_client(workers or cores()))
        else:
            client = stack.enter_context(_connected(address))
            warn_of_open_ports([client.scheduler.address, *client.nthreads()])

        def compute(wanted: Plan, compiled: CompiledLoop, parts: Iterable[int]) -> Computed:
            from .worker import order

            suspects: list[int] = []
            killers: list[int] = []
            told = order(wanted, compiled)
            try:
                crew = _Crew(client, address, told)
                yield from crew.run(parts, suspects.append)
                # dask also blames what only waited beside the killer: each once more, alone
                for part in suspects:
                    yield from crew.run([part], killers.append)
            except (OSError, CancelledError) as error:
                raise ClusterError(f"the scheduler of {address} is gone") from error
            if killers:
                raise ClusterError(_blame(wanted, killers))

        yield compute


class _Crew:
    """The workers of one cluster at the parts of one sweep."""

    def __init__(self, client: Client, address: str, told: str) -> None:
        self._client, self._address = client, address
        # a task, not data: dask makes it again if the worker that holds it is lost
        self._told = client.submit(str, told, pure=False)
        self._ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._seen = time.monotonic()  # when there was a worker or a result

    def run(self, parts: Iterable[int], killed: Callable[[int], None]) -> Iterator[tuple[int, Array]]:
        """Parts in the order in which they are done; those whose workers died again and again go to `killed`."""
        from .worker import work

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
            finished = []
            for future in self._batch():
                part, _ = running.pop(future.key)
                if future.status == "finished":
                    finished.append((part, future))
                elif future.status == "error" and type(future.exception()).__name__ == "KilledWorker":
                    killed(part)
                else:
                    raise self._failure(future)
            numbers = self._client.gather([future for _, future in finished])
            yield from zip((part for part, _ in finished), numbers, strict=True)

    def _room(self) -> int:
        """How many parts may be under way."""
        threads: int = sum(self._client.nthreads().values())
        return _AHEAD * max(1, threads)

    def _batch(self) -> list[Future]:
        """The futures that have ended, one at least. ClusterError if nothing can be hoped for."""
        while True:
            with contextlib.suppress(queue.Empty):
                found = [self._ended.get(timeout=_LOOK)]
                while not self._ended.empty():
                    found.append(self._ended.get())
                self._seen = time.monotonic()
                return found
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
    dask = importlib.import_module("distributed")

    async def knock() -> None:
        """Connect once: dask's own client would wait for ever for what is no scheduler."""
        own = dask.Security().get_connection_args("client")
        comm = await asyncio.wait_for(dask.comm.connect(address, timeout=_ANSWER, **own), _ANSWER)
        await comm.close()

    try:
        # a thread of its own: in a notebook, this one runs a loop already
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
    """Say if anyone on the network can read, and run code."""
    for address in addresses:
        found = _ADDRESS.fullmatch(address)
        if found and found[1] != "tls" and not _is_loopback(found[2].strip("[]")):
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


def _blame(wanted: Plan, parts: list[int]) -> str:
    """The parts that ended their workers, and what the runs of the first have in common."""
    runs = wanted.members(parts[0])
    points = wanted.axes.at(runs // len(wanted.seeds))
    seeds = wanted.seeds[runs % len(wanted.seeds)]
    columns = [*zip(wanted.axes.paths, points.T, strict=True), ("seed", seeds)]
    where = ", ".join(f"{name} = {_span(values.tolist())}" for name, values in columns)
    more = f"; {len(parts) - 1} more parts did too" if len(parts) > 1 else ""
    return f"part {parts[0]} ended every worker that took it: runs {runs[0]:,} to {runs[-1]:,}, {where}{more}"


def _span(values: list[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:.6g}" if low == high else f"{low:.6g} … {high:.6g}"
