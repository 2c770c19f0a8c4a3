"""The controller of any system: what it tracks and how, and that pretension is in its null space."""

import casadi as ca
import numpy as np
import pytest

from hillobs.codegen.stepper import functions
from hillobs.model.arrays import Array
from hillobs.model.block import Block, BlockError, Symbols, symbols
from hillobs.model.control.backstepping import riccati
from hillobs.model.control.tracking import tracking
from hillobs.model.curves import CURVES
from hillobs.model.loops.mechanism_loop import mechanism_loop
from hillobs.model.loops.start import start, start_parameters
from hillobs.model.mechanism import mechanism_system
from hillobs.studies.laboratory.subject import subject_of
from places import RECORDINGS

ARM = subject_of(RECORDINGS / "arm.toml")
SYSTEM = ARM.system
HAND = ("hand.x", "hand.y")
# a figure-of-eight of 16 cm × 9 cm in 4 s, in units of the first muscle
ROUND = 40.0
EIGHT = {
    "initial.shoulder.q": -0.2,
    "initial.elbow.q": 1.4,
    **{f"initial.{muscle}.a": 0.2 for muscle in SYSTEM.muscles},
    "reference.hand.x.offset": 1.1634,
    "reference.hand.x.amplitude": 0.08 / ARM.scales.length,
    "reference.hand.x.frequency": 2 * np.pi / ROUND,
    "reference.hand.y.offset": 3.1112,
    "reference.hand.y.amplitude": 0.045 / ARM.scales.length,
    "reference.hand.y.frequency": 4 * np.pi / ROUND,
}


def numbers(block: Block, given: dict[str, float]) -> list[float]:
    """The numbers of a truth: given, the muscles', or usual."""
    known = ARM.scales.numbers
    usual = {name: known.get(p.shared or name, p.default) for name, p in block.parameters.items()}
    return [{**usual, **given}[name] for name in block.p]


def accelerations_at_start(place: tuple[float, float], activation: float) -> float:
    """The largest of both joints."""
    truth = mechanism_loop(SYSTEM, "given", (), ARM.scales.rate)
    start = dict(zip(("initial.shoulder.q", "initial.elbow.q"), place, strict=True))
    p = numbers(truth, {**start, **{f"initial.{m}.a": activation for m in SYSTEM.muscles}})
    x = functions(truth, (), ())["init"](0, p, [], [])
    rates = ca.Function("dx", [truth.x.vector(), truth.u.vector(), truth.p.vector()], [truth.dx.vector()])
    dx = dict(zip(truth.dx, np.array(rates(x, 0, p)).ravel(), strict=True))
    return float(max(abs(dx[name]) for name in SYSTEM.joint("dq")))


@pytest.mark.parametrize("activation", [0.05, 0.3])
def test_a_run_starts_with_joints_that_do_not_accelerate(activation: float) -> None:
    """In the middle and at the ends of all ranges; 1e−10: a ridge of 1e−12 of forces that accelerate by a hundred."""
    for place in ((-0.2, 1.4), (0.1, 1.6), (-0.9, 0.3), (0.4, 2.0)):
        assert accelerations_at_start(place, activation) < 1e-10


def test_muscles_that_can_be_slack_start_in_balance_too() -> None:
    """Thelen's activations are no straight line of the force, and their tendons have none below slack length."""
    curves = dict.fromkeys(SYSTEM.muscles, CURVES["thelen2003"])
    mechanism = ARM.mechanism
    tree = mechanism.tree.scaled(ARM.scales.length, ARM.scales.mass, ARM.scales.rate)
    paths = {
        name: path.scaled(ARM.scales.length, {"shoulder": 1.0, "elbow": 1.0}) for name, path in mechanism.paths.items()
    }
    system = mechanism_system(tree, paths, curves, frozenset(m for m, of in ARM.muscles.items() if of.pennation))
    p = symbols({**start_parameters(system), **system.curve_parameters})
    x = start(system, p)
    forces = [curves[m].Phi_S(x[f"{m}.L_S"], p.part(m)) for m in system.muscles]
    at = [x[f"{joint}.q"] for joint in system.joints]
    acc = system.accelerations(at, [x[f"{joint}.dq"] for joint in system.joints], forces, p)
    function = ca.Function("acc", [p.vector()], [ca.vertcat(*acc, *forces)])
    known = {**ARM.scales.numbers, "initial.shoulder.q": -0.2, "initial.elbow.q": 1.4}
    parameters = {**start_parameters(system), **system.curve_parameters}
    told = np.array(function([known.get(name, one.default) for name, one in parameters.items()])).ravel()
    assert np.abs(told[:2]).max() < 1e-10
    assert (told[2:] > 0).all()


def lie(truth: Block, expressions: ca.SX) -> ca.SX:
    """The derivative with respect to time along a truth that moves as it does."""
    x, t = truth.x.vector(), truth.u.t
    return ca.jtimes(expressions, x, truth.dx.vector()) + ca.jacobian(expressions, t)


