"""What is said of a recording of a mechanism: of all samples, and which other numbers would make it likelier."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...estimate.run import KALMAN, recorded_apart
from ...files.progress import Progress
from ...kalman.apart.filters import Filters
from ...kalman.run import How
from ...laboratory.recording import Recording
from ...laboratory.subject import Subject
from ..checks import of_joints, of_limits, of_measurements, of_sensors
from ..doubts import BIAS, Weighed, doubts, needed_for, unknown
from ..finding import Finding
from ..innovations import of_innovations
from ..muscles import WHERE_ROUGH
from .variants import variants
from .weighing import Weighing

_OURS = f"{KALMAN}."


def of_all(read: Recording, subject: Subject, estimates: xr.Dataset) -> Iterator[Finding]:
    """Of every sample: sensors, units, and what the filter made of them."""
    settings = json.loads(estimates.attrs["settings"])
    by_hand = {path: value for path, value in settings["changes"].items() if path.startswith(_OURS)}
    case, record = recorded_apart(read, subject, by_hand)
    yield from of_measurements(case)
    yield from of_sensors(case)
    if failure := json.loads(estimates.attrs["failures"]).get(KALMAN):
        yield Finding("failure", failure, math.nan, True)
        return
    chains = json.loads(estimates.attrs["fits"])[KALMAN]["chains"]
    filters = Filters(record, {}, record.measured).linear()
    how = How(lag=None if settings["smooth"] else 0)
    ratios = filters.innovations({of: chain["u"]["numbers"] for of, chain in chains.items()}, how)
    noise = min(muscle.sigma_F for muscle in case.sizes.muscles.values())
    yield from of_innovations(read.time, ratios, noise, (*subject.names["position"], *subject.names["force"]))
    of = estimates.sel(observer=KALMAN)
    s, kept = case.scales, case.y[:: settings["keep_every"]]
    joints = len(subject.joints)
    # R F
    arms = subject.laws.moment_arms(kept[:, :joints])
    torques = (arms * kept[:, joints:, None]).sum(axis=1) * s.torques
    rest = of.disturbance_hat.values
    told = {name: j for j, name in enumerate(subject.joints) if np.isfinite(rest[:, j]).all()}
    yield from of_joints(
        {name: torques[:, j] for name, j in told.items()}, {name: rest[:, j] for name, j in told.items()}
    )
    yield from of_limits(dict(zip(subject.labels, of.activation_limited.mean("time").values.tolist(), strict=True)))


def of_muscles(read: Recording, subject: Subject, fit: Mapping[str, Any], progress: Progress) -> Iterator[Finding]:
    """What the likelihood says of the mechanism's numbers, with noise and densities found anew for each.

    fit: of estimates, which orders they have.
    """
    orders = {
        f"{of}.{name}": value
        for of, chain in fit["chains"].items()
        for form in ("u", "a")
        for name, value in chain.get(form, {}).get("numbers", {}).items()
        if name.startswith("order")
    }
    weighing = Weighing(read, subject, orders)
    # what one excitation does the others may do less clearly
    rough = any(fit["chains"][of]["jumps"] for of in subject.muscles)
    yield from _forms(weighing, rough)
    yield from _bias(weighing, subject)
    needed = needed_for(len(read))
    tried, weighed = list(variants(weighing, read, subject, needed, rough)), []
    for i, variant in enumerate(tried, start=1):
        weighed.append(variant.weighed())
        progress(i / len(tried))
    yield from doubts(weighed, needed)
    yield from _untold(weighed, needed, subject)


def _forms(weighing: Weighing, rough: bool) -> Iterator[Finding]:
    gains = {
        of: law.fit.log_likelihood - weighing.inputs[of].fit.log_likelihood for of, law in weighing.activations.items()
    }
    helps = ", ".join(of for of, gain in gains.items() if gain > 0)
    none = ", ".join(of for of, gain in gains.items() if gain <= 0)
    jump = f"but activations jump: {WHERE_ROUGH} alone can be weighed" if rough else "so numbers can be weighed"
    words = [
        f"fits {helps}, {jump}" if helps else "",
        f"is no help for {none}: numbers cannot be weighed" if none else "",
    ]
    least = min(gains.values())
    yield Finding("form", f"the muscles' law with smooth activations {'; '.join(filter(None, words))}", least)


def _bias(weighing: Weighing, subject: Subject) -> Iterator[Finding]:
    """What no likelihood sees; nothing where a tendon has no slope."""
    changes = weighing.biased({of: BIAS * muscle.F_max for of, muscle in subject.muscles.items()})
    if np.isfinite(list(changes.values())).all():
        least, most = min(changes, key=changes.__getitem__), max(changes, key=changes.__getitem__)
        told = (
            f"{changes[most]:.2g}"
            if least == most
            else f"{changes[least]:.2g} ({least}) to {changes[most]:.2g} ({most})"
        )
        yield Finding(
            "bias",
            f"a constant error of a force cannot be seen: {BIAS:.0%} of F_max would change an activation by {told}",
            changes[most],
        )


def _untold(weighed: Sequence[Weighed], needed: float, subject: Subject) -> Iterator[Finding]:
    """Numbers of which the recording tells nothing, those of several muscles together."""
    owners: dict[str, list[str]] = {}
    for what in unknown(weighed, needed):
        owners.setdefault(what.name, []).append(what.number.rpartition(".")[0])
    told = [
        name
        + ("" if not all(of) else " of all muscles" if len(of) == len(subject.muscles) > 1 else f" of {', '.join(of)}")
        for name, of in owners.items()
    ]
    if told:
        yield Finding("untold", f"the recording cannot tell: {'; '.join(told)}", float(sum(map(len, owners.values()))))
