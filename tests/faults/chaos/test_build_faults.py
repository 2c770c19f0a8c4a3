"""Real faults in every system call of a build, until the build succeeds untouched; run by `make chaos`, minutes long.

After each fault: a right result or one sentence, nothing partial under a final name, and the next start repairs all.
"""

import hashlib
import itertools
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

from hillobs.codegen.toolchain import find_compiler

pytestmark = pytest.mark.chaos

PROGRAM = """
import ctypes, os, sys, warnings
from hillobs.codegen import cache, toolchain

compiled, compile_library = [], toolchain.compile_library

def counting(*arguments):
    compiled.append(1)
    return compile_library(*arguments)

toolchain.compile_library = counting
EXPORT = 'extern "C" __attribute__((visibility("default")))'
SOURCE = (
    "#include <stdint.h>\\n"
    + EXPORT + " int hillobs_abi(void) { return HILLOBS_ABI; }\\n"
    + EXPORT + " double twice(double x) { return 2.0 * x + 0.0 * __builtin_exp(x); }\\n"
)
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    try:
        path = toolchain.build(SOURCE, {"names": ["x"]})
        try:
            function = ctypes.CDLL(str(path)).twice
        except OSError as error:
            if "failed to map segment" not in str(error):
                raise cache.BuildError(f"{path} cannot be loaded: {error}") from error
            from hillobs.codegen.shared_library import open_library  # here: it brings CasADi, hundreds of calls
            function = open_library(path).twice
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
        code, text = (0 if function(4.0) == 8.0 else 9), f"{len(compiled)} {len(said)} {path}"
    except cache.BuildError as error:
        code, text = 1, f"sentence: {error}"
    try:
        os.write(1, text.encode("utf-8", "replace"))
    except OSError:
        pass
sys.exit(code)
"""
WRAPPER = """#!/bin/sh
case "$*" in *--version*) exec {real} "$@";; esac
exec $FAULT {real} "$@"
"""


class Place:
    """An empty cache with home, temporary and current folders of its own, and a compiler that FAULT can disturb."""

    def __init__(self, root, compiler):
        self.root, self.cache = root, root / "cache"
        self.others = [root / name for name in ("home", "temporary", "current")]
        for folder in self.others:
            folder.mkdir(parents=True)
        self.program = root / "program.py"
        self.program.write_text(PROGRAM)
        self.log = root / "strace.log"
        own = {"HILLOBS_CACHE": self.cache, "HOME": self.others[0], "TMPDIR": self.others[1], "CXX": compiler}
        self.env = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **{name: str(value) for name, value in own.items()}}
        self.env.pop("XDG_CACHE_HOME", None)

    def start(self, *prefix, **env):
        command = [*map(str, prefix), sys.executable, str(self.program)]
        pipe = subprocess.PIPE
        return subprocess.Popen(command, env=self.env | env, cwd=self.others[2], stdout=pipe, stderr=pipe, text=True)

    def run(self, *prefix, **env):
        """Return exit code and output; whatever the compiler left running has ended by then."""
        process = self.start(*prefix, **env)
        out, err = process.communicate(timeout=300)
        self.wait_for_orphans()
        return process.returncode, out, err

    def wait_for_orphans(self):
        while any(self.is_below(path) for path in Path("/proc").glob("[0-9]*/cwd")):
            time.sleep(0.01)

    def is_below(self, link):
        try:
            return os.readlink(link).startswith(str(self.cache))
        except OSError:
            return False

    def assert_whole(self):
        for path in self.cache.glob("*.json"):
            said = json.loads(path.read_bytes())
            assert hashlib.sha256((self.cache / said["library"]).read_bytes()).hexdigest() == said["sha256"]

    def assert_outcome(self, result, killed=False):
        code, out, err = result
        assert code in ({0, 1, -signal.SIGKILL} if killed else {0, 1}), (code, out, err)
        assert "Traceback" not in err, err
        assert code != 1 or out.startswith("sentence: ") or out == ""
        self.assert_whole()

    def assert_recovers(self, killed=False):
        result = self.run()
        assert result[0] == 0, result
        assert result[2] == ""
        self.assert_whole()
        assert sorted(path.suffix for path in self.cache.iterdir()) == [".cpp", ".json", ".lock", ".so"]
        left = [path for folder in self.others for path in folder.iterdir()]
        assert all(killed and path.name.startswith("hillobs-") for path in left), left

    def damage(self):
        assert self.run()[0] == 0
        os.truncate(next(self.cache.glob("*.so")), 5000)


@pytest.fixture(scope="module")
def compiler(tmp_path_factory):
    path = tmp_path_factory.mktemp("compiler") / "c++"
    path.write_text(WRAPPER.format(real=find_compiler().path))
    path.chmod(0o755)
    return path


@pytest.fixture
def place(tmp_path, compiler):
    def make(name="place"):
        return Place(tmp_path / str(name), compiler)

    return make