def test_the_error_obeys_the_law_that_the_backstepping_promises() -> None:
    """ẇ = −γ w − BᵀP (e, ė), w = ë + K (e, ė), by three derivatives of the truth, at states off the reference."""
    truth = mechanism_loop(SYSTEM, "virtual", HAND, ARM.scales.rate)
    q = [truth.x[name] for name in SYSTEM.joint("q")]
    places = SYSTEM.places(q)
    e = ca.vertcat(*(places[name] - truth.y[f"r.{name}"] for name in HAND))
    de = lie(truth, e)
    dde = lie(truth, de)
    p = truth.p.part("controller")
    K, P = riccati(Symbols(m=ca.SX(1), q=p.q, R=p.R))
    w = dde + K[0] * e + K[1] * de
    law = lie(truth, w) + p.gamma * w + P[1, 0] * e + P[1, 1] * de
    both = ca.Function("law", [truth.x.vector(), truth.u.vector(), truth.p.vector()], [law, w, truth.guards.vector()])
    values = numbers(truth, EIGHT)
    x = np.array(functions(truth, (), ())["init"](0, values, [], [])).ravel()
    rng = np.random.default_rng(1)
    for _ in range(5):
        off = x.copy()
        off[:4] += 0.02 * rng.standard_normal(4)
        residual, size, guards = both(off, rng.uniform(0, ROUND), values)
        names = dict(zip(truth.guards, np.array(guards).ravel(), strict=True))
        assert not any(limit for name, limit in names.items() if "controller" in name)
        # a ridge of 1e−12 of the trace, the condition 1e4 of G W Gᵀ, and terms up to 1e3 times larger than w
        assert np.abs(np.array(residual)).max() < 1e-5 * np.abs(np.array(size)).max()


def test_the_pretension_moves_nothing_that_is_tracked() -> None:
    controller = tracking(SYSTEM, HAND)
    inputs = dict.fromkeys(controller.u, 0.0)
    inputs |= {"shoulder.q": -0.3, "elbow.q": 1.2, "shoulder.dq": 0.01, "elbow.dq": -0.02, "r.hand.x": 1.1}
    at = np.array([-0.3, 1.2])
    inputs |= {f"r.{name}": float(value) for name, value in ARM.laws.places(at).items() if name in HAND}
    inputs |= {f"{m}.L_S": 1.02 * ARM.scales.numbers[f"{m}.L_slack"] for m in SYSTEM.muscles}
    outputs = ca.Function("u", [controller.u.vector(), controller.p.vector()], [controller.y.vector()])

    def asked(pretension: float) -> Array:
        numbers = {n: ARM.scales.numbers.get(p.shared or n, p.default) for n, p in controller.parameters.items()}
        values = {**numbers, "k_c": pretension, "u_max": 0.99}
        return np.array(outputs(list(inputs.values()), list(values.values()))).ravel()

    some, more, none = asked(0.02), asked(0.04), asked(0.0)
    # N v is in the null space of G:  G (u − u₀) = 0, where Ḟ = Φ′_S u and ÿ = J M⁻¹ R F
    forces = [SYSTEM.curves[m].Phi_S_prime for m in SYSTEM.muscles]
    slopes = np.array(
        [
            float(ca.evalf(of(ca.SX(inputs[f"{m}.L_S"]), _numbers(m))))
            for m, of in zip(SYSTEM.muscles, forces, strict=True)
        ]
    )
    torques = ARM.laws.moment_arms(at).T @ (slopes * (some - none))
    assert np.abs(some - none).max() > 1e-4
    np.testing.assert_allclose(torques, 0, atol=1e-6 * np.abs(slopes * (some - none)).max())
    np.testing.assert_allclose(more - none, 2 * (some - none), rtol=1e-6, atol=1e-9)


def _numbers(muscle: str) -> Symbols:
    known = ARM.scales.numbers
    return Symbols({n.partition(".")[2]: ca.SX(v) for n, v in known.items() if n.startswith(f"{muscle}.")})


def test_the_hand_draws_an_eight_with_muscles_that_only_pull() -> None:
    """On true states: after the first round within 5 mm, activations in [0, 1], forces above 0."""
    truth = mechanism_loop(SYSTEM, "requested", HAND, ARM.scales.rate)
    table, p, h = functions(truth, (), ()), numbers(truth, EIGHT), 2.5e-3
    x, told = table["init"](0, p, [], []), []
    for k in range(int(1.25 * ROUND / h)):
        if k * h >= ROUND and k % 100 == 0:
            told.append(np.array(table["out"](k * h, x, p, [], [])[0]).ravel())
        x, _ = table["step"](k * h, h, x, p, [], ca.DM(0, 4))
    signals = dict(zip(truth.y, np.array(told).T, strict=True))
    places = ARM.laws.places(np.stack([signals[name] for name in SYSTEM.joint("q")], axis=-1))
    off = np.hypot(*(places[name] - signals[f"r.{name}"] for name in HAND)) * ARM.scales.length
    assert off.max() < 5e-3
    for muscle in SYSTEM.muscles:
        assert (signals[f"{muscle}.a"] > 0).all()
        assert (signals[f"{muscle}.a"] < 1).all()
        assert (signals[f"{muscle}.Phi_S"] > 0).all()


@pytest.mark.parametrize(
    ("tracked", "message"),
    [
        (("foot.x",), "'foot.x' cannot be tracked; there are shoulder, elbow, hand.x"),
        (("hand.x", "hand.y", "elbow"), "3 places cannot be tracked; at most 2, each once"),
        (("elbow", "elbow"), "2 places cannot be tracked"),
        ((), "0 places cannot be tracked"),
    ],
)
def test_what_cannot_be_tracked_is_refused(tracked: tuple[str, ...], message: str) -> None:
    with pytest.raises(BlockError, match=message):
        tracking(SYSTEM, tracked)
