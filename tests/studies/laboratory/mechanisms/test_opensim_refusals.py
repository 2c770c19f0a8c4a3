"""OpenSim files that are none, that try something, or that hold what is not taken: a sentence each."""

import re
import tracemalloc
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.model.errors import Error
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.mechanisms.from_opensim import mechanism_from
from hillobs.studies.laboratory.opensim.model import read_model
from hillobs.studies.laboratory.opensim.paths import read_paths
from places import DATA

ARM = (DATA / "arm26_polynomial.osim").read_text(encoding="utf-8")
JOINTS = (DATA / "joints.osim").read_text(encoding="utf-8")


def refusal(path: Path, content: bytes | str, **options) -> str:
    """The sentence for a model with this content, without the file's name."""
    path = path / "model.osim" if path.is_dir() else path
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ScenarioError) as caught:
        mechanism_from(read_model(path, **options), path.name)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert len(sentence) < 500 + len(str(path))
    return sentence.removeprefix(f"{path}: ")


# ---------------------------------------------------------------- XML

LAUGHS = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 30))
SECRET = "what nobody may see"  # noqa: S105  no password, but a file's content
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
    (tmp_path / "secret").write_text(SECRET)
    sentence = refusal(tmp_path, HOSTILE[attack].replace("@secret@", str(tmp_path / "secret")))
    assert re.match("line 1: declares a document type", sentence)
    assert SECRET not in sentence


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


# ---------------------------------------------------------------- models


def without(pattern: str, text: str = ARM, count: int = 1) -> str:
    """The text without the first piece like this."""
    return re.sub(pattern, "", text, count=count, flags=re.DOTALL)


def replaced(old: str, new: str, text: str = ARM, count: int = 1) -> str:
    assert old in text
    return text.replace(old, new, count)


def constrained(words: str) -> str:
    return replaced(
        '<ConstraintSet name="constraintset">\n\t\t\t<objects />', f"<ConstraintSet><objects>{words}</objects>"
    )