@pytest.fixture(scope="module")
def strace():
    """The path of strace, if it may be used here."""
    path = shutil.which("strace")
    if path is None:
        pytest.skip("strace is not installed")
    probe = subprocess.run([path, "-o", "/dev/null", "-e", "inject=getppid:error=EIO", "true"], capture_output=True)
    if probe.returncode:
        pytest.skip(f"strace cannot trace here: {probe.stderr.decode().strip()}")
    return path


def injection(strace, log, call, action, when):
    effect = "signal=KILL" if action == "KILL" else f"error={action}"
    return [strace, "-qq", "-o", str(log), "-e", f"trace={call}", "-e", f"inject={call}:{effect}:when={when}"]


def was_hit(place, result):
    log = place.log.read_text(errors="replace") if place.log.exists() else ""
    return "INJECTED" in log or "killed by SIGKILL" in log or result[0] == -signal.SIGKILL


def first_call(place, strace, call):
    """The number of the first call that has to do with the cache; those before it start Python."""
    assert place.run(strace, "-qq", "-o", place.log, "-e", f"trace={call}")[0] == 0
    lines = place.log.read_text(errors="replace").splitlines()
    return next((number for number, line in enumerate(lines, 1) if str(place.cache) in line), 1)


CALLS = [
    "openat",
    "write",
    "fsync",
    "flock",
    "fchmod",
    "chmod",
    "mkdir",
    "rename",
    "unlinkat",
    "rmdir",
    "pipe2",
    "vfork",
]
ACTIONS = ["KILL", "ENOSPC", "EIO", "EACCES"]
SITES = (
    100  # of a compiler's calls, at most, spread evenly: it has hundreds that are alike (the assembler's lseek, 862)
)


@pytest.mark.parametrize(("start", "action"), [("cold", action) for action in ACTIONS] + [("damaged", "KILL")])
@pytest.mark.parametrize("call", CALLS)
def test_each_call_of_ours(place, strace, record_property, call, action, start):
    first = first_call(place("first"), strace, call)
    for when in itertools.count(first):
        here = place(when)
        if start == "damaged":
            here.damage()
        result = here.run(*injection(strace, here.log, call, action, when))
        if not was_hit(here, result):
            break
        if start == "cold" or result[0] == 0:
            here.assert_outcome(result, action == "KILL")
        here.assert_recovers(action == "KILL")
    assert result[0] == 0
    record_property("faults", when - first)


@pytest.mark.parametrize("action", ["ENOSPC", "EIO", "EACCES"])
@pytest.mark.parametrize("call", ["openat", "write", "fsync", "mkdir", "rename", "flock"])
def test_from_each_call_of_ours_on(place, strace, record_property, call, action):
    first = first_call(place("first"), strace, call)
    for when in itertools.count(first):
        here = place(when)
        result = here.run(*injection(strace, here.log, call, action, f"{when}+"))
        if not was_hit(here, result):
            break
        here.assert_outcome(result)
        here.assert_recovers(killed=True)
    record_property("faults", when - first)


