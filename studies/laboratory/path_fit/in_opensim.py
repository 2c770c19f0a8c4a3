"""What OpenSim does of a fit, as a program of its own: its wheel carries another CasADi than ours.

Nothing of hillobs is imported here. In its folder it reads `request.json` and `points.npz`, and leaves `paths.xml`,
`samples.npz` and `answer.json`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

# OpenSim adds samples around each point, at least one, so far in degrees; most of them its own filter removes
_SPREAD, _SAMPLES = 0.5, 1
# as near, a point is the same in a file of twelve digits
_SAME = 9
# m: a muscle with less does not cross a coordinate; and an error that OpenSim need not go below
_LEAST_ARM, _TOLERANCE = 1e-4, 1e-6
# lines of an .sto file before its rows
_HEADER = "endheader"


def main() -> None:
    """Fit and sample, or say in the answer why not."""
    request = json.loads(Path("request.json").read_text(encoding="utf-8"))
    points = np.load("points.npz")
    try:
        answer = _answer(request, points)
    except Exception as error:  # whatever OpenSim throws is the answer; its first line says what
        answer = {"error": next(iter(str(error).splitlines()), type(error).__name__)}
    Path("answer.json").write_text(json.dumps(answer), encoding="utf-8")


def _answer(request: dict[str, Any], points: Any) -> dict[str, Any]:
    import opensim

    opensim.Logger.setLevelString("off")
    opensim.Logger.removeFileSink()
    model = _prepared(opensim, request)
    used = _fit(opensim, model, request, points["fit"])
    model = opensim.Model(model)
    state = model.initSystem()
    lengths, arms = _sampled(model, state, request, points["check"], with_arms=True)
    # along coordinates that no muscle crosses there is nothing to see
    crossed = np.abs(arms).max(axis=(0, 1)) > _LEAST_ARM
    seen = crossed[points["moving"]]
    lines = np.zeros((len(seen), lengths.shape[1]))
    lines[seen], _ = _sampled(model, state, request, points["lines"][seen], with_arms=False)
    np.savez("samples.npz", lengths=lengths, arms=arms, lines=lines)
    return {"used": used}


def _prepared(opensim: Any, request: dict[str, Any]) -> str:
    """The file of the model with the muscles that are fitted alone, and locked joints welded where they stay."""
    model = opensim.Model(request["model"])
    model.finalizeFromProperties()
    for name, value in request["values"].items():
        coordinate = model.updCoordinateSet().get(name)
        coordinate.setDefaultValue(value)
        coordinate.setDefaultLocked(False)
    forces = model.updForceSet()
    names = [forces.get(number).getName() for number in range(forces.getSize())]
    for number, name in reversed(list(enumerate(names))):
        if name not in request["muscles"]:
            forces.remove(number)
    model.printToXML("chosen.osim")
    joints = opensim.StdVectorString()
    for joint in request["welded"]:
        joints.append(joint)
    # a processed model keeps the values that it is read with
    processor = opensim.ModelProcessor("chosen.osim")
    processor.append(opensim.ModOpReplaceJointsWithWelds(joints))
    welded = processor.process()
    welded.initSystem()
    welded.printToXML("welded.osim")
    return "welded.osim"


def _fit(opensim: Any, model: str, request: dict[str, Any], points: Any) -> int:
    """Let OpenSim fit, into paths.xml; how many of the points it has used."""
    table = opensim.TimeSeriesTable()
    table.setColumnLabels([f"{column}/value" for column in request["columns"]])
    for number, row in enumerate(points):
        table.appendRow(number * 0.01, opensim.RowVector([float(value) for value in row]))
    table.addTableMetaDataString("inDegrees", "no")
    fitter = opensim.PolynomialPathFitter()
    fitter.setModel(opensim.ModelProcessor(model))
    fitter.setCoordinateValues(opensim.TableProcessor(table))
    fitter.setMinimumPolynomialOrder(request["order"])
    fitter.setMaximumPolynomialOrder(request["order"])
    fitter.setGlobalCoordinateSamplingBounds(opensim.Vec2(-_SPREAD, _SPREAD))
    fitter.setNumSamplesPerFrame(_SAMPLES)
    fitter.setMomentArmThreshold(_LEAST_ARM)
    fitter.setPathLengthTolerance(_TOLERANCE)
    fitter.setMomentArmTolerance(_TOLERANCE)
    fitter.setNumParallelThreads(1)  # with several the samples differ each time
    fitter.setUseStepwiseRegression(False)
    fitter.setIncludeMomentArmFunctions(False)
    fitter.setIncludeLengtheningSpeedFunction(False)
    Path("fitted").mkdir()
    fitter.setOutputDirectory("fitted")
    fitter.run()
    (found,) = Path("fitted").glob("*FunctionBasedPathSet.xml")
    found.replace("paths.xml")
    (samples,) = Path("fitted").glob("*coordinate_values_sampled.sto")
    lines = samples.read_text(encoding="utf-8").splitlines()
    # the names of the columns are a line too, and time a column
    rows = {tuple(np.round(row[1:], _SAME)) for row in np.loadtxt(lines[lines.index(_HEADER) + 2 :], ndmin=2)}
    return sum(tuple(np.round(point, _SAME)) in rows for point in points)


def _sampled(model: Any, state: Any, request: dict[str, Any], points: Any, with_arms: bool) -> tuple[Any, Any]:
    """Lengths (points × muscles), and moment arms (points × muscles × coordinates) or none."""
    coordinates = [model.getCoordinateSet().get(column.rpartition("/")[2]) for column in request["columns"]]
    muscles = [model.getMuscles().get(name) for name in request["muscles"]]
    lengths = np.empty((len(points), len(muscles)))
    arms = np.empty((len(points) * with_arms, len(muscles), len(coordinates)))
    for at, row in enumerate(points):
        for coordinate, value in zip(coordinates, row, strict=True):
            coordinate.setValue(state, float(value), False)
        model.realizePosition(state)
        for number, muscle in enumerate(muscles):
            lengths[at, number] = muscle.getPath().getLength(state)
            if with_arms:
                arms[at, number] = [muscle.computeMomentArm(state, coordinate) for coordinate in coordinates]
    return lengths, arms


if __name__ == "__main__":
    main()