COUPLER = (
    '<CoordinateCouplerConstraint name="c"><isEnforced>true</isEnforced><independent_coordinate_names>r_shoulder_elev'
    "</independent_coordinate_names><dependent_coordinate_name>r_elbow_flex</dependent_coordinate_name>"
    "</CoordinateCouplerConstraint>"
)
ELBOW = "<coordinates>r_elbow_flex</coordinates>"
SPLINE = "<SimmSpline name='function'><x>0 1</x><y>0 1</y></SimmSpline>"
SECOND = 'rotation2">\n\t\t\t\t\t\t\t\n\t\t\t\t\t\t\t<coordinates />'
MODELS: dict[str, str] = {
    "line 3: a name of more than 200 characters": replaced('"arm26"', f'"{"a" * 201}"'),
    "length_units must be meters, not 'millimeters'": replaced("<length_units>meters", "<length_units>millimeters"),
    "Body 'base' has no mass": without(r"<mass>0</mass>"),
    "Body 'r_humerus': mass must be a number, not 'nan'": replaced("1.8645719999999999", "nan"),
    "Body 'r_humerus': mass must be a number, not 'inf'": replaced("1.8645719999999999", "inf"),
    "Body 'r_humerus': mass must be a number, not '1,8'": replaced("1.8645719999999999", "1,8"),
    "Body 'r_humerus': mass must be a finite number, not inf": replaced("1.8645719999999999", "1e999"),
    "Body 'r_humerus': inertia must be 6 numbers": replaced(" 0.013193 0 0 0", " 0.013193"),
    "link r_humerus: its inertia is not positive definite": replaced("0.01481 0.0045", "-0.01481 0.0045"),
    "Body 'base': there is another body 'base'": replaced('<Body name="r_humerus">', '<Body name="base">'),
    "link r_ulna_radius_hand hangs in no joint": without('<CustomJoint name="r_elbow">.*?</CustomJoint>'),
    "link r_ulna_radius_hand hangs in two joints, more and elbow": replaced(
        '<WeldJoint name="offset">',
        '<WeldJoint name="more"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/bodyset/'
        'r_ulna_radius_hand</socket_child_frame></WeldJoint><WeldJoint name="offset">',
    ),
    "links hang in a circle": replaced(
        "<socket_parent>/ground</socket_parent>", "<socket_parent>/bodyset/r_humerus</socket_parent>"
    ),
    "WeldJoint 'offset': there is no frame 'nowhere'": replaced("ground_offset</socket", "nowhere</socket"),
    "WeldJoint 'offset' has no socket_child_frame": without("<socket_child_frame>.*?</socket_child_frame>"),
    "links.r_humerus.com[1] must be at least -20, not -180.496": replaced("0 -0.18049599999999999 0", "0 -180.496 0"),
    "has two joints called 'r_elbow'": replaced('<CustomJoint name="r_shoulder">', '<CustomJoint name="r_elbow">'),
    "has two coordinates called 'r_elbow_flex'": replaced("r_shoulder_elev", "r_elbow_flex", count=9),
    "CustomJoint 'r_shoulder' has no SpatialTransform": replaced("SpatialTransform>", "Transform>", count=2),
    "CustomJoint 'r_shoulder': rotation1: its axis is 0 0 0": replaced(
        "-0.058898020000000002 0.0023 0.99826135999999999", "0 0 0"
    ),
    "CustomJoint 'r_shoulder': rotation1: its function is a SimmSpline; only": re.sub(
        "<LinearFunction.*?</LinearFunction>", SPLINE, ARM, count=1, flags=re.DOTALL
    ),
    "CustomJoint 'r_shoulder': moves by 2 times its coordinate r_shoulder_elev": replaced("> 1 0<", "> 2 0<"),
    "CustomJoint 'r_shoulder': rotation1: must have one of the joint's coordinates, r_shoulder_elev": replaced(
        "<coordinates>r_shoulder_elev", "<coordinates>r_wrist"
    ),
    "CustomJoint 'r_shoulder': r_shoulder_elev moves it along 2 axes": replaced(
        SECOND, SECOND.replace("<coordinates />", "<coordinates>r_shoulder_elev</coordinates>")
    ).replace(
        '<Constant name="function">\n\t\t\t\t\t\t\t\t<value>0</value>\n\t\t\t\t\t\t\t</Constant>',
        "<LinearFunction name='function'/>",
        1,
    ),
    "ScapulothoracicJoint 'slide': joints of this class are not read; there are WeldJoint": re.sub(
        "SliderJoint", "ScapulothoracicJoint", JOINTS
    ),
    "GimbalJoint 'gimbal': has 2 free coordinates, gimbal_1, gimbal_2; only pins and sliders": replaced(
        '<locked>true</locked></Coordinate><Coordinate name="gimbal_2">',
        '</Coordinate><Coordinate name="gimbal_2">',
        JOINTS,
    ),
    "SliderJoint 'slide': must have 1 coordinates, not 0": without(
        '<coordinates><Coordinate name="slide_q">.*?</coordinates>', JOINTS
    ),
    "PinJoint 'pin': is reversed": replaced(
        '<PinJoint name="pin">', '<PinJoint name="pin"><reverse>true</reverse>', JOINTS
    ),
    "SpringGeneralizedForce 's1': there is no coordinate 'q'": replaced(
        ">pin_q</coordinate>", ">q</coordinate>", JOINTS
    ),
    "CoordinateCouplerConstraint 'c': 'r_elbow_flex' follows other coordinates": constrained(COUPLER),
    "PointConstraint 'p': closes a loop; only trees": constrained("<PointConstraint name='p'/>"),
    "has no muscles": without("<ForceSet.*?</ForceSet>"),
    "Schutte1993Muscle_Deprecated 'TRIlong': muscles of this class are not read, but Thelen2003Muscle": re.sub(
        "DeGrooteFregly2016Muscle", "Schutte1993Muscle_Deprecated", ARM, count=2
    ),
    "DeGrooteFregly2016Muscle 'TRIlong' has no max_isometric_force": without(
        "<max_isometric_force>.*?</max_isometric_force>"
    ),
    "DeGrooteFregly2016Muscle 'TRIlong': optimal_fibre_length must be at least 1e-05, not 0": replaced(
        "<optimal_fiber_length>0.13400000000000001", "<optimal_fiber_length>0"
    ),
    "DeGrooteFregly2016Muscle 'TRIlong': there is another muscle 'TRIlong'": replaced('"TRIlat"', '"TRIlong"'),
    "'TRI.lat' and 'TRI_lat' would both be called TRI_lat": ARM.replace('"TRIlat"', '"TRI.lat"').replace(
        '"TRImed"', '"TRI_lat"'
    ),
    "the path of TRIlong crosses 'r_wrist', which is no coordinate; there are r_shoulder_elev, r_elbow_flex": replaced(
        "/jointset/r_elbow/r_elbow_flex</coordinate_paths>", "/jointset/r_wrist/r_wrist</coordinate_paths>"
    ),
    "the path of TRIlong: a polynomial of order 4 in r_shoulder_elev, r_elbow_flex has 15 coef": replaced(
        "<order>5</order>", "<order>4</order>"
    ),
    "the path of TRIlong: a polynomial of order 50 in 2 joints is too large": replaced(
        "<order>5</order>", "<order>50</order>"
    ),
    "FunctionBasedPath 'path': its order must be a whole number, not 0.5": replaced(
        "<order>5</order>", "<order>.5</order>"
    ),
    "FunctionBasedPath 'path': a polynomial of 1 arguments does not fit the coordinates r_shoulder_elev": replaced(
        "<dimension>2", "<dimension>1"
    ),
    "FunctionBasedPath 'path' has no coordinate_paths": without("<coordinate_paths>.*?</coordinate_paths>"),
    "FunctionBasedPath 'path': has the coordinate 'r_elbow_flex' twice": replaced(
        "/jointset/r_shoulder/r_shoulder_elev /jointset", "/jointset/r_elbow/r_elbow_flex /jointset"
    ),
    "FunctionBasedPath 'path': its length_function must be a MultivariatePolynomialFunction, not GCVSpline": re.sub(
        "MultivariatePolynomialFunction", "GCVSpline", ARM, count=2
    ),
    "FunctionBasedPath 'path': its length_function must be a MultivariatePolynomialFunction, not nothing": without(
        "<length_function>.*?</length_function>"
    ),
    "MultivariatePolynomialFunction '' has no coefficients": without("<coefficients>0.27.*?</coefficients>"),
}


