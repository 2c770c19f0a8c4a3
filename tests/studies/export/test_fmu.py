"""FMUs: what a simulation program makes of them is what the exported C makes, bit for bit."""

import re
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from exported_fmus import VERSIONS, program_like, samples, saved_fmus, this_machine_only
from exported_programs import CC, PERIOD, STRICT, estimates, needs_cc, recorded
from hillobs.codegen.targets import fmu
from hillobs.codegen.targets.c99 import c_files
from hillobs.codegen.targets.manifest import Manifest
from hillobs.codegen.targets.model_description import model_description
from hillobs.codegen.targets.universal import universal
from hillobs.observers import OBSERVERS
from hillobs.studies.export.prepare import exported
from places import RECORDINGS

pytestmark = [needs_cc, pytest.mark.usefixtures("this_machine_only")]
__all__ = ["this_machine_only"]


def same_as_c(folder: Path, observer: str, samples: np.ndarray) -> None:
    """Programs of both versions are content with the FMUs, and estimate to the last bit what the exported C does."""
    expected = estimates(program_like(folder, observer), "y1,y2,y3", samples)
    time = np.arange(len(samples)) * PERIOD
    signals = np.rec.fromarrays([time, *samples.T], names="time,y1,y2,y3")
    for version in VERSIONS:
        path = str(folder / f"{observer}-{version}.fmu")
        assert validate_fmu(path) == []
        told = fmpy.simulate_fmu(path, stop_time=time[-1], output_interval=PERIOD, input=signals)
        assert len(told) == len(samples)
        assert len(told.dtype.names) == 1 + len(expected)
        for name, ours in zip(told.dtype.names[1:], expected.values(), strict=True):
            # a step's sample is that of the moment at which it begins
            assert (told[name][1:] == ours[:-1]).all(), (version, name)
            assert told[name][0] == ours[0]


def test_programs_estimate_with_it_what_the_exported_c_does(tmp_path: Path) -> None:
    same_as_c(saved_fmus(tmp_path, "high_gain"), "high_gain", samples(1000))


@pytest.mark.chaos
@pytest.mark.parametrize("observer", OBSERVERS)
def test_of_every_observer_too(observer: str, tmp_path: Path) -> None:
    same_as_c(saved_fmus(tmp_path, observer, scenario="paper-noisy"), observer, recorded("paper-noisy"))


