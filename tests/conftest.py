"""Every worker shares one cache of compiled libraries, apart from the user's."""

import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

import targets
from forks import Forks
from hillobs.codegen.cache import BuildError
from hillobs.model.block import Block, Parameter, Symbols, symbols
from hillobs.observers.ports import ESTIMATES
from hillobs.studies.cli import main as cli
from survival import SWEEP

# a slow machine is no failure; a change is judged by the same draws each time, `make chaos` draws others
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("others", deadline=None, derandomize=False, print_blob=True)
settings.load_profile("same")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let a run choose what stands for this machine's processor, in every test that does not name a target itself."""
    parser.addoption(
        "--target", metavar="NAME", help="compile for it instead of for this processor, see toolchain.TARGETS"
    )
    parser.addoption("--division", choices=targets.DIVISIONS, help="quotients of vectors of 512 bits")


def pytest_configure(config: pytest.Config) -> None:
    """Take over the options of `pytest_addoption`; give workers one thread of BLAS, and ears under nohup too."""
    # as the command line does, for the workers: threads of small matrices that wait for a processor wait spinning
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, lambda *_: None)  # deafness is inherited, a handler is not
    try:
        targets.stand_in(config.getoption("--target"), config.getoption("--division"))
    except BuildError as error:
        raise pytest.UsageError(str(error)) from error


@pytest.fixture(scope="session", autouse=True)
def _one_cache(tmp_path_factory: pytest.TempPathFactory) -> None:
    # with several workers the session's folder is one below the one they share
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
    os.environ.setdefault("HILLOBS_CACHE", str(Path(shared) / "cache"))


@pytest.fixture
def command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Callable[..., tuple[int, str, str]]:
    """`hillobs ARGUMENTS` in an empty folder, in this process: exit code, what it prints, what it complains of."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["hillobs", *arguments])
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = int(end.code or 0)
        captured = capsys.readouterr()
        # which test is the first to compile a library is chance
        complaints = [line for line in captured.err.splitlines(keepends=True) if "hillobs: compiling " not in line]
        return code, captured.out, "".join(complaints)

    return run


@pytest.fixture(scope="session")
def forks() -> Iterator[Forks]:
    """Commands in forks of one process."""
    with Forks() as here:
        yield here


@pytest.fixture(scope="session")
def untouched(forks: Forks, tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, list[str]]:
    """The result of a sweep that nothing disturbs, and its calls in order."""
    folder = tmp_path_factory.mktemp("untouched")
    done = forks.run(folder, *SWEEP)
    assert (done.code, done.err, done.computed) == (0, "", [0, 1, 2])
    assert os.listdir(folder) == ["x.nc"]
    return (folder / "x.nc").read_bytes(), done.calls


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