@pytest.mark.parametrize("action", ["KILL", "ENOSPC", "EIO"])
@pytest.mark.parametrize("call", ["write", "openat", "execve", "read", "unlink", "chmod", "lseek", "mmap", "vfork"])
def test_each_call_of_the_compiler(place, strace, record_property, call, action):
    traced = place("first")
    assert traced.run(FAULT=f"{strace} -f -qq -o {traced.log} -e trace={call}")[0] == 0
    lines = traced.log.read_text(errors="replace").splitlines()
    calls = max(Counter(line.split()[0] for line in lines if f" {call}(" in line).values())  # of one process
    hit, sites = 0, range(1, calls + 1, -(-calls // SITES))
    for when in sites:
        here = place(when)
        fault = [*injection(strace, here.log, call, action, when), "-f"]
        result = here.run(FAULT=" ".join(fault))
        hit += was_hit(here, result)
        here.assert_outcome(result)
        here.assert_recovers()
    assert hit >= len(sites) - 1  # memory layout may save a compiler its last mmap
    record_property("faults", hit)


@pytest.mark.parametrize("seed", range(4))
def test_kills_at_random_times(place, record_property, seed):
    draw = random.Random(seed)
    here, killed = place(), 0
    for _ in range(40):
        shutil.rmtree(here.cache, ignore_errors=True)
        process = here.start()
        time.sleep(draw.uniform(0.02, 0.4))
        process.kill()
        out, err = process.communicate()
        killed += process.returncode == -signal.SIGKILL
        here.wait_for_orphans()
        here.assert_outcome((process.returncode, out, err), killed=True)
        here.assert_recovers(killed=True)
    record_property("faults", killed)


@pytest.mark.parametrize("round_", range(5))
def test_32_processes_start_cold_at_once(place, record_property, round_):
    here = place()
    processes = [here.start() for _ in range(32)]
    results = [process.communicate(timeout=300) for process in processes]
    assert [process.returncode for process in processes] == [0] * 32
    assert {err for _, err in results} == {""}
    assert sum(int(out.split()[0]) for out, _ in results) == 1
    assert {out.split(maxsplit=2)[2] for out, _ in results} == {str(next(here.cache.glob("*.so")))}
    here.assert_recovers()
    record_property("faults", 32)


def test_processes_killed_while_others_wait(place, record_property):
    """Whoever holds the lock is killed; one of those who wait takes over."""
    here, draw = place(), random.Random(1)
    for _ in range(5):
        shutil.rmtree(here.cache, ignore_errors=True)
        processes = [here.start() for _ in range(12)]
        for process in draw.sample(processes, 6):
            time.sleep(draw.uniform(0, 0.1))
            process.kill()
        for process in processes:
            out, err = process.communicate(timeout=300)
            here.assert_outcome((process.returncode, out, err), killed=True)
            assert process.returncode in (0, -signal.SIGKILL)
        here.wait_for_orphans()
        here.assert_recovers(killed=True)
    record_property("faults", 30)


@pytest.mark.parametrize("limit", [0, 1, 100, 300, 1000, 3000, 5000, 10_000, 14_000, 16_000])
def test_files_that_may_not_grow(place, record_property, limit):
    here = place()
    result = here.run("sh", "-c", f'exec prlimit --fsize={limit} "$@"', "sh") if shutil.which("prlimit") else None
    if result is None:
        pytest.skip("prlimit is not installed")
    here.assert_outcome(result)
    here.assert_recovers()
    record_property("faults", 1)


@pytest.fixture(scope="module")
def namespace():
    """A command that may mount, if that is allowed here."""
    command = ["unshare", "-rm", "sh", "-c"]
    if shutil.which("unshare") is None:
        pytest.skip("unshare is not installed")
    probe = subprocess.run([*command, "mount -t tmpfs none /mnt"], capture_output=True)
    if probe.returncode:
        pytest.skip(f"no file system can be mounted here: {probe.stderr.decode().strip()}")
    return command


def mounted(namespace, here, options, script):
    """Run a script with a small file system on the cache; `run NAME` stores what the program says and its exit code."""
    here.cache.mkdir(mode=0o700)
    head = f"""
        mount -t tmpfs -o mode=700,{options} none {here.cache}
        cd {here.root}
        run() {{ {sys.executable} program.py > $1 2> $1.err; echo $? > $1.code; }}
    """
    subprocess.run([*namespace, head + script], env=here.env, check=True, timeout=300)
    return [
        (int(path.read_text()), path.with_suffix("").read_text(), path.with_suffix(".err").read_text())
        for path in sorted(here.root.glob("*.code"))
    ]


@pytest.mark.parametrize("size", [4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 56, 64])
def test_a_full_disk(place, namespace, record_property, size):
    here = place()
    script = f"run 1; mount -o remount,size=4m {here.cache}; run 2; run 3; ls {here.cache} > left"
    full, roomy, warm = mounted(namespace, here, f"size={size}k", script)
    here.assert_outcome(full)
    assert full[0] == 0 or "No space left" in full[1] or "exit code" in full[1] or "SIG" in full[1], full
    assert roomy[0] == 0
    assert warm[:2] == (0, f"0 0 {warm[1].split(maxsplit=2)[2]}")
    left = (here.root / "left").read_text().split()
    assert sorted(Path(name).suffix for name in left) == [".cpp", ".json", ".lock", ".so"]
    record_property("faults", 1)


def test_no_inodes_left(place, namespace, record_property):
    for count in range(2, 12):
        here = place(count)
        script = f"run 1; mount -o remount,nr_inodes=100 {here.cache}; run 2"
        few, many = mounted(namespace, here, f"nr_inodes={count}", script)
        here.assert_outcome(few)
        assert many[0] == 0
    record_property("faults", 10)


def test_a_folder_mounted_noexec(place, namespace, record_property):
    (result,) = mounted(namespace, place(), "noexec", "run 1")
    assert result[0] == 1
    assert "is mounted noexec; name another folder in HILLOBS_CACHE" in result[1]
    record_property("faults", 1)


def test_a_folder_mounted_read_only(place, namespace, record_property):
    here = place()
    remount = f"mount -o remount,ro {here.cache}"
    script = f"{remount}; run 1; mount -o remount,rw {here.cache}; run 0; rm 0*; {remount}; run 2"
    cold, warm = mounted(namespace, here, "size=4m", script)
    assert cold[0] == 0
    assert re.match(rf"1 1 {here.others[1]}/hillobs-", cold[1])
    assert warm[1].startswith(f"0 0 {here.cache}")
    assert list(here.others[1].iterdir()) == []
    record_property("faults", 2)
