"""What surrounds a command: environment, streams, signals, limits. Most of it needs a process of its own."""

from __future__ import annotations

from random import Random

from hostile.case import Layer

_ENVIRONMENT: dict[str, tuple[str | None, ...]] = {
    "LC_ALL": ("C", "POSIX", "de_DE.UTF-8", "nonsense", "C.ISO-8859-1"),
    "PYTHONUTF8": ("0", "1"),
    "PYTHONIOENCODING": ("ascii", "latin-1", "utf-8:strict"),
    "PYTHONWARNINGS": ("default", "error"),
    "PYTHONOPTIMIZE": ("2",),
    "MPLBACKEND": ("nonsense", "", "TkAgg", "svg"),
    "MPLCONFIGDIR": ("/dev/null/x",),
    "HOME": (None, "", "/nowhere", "relative"),
    "CXX": ("nonsense", "sh -c", "false", "true", "cat", "'", "/dev/null", "BOX/desk"),
    "HILLOBS_CACHE": ("relative", "/dev/null", "/proc/x", "BOX/other/letter.txt", "BOX/desk/x\x1b[31m", "BOX/cache"),
    "HILLOBS_COMPILE_TIMEOUT": ("0", "-1", "nan", "1e3", "x", "0.000001", "\x1b"),
    "COLUMNS": ("0", "1", "-5", "20", "x", "100000"),
    "LINES": ("0",),
    "NO_COLOR": ("1",),
    "FORCE_COLOR": ("1",),
    "TERM": ("dumb", "", "nonsense"),
    "TMPDIR": ("/nowhere", "BOX/other/letter.txt", ""),
    "PATH": ("", "/nowhere"),
    "TZ": ("nonsense",),
    "SOURCE_DATE_EPOCH": ("x", "0"),
    "OMP_NUM_THREADS": ("x",),
}
_OF_LIBRARIES = ("SOURCE_DATE_EPOCH",)
_SIGNALS = ("SIGINT", "SIGINT", "SIGTERM", "SIGHUP")
# calls that Python reports between the start of hillobs and the end of a short command
_CALLS = 4000


def environment(random: Random) -> Layer:
    """One or two variables."""
    return _some_of(random, list(_ENVIRONMENT))


def environment_of_programs(random: Random) -> Layer:
    """The same, but for what NumPy and matplotlib themselves answer when a program imports them."""
    return _some_of(random, [name for name in _ENVIRONMENT if name not in _OF_LIBRARIES])


def _some_of(random: Random, known: list[str]) -> Layer:
    names = random.sample(known, random.choice((1, 1, 2)))
    return {"environment": {name: random.choice(_ENVIRONMENT[name]) for name in names}, "fresh": True}


def signals(random: Random, fresh: bool) -> Layer:
    """A signal at any call, as likely among the first ten as among the last thousands; now and then a second one."""
    name, at = random.choice(_SIGNALS), int(_CALLS ** random.random())
    come = [[name, at]]
    if random.random() < 0.3:
        come.append([name, at + random.choice((0, 1, 5))])
    return {"signals": come, "fresh": fresh}


def limits(random: Random) -> Layer:
    """Little memory, few files, small files."""
    name = random.choice(("RLIMIT_AS", "RLIMIT_NOFILE", "RLIMIT_FSIZE", "RLIMIT_NPROC"))
    number = {
        "RLIMIT_AS": random.choice((0, 10**6, 10**7, 3 * 10**7, 10**8)),
        "RLIMIT_NOFILE": random.choice((3, 8, 10, 12, 20)),
        "RLIMIT_FSIZE": random.choice((0, 1000, 50_000)),
        "RLIMIT_NPROC": 1,
    }[name]
    return {"limits": {name: number}, "fresh": random.random() < 0.5}


def streams(random: Random) -> Layer:
    """An output that is full, closed, or read by nobody."""
    name = random.choice(("stdout", "stdout", "stderr"))
    return {"streams": {name: random.choice(("full", "closed", "broken"))}, "fresh": random.random() < 0.3}
