"""What is not taken of a model, or has a second spelling: a sentence that names it."""

import re
from pathlib import Path

import pytest

from altered_models import ARM, COUPLER, constrained, refusal, replaced, without
from hillobs.studies.laboratory.opensim.model import read_model
from places import DATA

JOINTS = (DATA / "joints.osim").read_text(encoding="utf-8")
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
