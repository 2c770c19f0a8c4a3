"""A dask cluster of this machine for one sweep: a scheduler in this process, workers as processes, none left behind."""

from __future__ import annotations

import contextlib
import importlib
import logging
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING

from .dask import distributed

if TYPE_CHECKING:
    from distributed import Client, Security

LOOPBACK = "127.0.0.1"
# seconds a worker may take to start, and after which it gives up if its scheduler is gone
_ORPHANED = 60
_LOOK = 0.1  # seconds between two looks at a worker


@contextlib.contextmanager
def local_client(workers: int) -> Iterator[Client]:
    """The client of a cluster with that many workers of one thread, for nobody else.

    It listens on loopback only, with a certificate of the moment, since ports of loopback are open to all users of a
    machine. The workers are commands of their own: a script needs no `if __name__ == "__main__"`, and a Ctrl-C in the
    terminal reaches us alone.
    """
    dask, config = distributed(), importlib.import_module("dask.config")
    security = dask.Security.temporary()
    with contextlib.ExitStack() as stack:
        stack.enter_context(config.set(_settings(security)))
        cluster = stack.enter_context(
            dask.LocalCluster(
                n_workers=0,
                host=LOOPBACK,
                security=security,
                scheduler_kwargs={"dashboard": False, "dashboard_address": f"{LOOPBACK}:0"},
                silence_logs=logging.CRITICAL,
            )
        )
        client = stack.enter_context(dask.Client(cluster, set_as_default=False))
        # without dask's nanny, which gives up on a worker that dies while it starts
        command = [sys.executable, "-P", "-m", "distributed.cli.dask_worker", cluster.scheduler_address]
        command += ["--no-nanny", "--nthreads", "1", "--host", LOOPBACK]
        # without a dashboard there is still a server of web pages, by default for everyone
        command += ["--no-dashboard", "--dashboard-address", f"{LOOPBACK}:0"]
        command += ["--death-timeout", str(_ORPHANED)]
        environment = {**os.environ, "DASK_INTERNAL_INHERIT_CONFIG": config.serialize(config.global_config)}
        stack.enter_context(kept_alive(workers, command, environment))
        yield client


@contextlib.contextmanager
def kept_alive(workers: int, command: list[str], environment: dict[str, str]) -> Iterator[None]:
    """As many workers as asked for; one that ends is replaced until the context ends."""
    over = threading.Event()

    def keep() -> None:
        while not over.is_set():
            # a start that the system refuses is tried again
            with contextlib.suppress(OSError):
                worker = _start(command, environment)
                while worker.poll() is None and not over.wait(_LOOK):
                    pass
                _end(worker)
            over.wait(_LOOK)

    # started in threads: Python handles signals in the main thread, so none comes between a start and its `_end`
    keepers = [threading.Thread(target=keep) for _ in range(workers)]
    try:
        for keeper in keepers:
            keeper.start()
        yield
    finally:
        over.set()
        for keeper in keepers:
            if keeper.ident:
                keeper.join()


def _settings(security: Security) -> dict[str, object]:
    """The configuration of workers: the certificate, and no web pages."""
    tls = security.get_tls_config_for_role("worker")
    return {
        "distributed.scheduler.http.routes": [],
        "distributed.worker.http.routes": [],
        "distributed.comm.require-encryption": True,
        "distributed.comm.tls.ca-file": tls["ca_file"],
        "distributed.comm.tls.worker.cert": tls["cert"],
        "distributed.comm.tls.worker.key": tls["key"],
    }


def _start(command: list[str], environment: dict[str, str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _end(worker: subprocess.Popen[bytes]) -> None:
    """End a worker and what it has started, at once: asked to go, it would first finish what it does."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(worker.pid, signal.SIGKILL)
    worker.wait()