@pytest.mark.parametrize("version", fmu.VERSIONS)
def test_the_standards_own_headers_agree_with_it(version: str, tmp_path: Path) -> None:
    manifest = exported("high_gain", PERIOD)
    for name, text in {**c_files(manifest), **fmu.shell(manifest, version, "{}")}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    headers, number = Path(fmpy.__file__).parent / "c-code", version[0]
    theirs = ["-isystem", headers, "-include", f"fmi{number}Functions.h"]
    for further in (theirs, []):
        command = [CC, *STRICT, *further, "-c", "fmi-shell.c"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
    # each function that they name is there, once
    named = re.findall(r"FMI\d_Export\s+\w+TYPE\s+(\w+);", (headers / f"fmi{number}Functions.h").read_text())
    ours = re.findall(r"^FMI\d_Export .*?(fmi\d\w+)\(", (tmp_path / "fmi-shell.c").read_text(), re.MULTILINE)
    absent = re.findall(r"^[A-Z]+\((fmi\d\w+)\)", (tmp_path / "fmi-absent.c").read_text(), re.MULTILINE)
    assert sorted(ours + absent) == sorted(named)
    subprocess.run([CC, *STRICT, "-c", "fmi-absent.c"], cwd=tmp_path, check=True)


def test_the_same_export_is_the_same_file(tmp_path: Path) -> None:
    first, second = (saved_fmus(tmp_path / name, "high_gain") for name in ("first", "second"))
    for version in VERSIONS:
        name = f"high_gain-{version}.fmu"
        assert (first / name).read_bytes() == (second / name).read_bytes()
        with zipfile.ZipFile(first / name) as archive:
            assert archive.testzip() is None


def described(manifest: Manifest, version: str) -> ElementTree.Element:
    return ElementTree.fromstring(model_description(manifest, version, "{}"))  # noqa: S314  of our own text


def test_it_says_units_bounds_defaults_and_what_numbers_are() -> None:
    muscles = RECORDINGS / "dgf_smooth.toml"
    manifest = exported("high_gain", PERIOD, muscles=muscles)
    second, third = (described(manifest, version) for version in fmu.VERSIONS)
    for root in (second, third):
        powers = {unit.get("name"): unit.find("BaseUnit").attrib for unit in root.iter("Unit")}
        assert powers["N"] == {"kg": "1", "m": "1", "s": "-2"}
        assert powers["m/s2"] == {"m": "1", "s": "-2"}
        assert powers["m/s"] == {"m": "1", "s": "-1"}
    flat = {variable.get("name"): variable.attrib for variable in third.iter("Float64")}
    for scalar in second.iter("ScalarVariable"):
        name, real = scalar.get("name"), scalar.find("Real").attrib
        assert flat[name] == {**scalar.attrib, **real}
    assert flat["y2"]["unit"] == "N"
    assert flat["Delta_hat"]["unit"] == "m/s2"
    assert (flat["a1_hat"]["min"], flat["a1_hat"]["max"]) == ("0.0", "1.0")
    assert (flat["eps_h"]["variability"], flat["eps_h"]["min"]) == ("tunable", "0.0")
    assert flat["eps_h"]["description"].endswith("> 0")
    assert float(flat["eps_h"]["start"]) == 0.1
    assert not {"start", "unit"} & set(flat["a1_hat"])


def test_words_of_a_block_are_harmless_in_a_description() -> None:
    words = "</Float64> & \" ' \0\n\x1b \u202e ε ]]> \ud800"
    usual = exported("high_gain", PERIOD)
    manifest = replace(usual, params=[replace(usual.params[0], sentence=words, unit="<V>"), *usual.params[1:]])
    for version in fmu.VERSIONS:
        root = described(manifest, version)
        (first,) = (
            variable for variable in root.find("ModelVariables") if variable.get("name") == usual.params[0].name
        )
        assert first.get("description").startswith("</Float64> & \" '       ε ]]>  ;")
        assert [unit.get("name") for unit in root.iter("Unit")] == ["<V>"]


def test_macos_finds_the_library_of_its_processor_among_several() -> None:
    intel, arm = (b"\xcf\xfa\xed\xfe" + kind.to_bytes(4, "little") + bytes(1000) for kind in (0x01000007, 0x0100000C))
    joined = universal([intel, arm])
    assert joined[:8] == bytes.fromhex("cafebabe00000002")
    for i, library in enumerate((intel, arm)):
        entry = [int.from_bytes(joined[at : at + 4], "big") for at in range(8 + 20 * i, 28 + 20 * i, 4)]
        kind, _, offset, size, alignment = entry
        assert kind.to_bytes(4, "little") == library[4:8]
        assert offset % (1 << alignment) == 0
        assert joined[offset : offset + size] == library


def test_numbers_that_an_fmu_cannot_tell_apart_are_named(command, tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(TWICE, encoding="utf-8")
    code, out, err = command("export", "fmu", "--observer", "own.py:mine", "--period", "0.01", "--out", "fmu")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("hillobs: mine: two numbers are called 'x1_hat'")
    assert not (tmp_path / "fmu").exists()


TWICE = """
from hillobs import Block, Parameter, Symbols, symbols
x, u = symbols("x1_hat x2_hat Delta_hat x3_hat u1_hat x4_hat u2_hat"), symbols("y1 y2 y3")
about = {"x1_hat": Parameter(1.0, "a number", "here")}
dx = Symbols({name: -symbol for name, symbol in x.items()})
mine = Block("mine", x=x, u=u, p=symbols(about), parameters=about, dx=dx, y=Symbols(x))
"""
ASKED = ["export", "fmu", "--observer", "high_gain", "--period", "0.005", "--out", "fmu"]


def test_without_a_compiler_a_sentence_says_what_to_install(command, monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CXX", "/nothing/here")
    code, out, err = command(*ASKED)
    assert (code, out) == (2, "")
    assert "is no working compiler" in err
    assert "pip install 'hillobs[compiler]'" in err
    assert not (tmp_path / "fmu").exists()


def test_what_is_there_already_stays_unless_it_is_ours(command, tmp_path: Path) -> None:
    (tmp_path / "fmu").mkdir()
    (tmp_path / "fmu" / "high_gain-fmi3.fmu").write_text("mine")
    code, out, err = command(*ASKED)
    assert (code, out) == (2, "")
    assert "is there already" in err
    assert [path.name for path in (tmp_path / "fmu").iterdir()] == ["high_gain-fmi3.fmu"]
    (tmp_path / "fmu" / "high_gain-fmi3.fmu").unlink()
    for _ in range(2):
        assert command(*ASKED)[0] == 0
