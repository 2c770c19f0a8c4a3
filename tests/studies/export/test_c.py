"""Exported C: the same estimates as the follower of recordings, without a warning, without a symbol of its own."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from exported_programs import (
    CC,
    PERIOD,
    STRICT,
    answered,
    assert_same,
    built,
    compiled,
    estimates,
    followed,
    needs_cc,
    recorded,
    saved,
)
from hillobs.model.curves import SIMULATED
from hillobs.observers import OBSERVERS
from hillobs.studies.estimate.run import estimate
from hillobs.studies.laboratory.subject import subject_of
from places import RECORDINGS

pytestmark = needs_cc


# one with a boundary layer and steps between samples, one that moves at samples, which has the most equations
@pytest.mark.parametrize(("observer", "single"), [("sliding_mode", True), ("kalman", False)])
def test_it_estimates_what_the_follower_of_recordings_does(observer: str, single: bool, tmp_path: Path) -> None:
    y = recorded("paper-noisy")
    steps = saved(tmp_path, observer, single=single, scenario="paper-noisy", corrected=False)
    theirs = estimates(built(tmp_path, observer), "y1,y2,y3", y)
    assert_same(theirs, followed(compiled("paper-noisy", {}, False), observer, "paper-noisy", {}, y, steps), single)


@pytest.mark.chaos
@pytest.mark.parametrize("curves", SIMULATED)
@pytest.mark.parametrize("observer", OBSERVERS)
def test_every_observer_with_all_curves_estimates_what_the_follower_does(
    observer: str, curves: str, tmp_path: Path
) -> None:
    changes = {"muscle.curves": curves}
    for scenario in ("paper-noisy", "challenge"):
        y = recorded(scenario, changes)
        bank = compiled(scenario, changes, True, "scalar")
        for single in (False, True):
            folder = tmp_path / f"{scenario}-{single}"
            steps = saved(folder, observer, single=single, scenario=scenario, changes=changes)
            program = built(folder, observer, "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
            theirs = estimates(program, "y1,y2,y3", y)
            assert_same(theirs, followed(bank, observer, scenario, changes, y, steps), single)


@pytest.mark.chaos
def test_of_a_mechanism_too_it_takes_and_tells_si_as_estimate_does(tmp_path: Path) -> None:
    subject = subject_of(RECORDINGS / "arm.toml")
    told = estimate(RECORDINGS / "arm_noisy.csv.gz", subject, "high_gain_3")
    gains = json.loads(told.attrs["gains"])["high_gain_3"]
    saved(tmp_path, "high_gain_3", period=float(told.attrs["period"]), muscles=subject, changes=gains)
    rows = np.column_stack([told.position, told.force])
    theirs = estimates(built(tmp_path, "high_gain_3"), ",".join(subject.columns.required), rows)
    of = told.sel(observer="high_gain_3")
    columns = {f"{muscle}_a_hat": of.activation_hat.sel(muscle=muscle) for muscle in subject.muscles}
    columns |= {f"{joint}_dq_hat": of.velocity_hat.sel(joint=joint) for joint in subject.joints}
    for name, ours in columns.items():
        np.testing.assert_allclose(theirs[name], ours, rtol=0, atol=1e-9 * np.abs(ours).max(), err_msg=name)


def symbols_of(object_file: Path) -> dict[str, str]:
    """Name → letter, as nm has them; what the compiler names itself has a dot."""
    listed = subprocess.run(["nm", object_file], capture_output=True, text=True, check=True).stdout
    return {line.split()[-1]: line.split()[-2] for line in listed.splitlines() if "." not in line.split()[-1]}


@pytest.mark.skipif(shutil.which("nm") is None, reason="there is no nm")
def test_it_has_no_symbol_but_those_of_its_prefix_and_asks_for_mathematics_alone(tmp_path: Path) -> None:
    saved(tmp_path, "high_gain", scenario="paper-clean")
    subprocess.run([str(CC), *STRICT, "-O1", "-c", "high_gain.c"], cwd=tmp_path, check=True)
    found = symbols_of(tmp_path / "high_gain.o")
    asked = {name for name, letter in found.items() if letter == "U"}
    assert asked <= {"exp", "pow", "fmin", "fmax", "sqrt", "fabs"}
    assert all(name.startswith("hillobs_high_gain_") for name in found.keys() - asked)
    # nothing that could be written to
    assert not {name for name, letter in found.items() if letter.upper() in "BDC"}


def test_two_samples_that_are_no_numbers_are_left_out_by_a_caller(tmp_path: Path) -> None:
    saved(tmp_path, "high_gain", scenario="paper-clean")
    (tmp_path / "main.c").write_text(CALLER, encoding="utf-8")
    done = subprocess.run([built(tmp_path, "high_gain")], capture_output=True, text=True, check=True)
    assert done.stdout == "0 1 1 1 0\n"


# init on good numbers; a step on none, which changes neither state nor estimate; init on none; a step on good ones
CALLER = """
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "high_gain.h"
int main(void) {
    hillobs_high_gain_state state, kept;
    hillobs_high_gain_estimate estimate, before;
    const hillobs_high_gain_input good = {2.62, 0.1, 0.1};
    hillobs_high_gain_input bad = {2.62, 0.1, 0.1};
    int first = hillobs_high_gain_init(&state, &hillobs_high_gain_defaults, &good, &estimate), second, third, same;
    kept = state, before = estimate;
    bad.y2 = (double)NAN;
    second = hillobs_high_gain_step(&state, &hillobs_high_gain_defaults, &bad, &estimate);
    third = hillobs_high_gain_init(&state, &hillobs_high_gain_defaults, &bad, &estimate);
    same = !memcmp(&kept, &state, sizeof state) && !memcmp(&before, &estimate, sizeof estimate);
    printf("%d %d %d %d ", first, second, third, same);
    printf("%d\\n", hillobs_high_gain_step(&state, &hillobs_high_gain_defaults, &good, &estimate));
    return 0;
}
"""


def test_with_muscles_it_takes_and_tells_si_as_estimate_does(tmp_path: Path) -> None:
    recording, muscles = RECORDINGS / "dgf_smooth_noisy.csv.gz", RECORDINGS / "dgf_smooth.toml"
    told = estimate(recording, muscles, "high_gain")
    gains = json.loads(told.attrs["gains"])["high_gain"]
    steps = json.loads(told.attrs["substeps"])["high_gain"]
    period = float(told.attrs["period"])
    assert saved(tmp_path, "high_gain", period=period, muscles=muscles, changes=gains) == steps
    rows = np.column_stack([told.position, told.force])
    theirs = estimates(built(tmp_path, "high_gain"), "position,force_1,force_2", rows)
    apart = told.sel(observer="high_gain")
    for name, ours in (
        ("x2_hat", apart.velocity_hat),
        ("x4_hat", apart.tendon_length_hat.sel(muscle=2)),
        ("u1_hat", -apart.fibre_velocity_hat.sel(muscle=1)),
        ("a2_hat", apart.activation_hat.sel(muscle=2)),
    ):
        # times of the recording are decimal fractions, whose differences are the period to 1e-12 s
        np.testing.assert_allclose(theirs[name], ours, rtol=0, atol=1e-9 * np.abs(ours).max(), err_msg=name)


def test_the_page_beside_it_says_how_to_compile_what_it_names(tmp_path: Path) -> None:
    saved(tmp_path, "high_gain", scenario="paper-clean")
    page = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert set(re.findall(r"[\w.]+\.(?:[ch]|txt)\b", page)) == {
        "high_gain.h",
        "high_gain.c",
        "main.c",
        "CMakeLists.txt",
    }
    assert f"every {PERIOD:g}" in page
    assert "$" not in "".join(path.read_text(encoding="utf-8") for path in tmp_path.glob("*.[ch]"))


def test_the_program_refuses_a_table_that_is_none_in_a_sentence(tmp_path: Path) -> None:
    saved(tmp_path, "high_gain", scenario="paper-clean")
    program, good = built(tmp_path, "high_gain"), np.full((2, 3), 0.5)
    assert answered(program, "y1,y2", good[:, :2]).returncode == 2
    assert answered(program, "y1,y2,y3", good[:, :2]).returncode == 2
    wrong = answered(program, "y3,other,y1,y2", np.array([[0.1, np.nan, 2.62, 0.1], [np.nan, 0.0, 2.62, 0.1]]))
    assert (wrong.returncode, wrong.stderr) == (1, "line 3: the observer failed\n")
    assert wrong.stdout.count("\n") == 2
