"""A model's text with a piece taken out, replaced or put in, and the sentence that refuses what is left."""

import re
from pathlib import Path

import pytest

from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.mechanisms.from_opensim import mechanism_from
from hillobs.studies.laboratory.opensim.model import read_model
from places import DATA

ARM = (DATA / "arm26_polynomial.osim").read_text(encoding="utf-8")


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
