"""OpenSim files that are none or that try something: a sentence each, and nothing is read, fetched or filled."""

import re
import tracemalloc
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from altered_models import ARM, refusal
from hillobs.model.errors import Error
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.mechanisms.from_opensim import mechanism_from
from hillobs.studies.laboratory.opensim.model import read_model
from hillobs.studies.laboratory.opensim.paths import read_paths
from places import DATA

LAUGHS = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 30))
CONTENT = "what nobody may see"
HOSTILE = {
    "billion laughs": f'<!DOCTYPE x [<!ENTITY l0 "ha">{LAUGHS}]><OpenSimDocument>&l29;</OpenSimDocument>',
    "one long entity": f'<!DOCTYPE x [<!ENTITY a "{"a" * 9999}">]><OpenSimDocument>{"&a;" * 9999}</OpenSimDocument>',
    "external file": '<!DOCTYPE x [<!ENTITY f SYSTEM "file://@secret@">]><OpenSimDocument>&f;</OpenSimDocument>',
    "external document type": '<!DOCTYPE x SYSTEM "http://127.0.0.1:9/x.dtd"><OpenSimDocument/>',
    "parameter entity": '<!DOCTYPE x [<!ENTITY % p SYSTEM "file://@secret@">%p;]><OpenSimDocument/>',
    "document type alone": "<!DOCTYPE OpenSimDocument><OpenSimDocument/>",
}


@pytest.mark.parametrize("attack", HOSTILE)
def test_no_document_type_is_read(attack: str, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text(CONTENT)
    sentence = refusal(tmp_path, HOSTILE[attack].replace("@secret@", str(tmp_path / "secret")))
    assert re.match("line 1: declares a document type", sentence)
    assert CONTENT not in sentence


NOT_XML = {
    "": "not valid XML: line 1: no element found",
    "hello": "not valid XML: line 1: syntax error",
    "[links]\nmass = 1": "not valid XML: line 1: syntax error",
    ARM[:5000]: "not valid XML: line ",
    "<a>\n<b>\n</a>": "not valid XML: line 3: mismatched tag",
    "<OpenSimDocument>&unknown;</OpenSimDocument>": "not valid XML: line 1: undefined entity",
    "<OpenSimDocument a='1' a='2'/>": "not valid XML: line 1: duplicate attribute",
    "<OpenSimDocument>\0</OpenSimDocument>": "not valid XML: line 1: not well-formed (invalid token)",
    "<?xml version='1.0' encoding='klingon'?><OpenSimDocument/>": "not valid XML: it is in an encoding that cannot",
    "<?xml version='1.0' encoding='utf-7'?><OpenSimDocument/>": "not valid XML: it is in an encoding that cannot",
    "<?xml version='1.0' encoding='utf-32'?><OpenSimDocument/>": "not valid XML: it is in an encoding that cannot",
    "<?xml version='1.0' encoding='UTF-16'?><OpenSimDocument/>": "not valid XML: ",
    "<html><body>404</body></html>": "is no OpenSim file: it holds 'html', not OpenSimDocument",
    "<OpenSimDocument/>": "has no Model, but nothing",
    "<OpenSimDocument><Model/></OpenSimDocument>": "has no bodies",
    "<a>" * 200 + "</a>" * 200: "line 1: deeper than 100",
}


@pytest.mark.parametrize("content", NOT_XML, ids=lambda content: content[:60])
def test_what_is_no_opensim_file_is_a_sentence(content: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, content).startswith(NOT_XML[content])


def test_a_file_of_too_many_elements_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hillobs.studies.laboratory.opensim.xml._MOST_ELEMENTS", 1000)
    many = "<OpenSimDocument>" + "<a/>" * 1000 + "</OpenSimDocument>"
    assert refusal(tmp_path, many).startswith("line 1: more than 1,000 elements")


def test_letters_that_are_no_utf_8_are_a_sentence(tmp_path: Path) -> None:
    letters = ARM.replace("\u2013", "\xe4").encode("latin-1")
    assert refusal(tmp_path, letters).startswith("not valid XML: line ")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "latin-1"])
def test_an_encoding_that_the_file_declares_is_read(encoding: str, tmp_path: Path) -> None:
    declared = {"utf-8-sig": "utf-8"}.get(encoding, encoding)
    path = tmp_path / "model.osim"
    text = re.sub("encoding='[^']*'", f"encoding='{declared}'", ARM).replace("\u2013", "-")
    path.write_bytes(text.encode(encoding))
    assert read_model(path).tree == read_model(DATA / "arm26_polynomial.osim").tree


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "model.osim"
    with open(path, "wb") as file:
        file.truncate(10**11)
    tracemalloc.start()
    with pytest.raises(ScenarioError, match="it is larger than 30,000,000 bytes"):
        read_model(path)
    assert tracemalloc.get_traced_memory()[1] < 10**6
    tracemalloc.stop()
    with pytest.raises(ScenarioError, match="cannot be read: Is a directory"):
        read_model(tmp_path)
    with pytest.raises(ScenarioError, match=r"none\.osim: cannot be read: No such file or directory"):
        read_model(tmp_path / "none.osim")


def said_of(path: Path) -> str:
    """The error of a model, empty where damage has left one that can be read."""
    try:
        mechanism_from(read_model(path), path.name)
    except Error as error:
        return str(error)
    return ""


@given(st.integers(0, len(ARM)), st.integers(0, 200), st.text(max_size=20))
def test_damage_anywhere_is_a_sentence_or_a_model(at: int, length: int, words: str) -> None:
    with pytest.MonkeyPatch.context() as patch:
        damaged = (ARM[:at] + words + ARM[at + length :]).encode("utf-8", "replace")
        patch.setattr("hillobs.studies.laboratory.opensim.xml.read_whole", lambda *_: damaged)
        assert "\n" not in said_of(Path("model.osim"))


def test_a_file_of_paths_without_any_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "paths.xml").write_text("<OpenSimDocument><Set_FunctionBasedPath_/></OpenSimDocument>")
    with pytest.raises(ScenarioError, match=r"paths\.xml: has no FunctionBasedPath"):
        read_paths(tmp_path / "paths.xml")
    twice = (DATA / "arm26_paths_order5.xml").read_text().replace("/forceset/TRIlat", "/forceset/TRIlong")
    (tmp_path / "paths.xml").write_text(twice)
    with pytest.raises(
        ScenarioError, match=r"paths\.xml: FunctionBasedPath '/forceset/TRIlong', line 20: there is another"
    ):
        read_paths(tmp_path / "paths.xml")
