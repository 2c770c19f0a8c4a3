"""An observer as FMUs, which simulation programs load: Co-Simulation of FMI 2.0 and of FMI 3.0.

An FMU is a zip of a description and a library for each kind of machine: the C99 of the observer with a shell around it.
"""

from __future__ import annotations

import hashlib
import io
import uuid
import zipfile
from collections.abc import Iterator, Mapping
from importlib import resources
from string import Template

from ..toolchain import build_c
from .c99 import c_files
from .manifest import Manifest
from .model_description import model_description
from .platforms import platforms
from .universal import universal

VERSIONS = ("2.0", "3.0")

_TEMPLATES = resources.files("hillobs.codegen.targets.templates")
# the first moment that a zip can name: the same export is the same file
_MOMENT = (1980, 1, 1, 0, 0, 0)
# a zip of Unix, whose files all may read and run
_UNIX, _RIGHTS = 3, 0o100755 << 16


def fmus(manifest: Manifest) -> dict[str, bytes]:
    """File name → content of an FMU for each version.

    With libraries for this machine and, where the extra `compiler` is there, for the others. BlockError for what cannot
    be expressed, BuildError if there is no compiler.
    """
    written = c_files(manifest)
    pair = {name: written[name] for name in (f"{manifest.name}.h", f"{manifest.name}.c")}
    return {f"{manifest.name}-fmi{version[0]}.fmu": _packed(manifest, version, pair) for version in VERSIONS}


def shell(manifest: Manifest, version: str, token: str) -> dict[str, str]:
    """Name → text of the C around what `c_files` writes; token: what the model description knows the library by."""
    words = {
        "name": manifest.name,
        "prefix": manifest.prefix,
        "PREFIX": manifest.prefix.upper(),
        "n_params": str(len(manifest.params)),
        "n_estimate": str(len(manifest.estimate)),
        "n_input": str(len(manifest.input)),
        "at_end": "" if manifest.input else " and at it",
        # inputs at the end of a step are known when the next one begins; what has none need not wait
        "sign": "-" if manifest.input else "+",
        "token": token,
    }
    main = f"fmi{version[0]}"
    # no Block has a hyphen in its name
    return {
        "fmi-instance.h": _filled("fmi_instance.h", words),
        "fmi-shell.c": _filled(f"{main}.c", words),
        "fmi-absent.c": _filled("fmi_absent.c", {**words, "functions": "\n".join(_absent(f"{main}_absent.txt"))}),
    }


def _absent(names: str) -> Iterator[str]:
    """A line for each function in a list of them, of which each line begins with the kind."""
    for line in (_TEMPLATES / names).read_text(encoding="utf-8").splitlines():
        kind, *functions = line.split()
        yield from (f"{kind.upper()}({function})" for function in functions)


def _filled(template: str, words: Mapping[str, str]) -> str:
    return Template((_TEMPLATES / template).read_text(encoding="utf-8")).substitute(words)


def _packed(manifest: Manifest, version: str, pair: Mapping[str, str]) -> bytes:
    """The zip; pair: the C that the shell is for."""
    token = _token("".join(pair.values()).encode() + model_description(manifest, version, ""))
    sources = {**pair, **shell(manifest, version, token)}
    files = {"modelDescription.xml": model_description(manifest, version, token)}
    libraries: dict[str, list[bytes]] = {}
    for platform in platforms():
        library = f"{manifest.prefix}{platform.suffix}"
        title = f"{manifest.prefix} (FMI {version}, {platform.name})"
        same = libraries.setdefault(f"binaries/{platform.folders[version]}/{library}", [])
        same.append(build_c(sources, title, platform.target).read_bytes())
    files |= {path: universal(same) if len(same) > 1 else same[0] for path, same in libraries.items()}
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _MOMENT)
            entry.compress_type, entry.create_system, entry.external_attr = zipfile.ZIP_DEFLATED, _UNIX, _RIGHTS
            archive.writestr(entry, content)
    return packed.getvalue()


def _token(content: bytes) -> str:
    """Which description and which library belong together."""
    return f"{{{uuid.UUID(bytes=hashlib.sha256(content).digest()[:16])}}}"
