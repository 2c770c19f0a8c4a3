"""What looks wrong in a recording before any likelihood is asked: units, sensors that are dead, limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...model.arrays import Array
from ..estimate.case import Case
from ..estimate.forces import weak
from .finding import Finding, plain
from .hanging import hanging

# subjects of what no muscle measures
UNMEASURED = ("force", "position", "fibre")
# optimal fibre lengths that a fibre can have, and the share of samples that may lie beyond
_SHORTEST, _LONGEST, _SHARE = 0.3, 1.9, 0.05
# a signal whose standard deviation is below so many of that of its noise stands still
_STILL = 2.0
# share of samples whose activation may be at a limit
_LIMITED = 0.1
# what fibres of impossible lengths may mean
_OF_PAIR = "position or a length of the muscle file may be in another unit, such as mm"
_OF_MECHANISM = "an angle may be in another unit or inverted, or a length of the mechanism be another"
# the rest of the acceleration, over that which the forces explain
_UNEXPLAINED = 3.0


def of_measurements(case: Case) -> Iterator[Finding]:
    """Of positions and forces as they are: what no muscle measures."""
    subject, sizes = case.subject, case.sizes
    joints = len(subject.system.joints)
    positions, forces = case.y[:, :joints], case.y[:, joints:]
    for name, position, joint in zip(subject.names["position"], positions.T, sizes.joints.values(), strict=True):
        if _stands_still(position, joint.sigma):
            yield _still("position", name, "a broken sensor?", position)
    for (name, muscle), force, size in zip(subject.forces.items(), forces.T, sizes.muscles.values(), strict=True):
        largest = float(np.max(force)) * case.scales.force / muscle.F_max
        if not force.any():
            yield Finding("force", f"{name} is 0 throughout: a dead sensor, or a muscle that is slack", 0.0, True)
        elif sentence := weak(name, largest):
            yield Finding("force", sentence, largest, True)
        elif _stands_still(force, size.sigma_F):
            yield _still("force", name, "a dead sensor or amplifier?", force)
    lengths, along = subject.fibres(positions, case.z)
    for label, muscle, length in zip(subject.labels, subject.muscles.values(), (lengths * along).T, strict=True):
        fibre = length / muscle.optimal_fibre_length
        beyond = float(np.mean((fibre < _SHORTEST) | (fibre > _LONGEST)))
        if beyond > _SHARE:
            yield Finding(
                "fibre",
                f"fibre {label} would be {np.median(fibre):.2g} optimal lengths long (median): "
                + (_OF_MECHANISM if subject.joints else _OF_PAIR),
                beyond,
                True,
            )


def of_sensors(case: Case) -> Iterator[Finding]:
    """Of sensors that do not measure all the time."""
    for i, name in enumerate(case.recording.measured):
        if when := hanging(case.recording.time, case.y[:, i], case.period):
            start, end = when
            yield Finding(
                "sensor",
                f"{name} is the same number from {start:.4g} to {end:.4g} s, without its noise: a sensor that hangs, "
                "or is at the end of its range",
                end - start,
                True,
                when,
            )


def of_estimates(pull: Array, rest: Array, limited: Sequence[float]) -> Iterator[Finding]:
    """Of what a filter makes of them: both forces together (n), the external force (n), N; which share is limited."""
    explained, unexplained = float(np.std(pull)), float(np.std(rest))
    # forces that stand still explain nothing, whatever the mass
    if explained and unexplained > _UNEXPLAINED * explained:
        ratio = unexplained / explained
        yield Finding(
            "acceleration",
            f"the mass accelerates {plain(ratio)} times as much as the forces explain: it may be smaller, or the "
            "forces may be in kN",
            ratio,
            True,
        )
    yield from of_limits(dict(enumerate(limited, start=1)))


def of_joints(torques: Mapping[str, Array], rest: Mapping[str, Array]) -> Iterator[Finding]:
    """The same of each joint: what the muscles do to it and what else does (n)."""
    for of, torque in torques.items():
        explained, unexplained = float(np.std(torque)), float(np.std(rest[of]))
        if explained and unexplained > _UNEXPLAINED * explained:
            ratio = unexplained / explained
            yield Finding(
                "acceleration",
                f"something else moves {of} {plain(ratio)} times as much as its muscles: masses may be smaller, forces "
                "in kN, or an angle inverted",
                ratio,
                True,
            )


def of_limits(limited: Mapping[int | str, float]) -> Iterator[Finding]:
    """Of the share of samples in which the activation of each muscle is at a limit."""
    for label, share in limited.items():
        if share > _LIMITED:
            yield Finding(
                "limited",
                f"activation {label} is at a limit in {share:.0%} of the samples: F_max, a length of the muscle or "
                "its curves may be another",
                share,
                True,
            )


def _stands_still(signal: Array, sigma: float) -> bool:
    return float(np.std(signal)) <= _STILL * sigma or not np.ptp(signal)


def _still(subject: str, name: str, why: str, signal: Array) -> Finding:
    return Finding(subject, f"{name} stands still within its noise: {why}", float(np.ptp(signal)), True)