@pytest.mark.parametrize("sentence", MODELS)
def test_what_is_not_taken_of_a_model_is_named(sentence: str, tmp_path: Path) -> None:
    said = refusal(tmp_path, MODELS[sentence])
    assert re.sub(r", line [0-9]+", "", said).startswith(sentence)


def test_the_line_of_what_is_wrong_is_told(tmp_path: Path) -> None:
    said = refusal(tmp_path, MODELS["Body 'r_humerus': mass must be a number, not 'nan'"])
    line = re.match(r"Body 'r_humerus', line ([0-9]+): ", said)
    assert line is not None
    assert ARM.splitlines()[int(line[1]) - 1].strip() == '<Body name="r_humerus">'


GEOMETRY = (
    '<GeometryPath name="path"><PathPointSet><objects><PathPoint name="a"><socket_parent_frame>/bodyset/base'
    "</socket_parent_frame><location>0 0 0</location></PathPoint></objects></PathPointSet></GeometryPath>"
)


def test_what_stands_beside_the_sets_of_a_model_is_found(tmp_path: Path) -> None:
    """A program may add bodies, joints and muscles as components of the model."""
    moved, components = ARM, ""
    for pattern in (
        '<Body name="r_ulna.*?</Body>',
        '<CustomJoint name="r_elbow".*?</CustomJoint>',
        "<DeGroote.*?2016Muscle>",
    ):
        piece = re.search(pattern, moved, re.DOTALL)
        assert piece is not None
        moved, components = moved.replace(piece[0], ""), components + piece[0]
    text = replaced("<gravity>", f"<components>{components}</components><gravity>", moved)
    (tmp_path / "model.osim").write_text(text, encoding="utf-8")
    found, plain = read_model(tmp_path / "model.osim"), read_model(DATA / "arm26_polynomial.osim")
    assert (found.tree, found.polynomials) == (plain.tree, plain.polynomials)


@pytest.mark.parametrize("unit", ["meters", "m", "Meter"])
def test_a_metre_has_several_names(unit: str, tmp_path: Path) -> None:
    (tmp_path / "model.osim").write_text(replaced("<length_units>meters", f"<length_units>{unit}"), encoding="utf-8")
    assert read_model(tmp_path / "model.osim").tree == read_model(DATA / "arm26_polynomial.osim").tree


