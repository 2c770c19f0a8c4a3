"""Every worker shares one cache of compiled libraries, apart from the user's."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from hillobs.model.block import Block, Parameter, Symbols, symbols
from hillobs.observers.ports import ESTIMATES

# a slow machine is no failure
settings.register_profile("here", deadline=None)
settings.load_profile("here")


@pytest.fixture(scope="session", autouse=True)
def _one_cache(tmp_path_factory: pytest.TempPathFactory) -> None:
    # with several workers the session's folder is one below the one they share
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
    os.environ.setdefault("HILLOBS_CACHE", str(Path(shared) / "cache"))


@pytest.fixture
def proportional() -> Block:
    """A user's own observer: x̂ follows the outputs, one gain; nothing of ours but the ports."""
    x, u = symbols(ESTIMATES), symbols("y1 y2 y3")
    parameters = {"gain": Parameter(20.0, "how fast it follows", "this test", above=0)}
    p = symbols(parameters)
    dx = Symbols({name: -x[name] for name in ESTIMATES})
    dx["x1_hat"] = p.gain * (u.y1 - x.x1_hat)
    dx["x3_hat"] = p.gain * (2.018 + 0.03 * (u.y2 - 0.1) - x.x3_hat)
    dx["x4_hat"] = p.gain * (2.018 + 0.03 * (u.y3 - 0.1) - x.x4_hat)
    start = Symbols(x1_hat=u.y1, x3_hat=2.018, x4_hat=2.018)
    return Block("proportional", x=x, u=u, p=p, parameters=parameters, dx=dx, x0=start, y=Symbols(x))
