"""Libraries of an FMU for other machines, by the compiler of the extra `compiler`."""

import zipfile
from pathlib import Path

import pytest
from fmpy.validation import validate_fmu

from exported_fmus import saved_fmus
from exported_programs import needs_cc

pytestmark = [pytest.mark.chaos, needs_cc]
# file → how it begins: ELF of x86-64 and of arm64, DOS, Mach-O for several processors, or for one of 64 bits
ELF, DLL, MACHO, FAT = b"\x7fELF", b"MZ", bytes.fromhex("cffaedfe"), bytes.fromhex("cafebabe")
LIBRARIES = {
    "fmi2": {
        "linux64/hillobs_high_gain.so": ELF,
        "aarch64-linux/hillobs_high_gain.so": ELF,
        "win64/hillobs_high_gain.dll": DLL,
        "darwin64/hillobs_high_gain.dylib": FAT,
    },
    "fmi3": {
        "x86_64-linux/hillobs_high_gain.so": ELF,
        "aarch64-linux/hillobs_high_gain.so": ELF,
        "x86_64-windows/hillobs_high_gain.dll": DLL,
        "x86_64-darwin/hillobs_high_gain.dylib": MACHO,
        "aarch64-darwin/hillobs_high_gain.dylib": MACHO,
    },
}


def test_with_the_extra_there_is_one_for_each_kind_of_machine(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="the extra `compiler` is not installed")
    saved_fmus(tmp_path, "high_gain")
    for version, libraries in LIBRARIES.items():
        path = tmp_path / f"high_gain-{version}.fmu"
        assert validate_fmu(str(path)) == []
        with zipfile.ZipFile(path) as archive:
            names = {name.removeprefix("binaries/") for name in archive.namelist()} - {"modelDescription.xml"}
            assert names == libraries.keys()
            for name, beginning in libraries.items():
                content = archive.read(f"binaries/{name}")
                assert content.startswith(beginning), name
                # what programs look for is exported by name
                assert f"{version}DoStep".encode() in content, name
                # and nothing of this machine is told
                assert str(tmp_path).encode() not in content
