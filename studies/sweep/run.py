"""Many runs of one scenario over parameters and seeds: in parts, on all cores, resumed where they were left."""

from __future__ import annotations

import contextlib
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from ...codegen.batch import CompiledLoop, compile_loop
from ...codegen.toolchain import NATIVE, PORTABLE
from ...observers.score import MEASURES
from ..files.datasets.netcdf import LARGEST_RESULT, load, netcdf
from ..files.errors import ResultError, ScenarioError
from ..files.numbers import whole
from ..files.progress import CountedProgress, unseen
from ..files.reading import cause
from ..scenarios.layers import Value
from ..scenarios.observers import Observers
from ..simulate.run import recorded
from .axes import Values
from .cluster.client import on_cluster
from .computing import Compute, SweepWarning, on_threads
from .dataset import sweep_dataset
from .parts import Parts
from .plan import Plan, plan
from .points import compute_at_half_step
from .schema import check_sweep

# no machine has so many cores
_MOST_WORKERS = 10_000


def sweep(
    source: str | Path = "paper-clean",
    over: Mapping[str, Values] | None = None,
    seeds: int | Sequence[int] = 1,
    observers: Observers = None,
    changes: Mapping[str, Value] | None = None,
    kind: str = "grid",
    samples: int = 0,
    out: str | Path | None = None,
    workers: int | None = None,
    target: str | None = None,
    quantities: Sequence[str] | None = None,
    measures: Sequence[str] = MEASURES,
    progress: CountedProgress | None = None,
    cluster: str | None = None,
    corrected: bool = False,
) -> xr.Dataset:
    """Run a scenario for all values in `over` and all seeds, and return the measures of each run.

    source, observers, changes, corrected: as for `simulate`; "baseline" is an observer too. By default those whose
        numbers are swept, or all.
    over: path → values, or a `Range`; one dimension each, named by the path (`point`, if not a grid).
    seeds: how many, from 0, or which. kind: grid, zip, or a design of `samples` points: latin, sobol.
    out: file of the result; what is computed is kept beside it, and the same call goes on where it was.
    workers: threads, or processes of a local cluster; by default one per core.
    target: processors to compile for: native, scalar, x86-64-v3, …; by default this one, or for a cluster a class of
        them: on all machines of it, and here with the same target, results are the same to the bit.
    quantities, measures: what is scored, and how beside the RMSE; the fewer, the faster.
    progress: called with the runs done and all runs; those of an earlier start count as done at once.
    cluster: `local`, or the address of a dask scheduler, see docs/scaling.md; needs the extra `cluster`.

    The Dataset has rmse, peak, settling, chattering (…, seed, observer, quantity), failed_at (…, seed, observer) and
    plant_failed_at (…, seed): the time of a failure or NaN; after one, measures are NaN. failure and plant_failure say
    what failed, as an index into the attribute flag_meanings; 0 is none. Of the runs `sampled`, spread evenly, it has
    the `…_step_error` of each measure (sampled, observer, quantity), as `simulate` has. Everything is dimensionless.
    ScenarioError for what cannot be run, ResultError for `out`, BuildError if nothing can be compiled, ClusterError for
    a cluster that is not there, lost, or of other code.

    >>> found = hillobs.sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1, 0.2, 0.4]}, seeds=4)
    >>> best = found.rmse.median("seed").idxmin("high_gain.eps_h")
    >>> best.sel(observer="high_gain", quantity=["x2", "a1"]).values
    array([0.2, 0.1])
    """
    checked = plan(source, over or {}, seeds, observers, changes, kind, samples, quantities, measures, corrected)
    with engine(workers, cluster) as (compute, usual):
        chosen = usual if target is None else target
        return sweep_planned(checked, None if out is None else Path(out), compute, chosen, progress or unseen)


