"""Whatever stops a process leaves nothing partial under a final name; audit hooks inject the faults."""

import stat
from pathlib import Path

import pytest

from entries import assert_whole, child, flip, names

FAULT = """
    import atexit, errno, tempfile, traceback
    counted = ("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.chmod", "fcntl.flock", "os.listdir",
               "tempfile.mkdtemp", "shutil.rmtree")

    def fault(kind):
        if kind == "KILL":
            os.kill(os.getpid(), 9)
        if kind == "INTERRUPT":
            raise KeyboardInterrupt
        code = getattr(errno, kind)
        raise OSError(code, os.strerror(code))

    def forked(kind="", when=0):
        armed = [kind] * bool(kind)
        if child := os.fork():
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        seen = 0

        def hook(event, arguments):
            nonlocal seen
            if armed and event in counted:
                seen += 1
                if seen == when:
                    fault(kind)

        sys.addaudithook(hook)
        try:
            code = run(armed)
        except KeyboardInterrupt:
            code = 130
        except BaseException:
            traceback.print_exc()
            code = 8
        armed.clear()
        reached = seen >= when
        atexit._run_exitfuncs()
        sys.stdout.flush()
        os._exit(code if reached else 77)

    def run(armed):
        with warnings.catch_warnings(record=True):
            warnings.simplefilter("always")
            try:
                path = cache.obtain(cache.Order(KEY, {"names": ["x"]}, b"// x"), make, 30)
            except cache.BuildError as error:
                return 1
        armed.clear()
        with open(path, "rb") as file:
            return 0 if file.read() == content else 9

    kind, start, root = sys.argv[1:]
    for when in range(1, 200):
        folder, temporary = Path(root, str(when), "cache"), Path(root, str(when), "temporary")
        folder.mkdir(mode=0o700, parents=True)
        temporary.mkdir()
        os.environ["HILLOBS_CACHE"], tempfile.tempdir = str(folder), str(temporary)
        if start != "cold":
            forked()
            os.truncate(next(folder.glob("*.so")), 10)
        if start == "abandoned":
            (folder / f"{KEY}-left.tmp").mkdir()
            (folder / f"{KEY}-left.tmp" / "half.so").write_bytes(b"half")
        hit = forked(kind, when)
        print(hit, end=" ", flush=True)
        if hit == 77:
            break
        again = forked()
        if again != 0:
            print("then", again, end=" ")
"""


@pytest.mark.parametrize("start", ["cold", "damaged", "abandoned"])
@pytest.mark.parametrize("kind", ["KILL", "ENOSPC", "EIO", "EACCES", "INTERRUPT"])
def test_a_fault_at_each_call(tmp_path, record_property, kind, start):
    result = child(FAULT, tmp_path, kind, start, tmp_path)
    assert result.stderr == ""
    *codes, untouched = result.stdout.split()
    assert untouched == "77"
    record_property("faults", len(codes))
    assert len(codes) >= 20
    assert set(codes) <= {"KILL": {"-9"}, "INTERRUPT": {"0", "130"}}.get(kind, {"0", "1"})
    for when in range(1, len(codes) + 1):
        folder = tmp_path / str(when) / "cache"
        assert_whole(folder)
        assert {Path(name).suffix for name in names(folder)} == {".json", ".so", ".cpp", ".lock"}
        assert len(names(folder)) == 4
        assert kind == "KILL" or names(tmp_path / str(when) / "temporary") == []


READ_ONLY = """
    def hook(event, arguments):
        path = os.fspath(arguments[0]) if arguments and isinstance(arguments[0], (str, os.PathLike)) else ""
        writes = event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        if path.startswith(os.environ["HILLOBS_CACHE"]) and (writes or event in ("os.mkdir", "os.rename", "os.remove")):
            raise OSError(30, os.strerror(30))

    sys.addaudithook(hook)
    code = run()
    sys.exit(code or run())
"""


def test_a_read_only_cache_is_read(tmp_path):
    child("run()", tmp_path / "cache")
    result = child(READ_ONLY, tmp_path / "cache")
    assert result.returncode == 0
    assert "warnings: 0" in result.stdout
    assert f"path: {tmp_path / 'cache'}" in result.stdout


def test_a_read_only_cache_without_the_entry_is_left_alone(tmp_path):
    (tmp_path / "cache").mkdir(mode=0o700)
    (tmp_path / "temporary").mkdir()
    result = child(READ_ONLY, tmp_path / "cache", env={"TMPDIR": str(tmp_path / "temporary")})
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.count("Read-only file system") == 1  # one warning for two runs
    assert f"path: {tmp_path / 'temporary'}" in result.stdout
    assert names(tmp_path / "cache") == names(tmp_path / "temporary") == []


def test_no_temporary_folder_either_is_a_sentence(tmp_path):
    (tmp_path / "cache").write_text("a file")
    program = "import tempfile; tempfile.tempdir = '/nowhere'; sys.exit(run())"
    result = child(program, tmp_path / "cache")
    assert result.returncode == 1
    assert "no temporary folder can be made" in result.stdout


def test_a_private_folder_left_by_a_killed_process_is_swept(tmp_path):
    (tmp_path / "cache").write_text("a file")
    (tmp_path / "temporary").mkdir()
    for kill in (True, True, False):
        program = f"run()\nimport os\nif {kill}: os.kill(os.getpid(), 9)"
        child(program, tmp_path / "cache", env={"TMPDIR": str(tmp_path / "temporary")})
        assert len(names(tmp_path / "temporary")) == kill


def test_a_forked_child_does_not_remove_the_folder_of_its_parent(tmp_path):
    (tmp_path / "cache").write_text("a file")
    program = """
        run()
        if os.fork() == 0:
            sys.exit(0)
        os.wait()
        sys.exit(0 if cache.cache_folder().is_dir() else 5)
    """
    assert child(program, tmp_path / "cache").returncode == 0


@pytest.mark.parametrize("umask", [0o000, 0o077, 0o777], ids="{:03o}".format)
def test_the_umask_does_not_matter(tmp_path, umask):
    folder = tmp_path / "parent" / "cache"
    result = child(f"os.umask({umask}); sys.exit(run() or run())", folder)
    assert result.returncode == 0, result.stdout + result.stderr
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(path.stat().st_mode) for path in folder.iterdir()} == {0o600}
    assert child("sys.exit(run())", folder).returncode == 0


@pytest.mark.parametrize("switches", [["-O"], ["-OO"], ["-X", "dev"], ["-W", "error"], ["-I"]], ids=" ".join)
def test_switches_of_python_do_not_matter(tmp_path, switches):
    folder = tmp_path / "cache"
    assert child("sys.exit(run())", folder, switches=switches).returncode == 0
    flip(next(folder.glob("*.so")), 1000)
    result = child("sys.exit(run())", folder, switches=switches)
    assert result.returncode == 0, result.stderr
    assert "warnings: 1" in result.stdout


def test_without_home_and_user_nothing_is_written_to_the_current_folder(tmp_path):
    program = """
        cache.__file__ = "/site/codegen/cache.py"
        for name in ("HOME", "XDG_CACHE_HOME", "HILLOBS_CACHE"):
            os.environ.pop(name, None)
        import pwd
        def unknown(user): raise KeyError(user)
        pwd.getpwuid = unknown
        sys.exit(run())
    """
    result = child(program, "/unused", cwd=tmp_path)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "warnings: 1" in result.stdout
    assert names(tmp_path) == []