def test_remarks_between_digits_are_no_blanks(tmp_path: Path) -> None:
    text = replaced("1.8645719999999999", "1.86<!-- kg -->457<!-- -->2")
    (tmp_path / "model.osim").write_text(text, encoding="utf-8")
    assert read_model(tmp_path / "model.osim").tree.links["r_humerus"].mass == 1.864572


def test_geometry_without_polynomials_is_named_with_the_way_to_get_some(tmp_path: Path) -> None:
    wrapped = re.sub("<FunctionBasedPath.*?</FunctionBasedPath>", GEOMETRY, ARM, count=2, flags=re.DOTALL)
    sentence = refusal(tmp_path, wrapped)
    assert sentence.startswith("TRIlong, TRIlat: geometry without polynomials is not read; fit them with --fit")
    assert "--paths" in sentence
    # those that are there can be taken alone
    assert list(read_model(tmp_path / "model.osim", only=["BRA", "BIClong"]).muscles) == ["BIClong", "BRA"]
    model = read_model(tmp_path / "model.osim", DATA / "arm26_paths_order5.xml")
    assert model.polynomials == read_model(DATA / "arm26_polynomial.osim").polynomials


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"only": ["BRA", "bra"]}, "has no muscle 'bra'; there are TRIlong, TRIlat, TRImed, BIClong, BICshort, BRA"),
        ({"locks": {"wrist": 0.1}}, "'wrist' is no joint and no coordinate; there are r_shoulder_elev, r_elbow_flex"),
        ({"ranges": {"elbow": (2.0, 1.0)}}, "joint elbow: its range must rise, not go from 2 to 1"),
    ],
)
def test_a_request_for_what_is_not_there_is_a_sentence(options: dict, sentence: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, ARM, **options) == sentence


def test_a_joint_of_several_coordinates_is_locked_by_theirs(tmp_path: Path) -> None:
    sentence = refusal(tmp_path, JOINTS, locks={"gimbal": 0.1})
    assert sentence == "'gimbal' has more than one coordinate; there are gimbal_1, gimbal_2, gimbal_3"


# ---------------------------------------------------------------- what is left out, in a note


def notes(text: str, folder: Path, **options) -> list[str]:
    (folder / "model.osim").write_text(text, encoding="utf-8")
    return list(read_model(folder / "model.osim", **options).notes)


FORCE = "</DeGrooteFregly2016Muscle>\n\t\t\t</objects>"


def forced(words: str) -> str:
    return replaced(FORCE, f"{FORCE.partition('>')[0]}>{words}</objects>")


NOTES = {
    "CoordinateLimitForce 'limit' left out: what they do counts as disturbance": (
        forced("<CoordinateLimitForce name='limit'><coordinate>r_elbow_flex</coordinate></CoordinateLimitForce>"),
        {},
    ),
    "HuntCrossleyForce 'floor', 'wall' left out: what they do counts as disturbance": (
        forced("<HuntCrossleyForce name='floor'/><HuntCrossleyForce name='wall'/>"),
        {},
    ),
    "r_elbow_flex is locked, which cuts its coupling 'c'": (constrained(COUPLER), {"locks": {"elbow": 1.0}}),
    "TRIlong: active_force_width_scale is 1.5 there and 1 in degroote_fregly2016": (
        replaced("<fiber_damping>0<", "<active_force_width_scale>1.5</active_force_width_scale><fiber_damping>0<"),
        {},
    ),
    "TRIlong: its tendon is rigid there and elastic here (ignore_tendon_compliance)": (
        replaced("<ignore_tendon_compliance>false", "<ignore_tendon_compliance>true"),
        {},
    ),
    "TRIlong: moment arms follow from its length; the functions beside it are not read": (
        replaced("</length_function>", "</length_function><moment_arm_functions><SimmSpline/></moment_arm_functions>"),
        {},
    ),
}


@pytest.mark.parametrize("note", NOTES)
def test_what_is_left_out_is_a_note(note: str, tmp_path: Path) -> None:
    text, options = NOTES[note]
    assert notes(text, tmp_path, **options) == [note]