@contextlib.contextmanager
def engine(workers: int | None, cluster: str | None) -> Iterator[tuple[Compute, str]]:
    """What computes parts, here or on a cluster, and the target that goes with it."""
    if workers is not None:
        workers = whole("workers", workers, 1, _MOST_WORKERS)
    if cluster is None:
        yield on_threads(workers), NATIVE
        return
    with on_cluster(cluster, workers) as compute:
        yield compute, PORTABLE


def sweep_planned(
    plan: Plan, out: Path | None, compute: Compute, target: str = NATIVE, progress: CountedProgress = unseen
) -> xr.Dataset:
    """Run what `plan` has checked, keeping parts and result at `out` if it is given."""
    if (size := plan.runs * plan.row.itemsize) > LARGEST_RESULT:
        raise ScenarioError(f"{plan.runs:,} runs make a result of {size / 1e9:.0f} GB; cut the sweep into several")
    if out is not None and (not out.name or out.is_dir()):
        raise ResultError(f"{str(out)!r} is no name for a result: it must be that of a file")
    # what is there and no result is refused before anything is compiled
    earlier = None if out is None else _earlier(out)
    compiled = compile_loop(plan.loop, target)
    identity = plan.identity(compiled.path.stem)
    if out is None:
        return _computed(plan, compiled, identity, compute, progress)
    parts = Parts(out, identity, plan.description(compiled.path.stem), plan.row)
    if earlier is not None:
        _check_complete(earlier, out, identity, plan, progress)
        parts.remove_left()
        return earlier
    with parts:
        if (finished := _earlier(out)) is not None:  # by another process just now
            _check_complete(finished, out, identity, plan, progress)
            parts.remove()
            return finished
        result = _computed(plan, compiled, identity, compute, progress, parts)
        parts.finish(netcdf(result))
        return result


def _computed(
    plan: Plan,
    compiled: CompiledLoop,
    identity: str,
    compute: Compute,
    progress: CountedProgress,
    parts: Parts | None = None,
) -> xr.Dataset:
    """The result; what `parts` has whole is read, what it has not is computed and kept there."""
    rows = np.empty(plan.runs, plan.row)
    missing = dict.fromkeys(range(plan.parts))
    for part in parts or ():
        if part in missing and parts and (kept := parts.read(part)) is not None:
            rows[plan.members(part)] = kept
            del missing[part]
    if parts and parts.damaged:
        words = "1 damaged part is" if parts.damaged == 1 else f"{parts.damaged} damaged parts are"
        warnings.warn(f"{parts.folder}: {words} computed again", SweepWarning, stacklevel=4)
    done = plan.runs - sum(len(plan.members(part)) for part in missing)
    progress(done, plan.runs)
    # its threads end with it, however it ends
    with contextlib.closing(compute(plan, compiled, missing)) as computed:
        for part, fresh in computed:
            rows[plan.members(part)] = fresh
            if parts:
                parts.write(part, fresh)
            done += len(fresh)
            progress(done, plan.runs)
    halved = compute_at_half_step(plan, compiled, plan.sample())
    truth = recorded(plan.prepared, compiled)[compiled.loop.truth.name]
    return sweep_dataset(plan, rows, halved, truth, identity, compiled)


def _earlier(out: Path) -> xr.Dataset | None:
    """The result that is there already. ResultError if something else is, or another user's: nobody speaks for us."""
    try:
        owner = out.lstat().st_uid
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise ResultError(f"{out} cannot be read: {cause(error)}") from error
    if owner != os.geteuid():
        raise ResultError(f"{out} is there already, of another user; name another --out")
    return load(out)


def _check_complete(result: xr.Dataset, out: Path, identity: str, plan: Plan, progress: CountedProgress) -> None:
    """ResultError if what is there is not the result of this sweep."""
    if result.attrs.get("identity") != identity:
        raise ResultError(f"{out} is there already, and is the result of something else; name another --out")
    try:
        check_sweep(result)
    except ResultError as error:
        raise ResultError(f"{out} is there already, and cannot be used: {error}") from error
    progress(plan.runs, plan.runs)
