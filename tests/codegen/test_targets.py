"""What libraries are compiled for: each target has its flags, and one that cannot run here is refused."""

from pathlib import Path

import pytest

from hillobs.codegen import toolchain
from hillobs.codegen.cache import BuildError
from hillobs.codegen.system import processor
from hillobs.codegen.toolchain import NATIVE, PORTABLE, SINGLE, TARGETS, Compiler, target_flags

GCC, ZIG = (Compiler(("c++",), kind, "", Path()) for kind in ("gcc", "zig"))
# as /proc/cpuinfo has it, shortened; the first processor counts
SKYLAKE = (
    "processor\t: 0\nvendor_id\t: GenuineIntel\nflags\t\t: {}\n\nprocessor\t: 1\nvendor_id\t: other\nflags\t: fpu\n"
)
V2 = "fpu cx16 lahf_lm popcnt pni sse4_1 sse4_2 ssse3"
V3 = f"{V2} abm avx avx2 bmi1 bmi2 f16c fma movbe xsave"


@pytest.fixture
def cpuinfo(monkeypatch):
    """Let the system tell something else of its processor."""

    def tell(text):
        monkeypatch.setattr(Path, "read_text", lambda self, *rest: text)
        monkeypatch.setattr(toolchain, "_MACHINE", "x86-64")

    return tell


def test_the_first_processor_speaks_for_all(cpuinfo):
    cpuinfo(SKYLAKE.format("b a b"))
    assert processor.features() == ["a", "b"]
    assert processor.cpuinfo("no such entry", "vendor_id") == "GenuineIntel"
    assert processor.cpuinfo("no such entry") == ""
    assert processor.divides_slowly()


@pytest.mark.parametrize(
    ("known", "level", "missing"),
    [
        (V3, "x86-64-v3", ""),
        (V3, "x86-64-v4", "avx512bw, avx512cd, avx512dq, avx512f, avx512vl"),
        (V2, "x86-64-v2", ""),
        (V3.replace(" fma", "").replace(" pni", ""), "x86-64-v3", "pni, fma"),
    ],
)
def test_a_target_that_this_processor_cannot_execute_is_refused(cpuinfo, known, level, missing):
    cpuinfo(SKYLAKE.format(known))
    if not missing:
        assert f"-march={level}" in target_flags(level, GCC)
        return
    with pytest.raises(BuildError, match=f"^The target {level} needs {missing}, which this processor does not have"):
        target_flags(level, GCC)


def test_where_the_system_does_not_tell_no_target_is_refused(cpuinfo):
    cpuinfo("")
    assert target_flags("x86-64-v4", GCC)[0] == "-march=x86-64-v4"


def test_a_target_of_another_machine_is_refused(cpuinfo):
    cpuinfo("")
    with pytest.raises(BuildError, match="The target arm64 is for arm64; this machine is x86-64"):
        target_flags("arm64", GCC)
    with pytest.raises(BuildError, match=r"Unknown target 'fast'; there are native, .*scalar"):
        target_flags("fast", GCC)


def test_flags_that_only_x86_knows_are_given_to_no_other_machine(monkeypatch):
    monkeypatch.setattr(toolchain, "_MACHINE", "s390x")
    assert target_flags(SINGLE, GCC) == TARGETS[SINGLE]


def test_newtons_division_is_for_this_processor_alone(cpuinfo):
    """Two machines of a class must compute the same bits, whoever made their dividers."""
    cpuinfo(SKYLAKE.format(V3))
    slow = "-DHILLOBS_SLOW_DIVISION"
    assert slow in target_flags(NATIVE, GCC)
    assert not [
        name for name in TARGETS if name not in (NATIVE, "x86-64-v4", "arm64") and slow in target_flags(name, GCC)
    ]
    cpuinfo(SKYLAKE.replace("GenuineIntel", "AuthenticAMD").format(V3))
    assert slow not in target_flags(NATIVE, GCC)


def test_zig_is_told_every_processor_in_its_own_words(cpuinfo):
    """It would compile for this one where none is named, and knows no hyphens."""
    cpuinfo(SKYLAKE.format(V3))
    assert target_flags("x86-64-v3", ZIG)[0] == "-march=x86_64_v3"
    assert "-mcpu=baseline" in target_flags("scalar", ZIG)
    assert "-mcpu=baseline" not in target_flags(SINGLE, ZIG)


def test_the_target_of_clusters_is_one_of_them():
    assert PORTABLE in TARGETS
