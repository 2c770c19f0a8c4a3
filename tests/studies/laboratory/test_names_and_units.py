"""Names of columns are known in every spelling, units become SI, and what is wrong with either is a sentence."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.files.errors import RecordingError
from hillobs.studies.laboratory.columns import choose, name_and_unit
from hillobs.studies.laboratory.units import SI, UNITS, find_unit, unit_of
from written_recording import HEAD, ROWS, TABLE, numbers, reading, refusal


def test_names_are_known_in_every_spelling() -> None:
    assert name_and_unit(" Fiber_Length_1 (mm) ") == ("fibre_length_1", "mm")
    assert name_and_unit("/forceset/m2|tendon_force") == ("force_2", "")
    assert name_and_unit("position_min") == ("position_min", "")
    assert name_and_unit("force_1_1") == ("force_1_1", "")
    assert name_and_unit("activation_1 []") == ("activation_1", "1")
    columns = choose(["time", "position_mm", "position_max", "force_1", "force_2"], [""] * 5, {})
    assert [(column.name, column.unit.symbol) for column in columns][1] == ("position", "mm")
    assert (
        choose(["a", "x_mm", "b", "c"], [""] * 4, dict(zip(HEAD.split(","), ["a", "x_mm", "b", "c"], strict=True)))[
            1
        ].unit
        == UNITS["mm"]
    )


@pytest.mark.parametrize(
    ("head", "factors"),
    [
        ("time [ms],position [mm],force_1 [kN],force_2 [mN]", (1e-3, 1e-3, 1e3, 1e-3)),
        ("time [µs],position [cm],force_1,force_2 (N)", (1e-6, 1e-2, 1, 1)),
        ("time_min,position_um,force_1_kN,force_2", (60, 1e-6, 1e3, 1)),
        ("# units: ms,mm,N,kN\ntime,position,force_1,force_2", (1e-3, 1e-3, 1, 1e3)),
        ("time,position,force_1,force_2\nms,[mm],,kN", (1e-3, 1e-3, 1, 1e3)),
    ],
)
def test_units_become_SI(head: str, factors: tuple[float, ...], folder: Path) -> None:
    plain, scaled = numbers(reading(folder, TABLE)), numbers(reading(folder, head + ROWS))
    np.testing.assert_allclose(scaled, plain * np.array(factors), rtol=3e-16)
    further = "velocity [mm/s],acceleration [m/s^2],activation_1 [%],disturbance [kN]"
    true = reading(folder, f"{HEAD},{further}\n0,1,2,3,4,5,6,7\n").true
    assert [float(values[0]) for values in true.values()] == [0.004, 5.0, 0.06, 7000.0]


@pytest.mark.parametrize("words", [("deg", "°", "degree", "degrees"), ("rad", "radian", "radians")])
def test_angles_have_units_in_words_too(words: tuple[str, ...]) -> None:
    assert {find_unit(word) for word in words} == {UNITS[words[0]]}


def test_an_angle_is_in_rad_or_deg() -> None:
    for text, told in (("gon", "unknown unit 'gon'"), ("m", "m is the unit of a length")):
        with pytest.raises(RecordingError, match=f"^there: {told}; an angle is in rad, deg$"):
            unit_of(text, "angle", "there")


@given(st.sampled_from(sorted(UNITS)), st.floats(-1e290, 1e290).filter(lambda x: x == 0 or abs(x) > 1e-290))
def test_conversion_inverts(name: str, value: float) -> None:
    unit = UNITS[name]
    there = unit.to_SI(np.array([value]))
    np.testing.assert_allclose(unit.from_SI(there), value, rtol=4e-16)
    if unit == SI[unit.quantity]:
        assert there[0] == value


def test_whole_millimetres_are_the_nearest_double(folder: Path) -> None:
    rows = "".join(f"{i},{i},2,3\n" for i in range(1, 1000))
    recording = reading(folder, f"time [ms],position [mm],force_1,force_2\n{rows}")
    assert recording["position"].tolist() == [float(f"{i}e-3") for i in range(1, 1000)]


@pytest.mark.parametrize(
    ("head", "sentence"),
    [
        (
            "time,positon,force_1,force_2",
            "there is no column position; the nearest are 'positon'; "
            "a mapping says which it is: --map position=COLUMN[UNIT]",
        ),
        (
            "zeit,x,f,g",
            "there is no column time; there are 'zeit', 'x', 'f', 'g'; nor is there position or force_1 or force_2; "
            "a mapping says which it is: --map time=COLUMN[UNIT]",
        ),
        (
            "time,position,force_1,F2",
            "there is no column force_2; the nearest are 'force_1'; "
            "a mapping says which it is: --map force_2=COLUMN[UNIT]",
        ),
        (",,,", "there is no column time; no column has a name; nor is there position or force_1 or force_2"),
        ("1,2,3,4", "row 1 holds numbers where the names of the columns should be"),
        ("time,position,position,force_1", "position is there twice, in columns 2 and 3; say which by a mapping"),
        (
            "time,position [N],force_1,force_2",
            "column 'position [N]': N is the unit of a force; a length is in m, cm, mm, um",
        ),
        (
            "time,position_deg,force_1,force_2",
            "column 'position_deg': deg is the unit of an angle; a length is in m, cm, mm, um",
        ),
        (
            "time [fortnight],position,force_1,force_2",
            "column 'time [fortnight]': unknown unit 'fortnight'; a time is in s, ms, us, min",
        ),
        (
            "# units: s,mm,N,N\ntime,position [m],force_1,force_2",
            "column 'position [m]': its unit is m in one place and mm in another",
        ),
        (
            "# units: s,mm,N,N\ntime,position,force_1,force_2\ns,mm,N,N",
            "row 3 holds units, and so does a comment above it",
        ),
        ("# units: s,mm\ntime,position,force_1,force_2", "the comment on units has 2 for 4 columns"),
        ('time,"position,force_1,force_2', "row 1: a quoted cell does not end where it should"),
    ],
)
def test_wrong_names_and_units_are_sentences(head: str, sentence: str, folder: Path) -> None:
    assert refusal(folder, head + ROWS) == sentence


def test_a_missing_column_says_what_is_there_and_no_novel(folder: Path) -> None:
    sentence = refusal(folder, ",".join(f"c{i}" for i in range(50)) + "\n")
    first = ", ".join(f"'c{i}'" for i in range(8))
    assert sentence == (
        f"there is no column time; there are {first} and 42 more; nor is there position or force_1 or force_2; "
        "a mapping says which it is: --map time=COLUMN[UNIT]"
    )
    assert len(refusal(folder, "x" * 100_000 + ",\x1b[31mred\n")) < 400