@pytest.mark.parametrize(
    "words",
    [
        "<CoordinateLimitForce name='limit'><appliesForce>false</appliesForce></CoordinateLimitForce>",
        "<HuntCrossleyForce name='floor'><isDisabled>true</isDisabled></HuntCrossleyForce>",
        "<CoordinateActuator name='reserve'><coordinate>r_elbow_flex</coordinate></CoordinateActuator>",
    ],
)
def test_what_does_nothing_is_no_note(words: str, tmp_path: Path) -> None:
    assert notes(forced(words), tmp_path) == []


MILLARD = """<Millard2012EquilibriumMuscle name="TRIlong"><FunctionBasedPath name="path">
<coordinate_paths>q/r_elbow_flex</coordinate_paths><length_function>
<MultivariatePolynomialFunction><coefficients>0.3 0.02</coefficients><dimension>1
</dimension><order>1</order></MultivariatePolynomialFunction></length_function></FunctionBasedPath><max_isometric_force>
500</max_isometric_force><optimal_fiber_length>0.1</optimal_fiber_length><tendon_slack_length>0.2</tendon_slack_length>
<fiber_damping>0.05</fiber_damping><FiberForceLengthCurve><strain_at_one_norm_force>0.5</strain_at_one_norm_force>
<stiffness_at_low_force>0.2</stiffness_at_low_force><stiffness_at_one_norm_force>4</stiffness_at_one_norm_force>
<curviness>0.75</curviness></FiberForceLengthCurve><TendonForceLengthCurve><strain_at_one_norm_force>0.04
</strain_at_one_norm_force><stiffness_at_one_norm_force>34.375</stiffness_at_one_norm_force></TendonForceLengthCurve>
</Millard2012EquilibriumMuscle>"""


def test_millards_muscle_has_its_strains_in_its_curves(tmp_path: Path) -> None:
    muscle = re.search(r"<DeGrooteFregly2016Muscle.*?</DeGrooteFregly2016Muscle>", ARM, re.DOTALL)
    assert muscle is not None
    text = replaced(muscle[0], MILLARD)
    (tmp_path / "model.osim").write_text(text, encoding="utf-8")
    model = read_model(tmp_path / "model.osim")
    read = model.muscles["TRIlong"]
    assert read.curves.name == "millard2012"
    assert read.numbers == {"tendon_strain": 0.04, "passive_strain": 0.5, "damping": 0.05}
    assert (read.F_max, read.v_max, read.pennation) == (500.0, 10.0, 0.0)
    # a stiffness is 2 and 1.375 over the strain
    assert model.notes == ()
    stiff = text.replace("34.375", "40")
    assert notes(stiff, tmp_path) == [
        "TRIlong: TendonForceLengthCurve/stiffness_at_one_norm_force is 40 there and 34.375 in millard2012"
    ]


def test_what_a_muscle_does_not_say_its_default_object_says(tmp_path: Path) -> None:
    strain = "<tendon_strain_at_one_norm_force>0.033000000000000002</tendon_strain_at_one_norm_force>"
    default = '<defaults><DeGrooteFregly2016Muscle name="default"><tendon_strain_at_one_norm_force>0.06'
    default += "</tendon_strain_at_one_norm_force></DeGrooteFregly2016Muscle></defaults>"
    silent = ARM.replace(strain, "")
    for text, there in (
        (silent, 0.049),
        (replaced('<Model name="arm26">', f'<Model name="arm26">{default}', silent), 0.06),
    ):
        (tmp_path / "model.osim").write_text(text, encoding="utf-8")
        assert read_model(tmp_path / "model.osim").muscles["BRA"].numbers["tendon_strain"] == there


# ---------------------------------------------------------------- drawn damage


@given(st.integers(0, len(ARM)), st.integers(0, 200), st.text(max_size=20))
def test_damage_anywhere_is_a_sentence_or_a_model(at: int, length: int, words: str) -> None:
    with pytest.MonkeyPatch.context() as patch:
        damaged = (ARM[:at] + words + ARM[at + length :]).encode("utf-8", "replace")
        patch.setattr("hillobs.studies.laboratory.opensim.xml.read_whole", lambda *_: damaged)
        try:
            mechanism_from(read_model(Path("model.osim")), "model.osim")
        except Error as error:
            assert "\n" not in str(error)  # noqa: PT017  most damage is an error, some is none


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
