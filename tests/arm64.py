"""A 64-bit ARM processor for `make portable`: Debian's Python for it under qemu, and a cross compiler of this machine.

All of it is unpacked beside the environment that runs the tests; nothing is installed, and no rights are needed.
"""

import platform
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from places import ROOT

COMPILER, EMULATOR = "aarch64-linux-gnu-g++", "qemu-aarch64"
FOLDER = Path(sys.prefix) / "arm64"
_KEYRING = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
_NEEDED = ("apt-get", "dpkg-deb", EMULATOR, COMPILER)
_APT = """\
Dir::Etc::sourcelist "{0}/sources.list";
Dir::Etc::sourceparts "/dev/null";
Dir::State "{0}/state";
Dir::State::status "{0}/state/status";
Dir::Cache "{0}/cache";
APT::Architecture "arm64";
APT::Architectures {{ "arm64"; }};
APT::Install-Recommends "false";
Debug::NoLocking "true";
"""


def missing() -> str:
    """Why there can be none here, or an empty text."""
    if lacking := [name for name in _NEEDED if shutil.which(name) is None]:
        return f"{', '.join(lacking)} not installed: apt install qemu-user g++-aarch64-linux-gnu"
    return "" if _KEYRING.exists() else f"no {_KEYRING}: its packages are Debian's"


def python() -> list[str]:
    """Its Python, with all that the tests need, and this working copy; unpacked when it is first asked for."""
    command = [EMULATOR, "-L", str(FOLDER / "root"), str(FOLDER / "venv" / "bin" / "python")]
    ready = FOLDER / "ready"
    if not ready.exists():
        shutil.rmtree(FOLDER, ignore_errors=True)
        interpreter = _debian(FOLDER)
        _packages(FOLDER / "venv", interpreter)
        ready.touch()
    return command


def _debian(folder: Path) -> Path:
    """Debian's Python and the libraries it needs; the path of the program."""
    root, cached = folder / "root", folder / "cache" / "archives"
    for made in (root, cached / "partial", folder / "state" / "lists" / "partial"):
        made.mkdir(parents=True)
    (folder / "state" / "status").touch()
    suite = platform.freedesktop_os_release()["VERSION_CODENAME"]
    (folder / "sources.list").write_text(f"deb [signed-by={_KEYRING}] http://deb.debian.org/debian {suite} main\n")
    (folder / "apt.conf").write_text(_APT.format(folder))
    for words in (["update"], ["install", "--download-only", "--yes", "python3", "libpython3-stdlib", "libstdc++6"]):
        _run("env", f"APT_CONFIG={folder / 'apt.conf'}", "apt-get", "-qq", *words)
    for package in sorted(cached.glob("*.deb")):
        _run("dpkg-deb", "--extract", str(package), str(root))
    return (root / "usr" / "bin" / "python3").resolve()


def _packages(venv: Path, interpreter: Path) -> None:
    """A virtual environment by hand: wheels for ARM, and the finder of this working copy's editable install."""
    version = interpreter.name.removeprefix("python")
    site = venv / "lib" / interpreter.name / "site-packages"
    site.mkdir(parents=True)
    (venv / "bin").mkdir()
    (venv / "bin" / "python").symlink_to(interpreter)
    (venv / "pyvenv.cfg").write_text(f"home = {interpreter.parent}\ninclude-system-site-packages = false\n")
    pip = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")
    _run(*pip, "wheel", "--no-deps", "--wheel-dir", str(venv), str(ROOT))
    (wheel,) = venv.glob("*.whl")
    kinds = [word for kind in ("manylinux_2_28", "manylinux2014") for word in ("--platform", f"{kind}_aarch64")]
    target = ("--target", str(site), *kinds, "--python-version", version, "--only-binary", ":all:")
    _run(*pip, "install", *target, f"hillobs[dev] @ {wheel.as_uri()}")
    shutil.rmtree(site / "hillobs")
    for finder in Path(sysconfig.get_path("purelib")).glob("__editable__*hillobs*"):
        shutil.copy(finder, site)


def _run(*command: str) -> None:
    subprocess.run(command, check=True)
