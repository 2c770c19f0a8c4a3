"""What an import leaves out, or takes from elsewhere: a note for each, and none for what does nothing."""

import re
from pathlib import Path

import pytest

from altered_models import ARM, COUPLER, constrained, replaced
from hillobs.studies.laboratory.opensim.model import read_model


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
