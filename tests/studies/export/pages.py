"""A page's own scripts in node, where there is no browser: what it computes, beside what the studies do."""

import base64
import gzip
import json
import re
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from hillobs.codegen.batch import Trace, compile_loop
from hillobs.model.block import Block
from hillobs.model.symbols import hat
from hillobs.studies.scenarios.prepare import Prepared
from hillobs.studies.simulate.measures import SENTENCES, measures
from hillobs.studies.simulate.run import recorded
from tools import NODE

# another order of operations rounds otherwise; the least stable gains of the paper make 10⁴ times as much of it
CLOSE = 1e-9

# runs the study once for each set of changes, one after the other, and tells what charts and table would show
_RUNNER = """
const [study, kernel, language, asked] = JSON.parse(require("fs").readFileSync(0, "utf8"));
const bytes = Buffer.from(kernel, "base64");
let places, m, f;
if (language === "javascript") {
  places = placesOf(study, 1);
  m = new Float64Array(places.end);
  f = new Function("m", bytes.toString())(m);
} else {
  f = new WebAssembly.Instance(new WebAssembly.Module(bytes), { env: Math }).exports;
  places = placesOf(study, Math.ceil(f.__heap_base.value / 8));
  f.memory.grow(Math.ceil(8 * places.end / 65536));
  m = new Float64Array(f.memory.buffer);
}
const runner = runnerOf(study, f, m, places), settings = settingsOf(study);
const observers = Object.keys(study.observers), names = study.quantities.map(({ name }) => name);
const text = (x) => (x === x ? x : null);
process.stdout.write(JSON.stringify(asked.map(({ changes, seed, coarser }) => {
  settings.reset();
  for (const [path, number] of Object.entries(changes)) {
    const wrong = settings.set(path, number);
    if (wrong) throw Error(`${path} must be ${wrong}`);
  }
  const broken = runner.broken(settings.value);
  if (broken) return { broken };
  runner.run(settings.value, seed, coarser);
  return {
    truth: names.map((name) => Array.from(runner.truth(name), text)),
    estimates: observers.map((one) => names.map((name) => Array.from(runner.estimate(one, name), text))),
    measures: Object.keys(study.measures).map((which) =>
      observers.map((one) => names.map((_, i) => text(runner.measure(one, which, i))))),
    failures: { ...runner.failures },
  };
})));
"""


class Page:
    """What a page holds."""

    def __init__(self, path: Path) -> None:
        self.text = path.read_text(encoding="utf-8")
        self.study = json.loads(self.held("study"))
        self.language = re.search('id="kernel"[^>]*data-language="([a-z]*)"', self.text)[1]
        self.scripts = re.search('<script id="computing">(.*?)</script>', self.text, re.DOTALL)[1]

    def held(self, name: str) -> bytes:
        """What a script of the page holds, unpacked."""
        return gzip.decompress(base64.b64decode(re.search(f'<script id="{name}"[^>]*>([^<]*)<', self.text)[1]))

    def run(self, *asked: Mapping[str, object]) -> list[dict]:
        """What the page shows after each of several changes, one after the other, without being loaded again."""
        given = [self.study, base64.b64encode(self.held("kernel")).decode(), self.language, asked]
        command = [NODE, "-e", self.scripts + _RUNNER]
        done = subprocess.run(command, input=json.dumps(given), capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)


def asked(changes: Mapping[str, float], seed: int = 0, coarser: int = 1) -> Mapping[str, object]:
    return {"changes": changes, "seed": seed, "coarser": coarser}


def assert_shows(shown: Mapping[str, Sequence], prepared: Prepared) -> None:
    """It is what the studies compute, failures with their times too."""
    traces = recorded(prepared, compile_loop(prepared.loop), prepared.observers)
    blocks = {block.name: block for block in prepared.loop.blocks}
    hats = [hat(name) for name in prepared.quantities]
    assert_close(shown["truth"], [columns(traces["truth"], blocks["truth"], prepared.quantities)])
    assert_close(shown["estimates"], [columns(traces[name], blocks[name], hats) for name in prepared.observers])
    failures = {name: traces[name].failure for name in ("truth", *prepared.observers)}
    assert {name: failure and failure["time"] for name, failure in shown["failures"].items()} == {
        name: failure and pytest.approx(failure.time) for name, failure in failures.items()
    }
    grids = {name: prepared.grid.of(blocks[name]) for name in prepared.observers}
    errors = [measures(traces[name].score, grids[name], prepared.quantities) for name in prepared.observers]
    for measure, by_observer in zip(SENTENCES, shown["measures"], strict=True):
        rows = [[of[measure][quantity] for quantity in prepared.quantities] for of in errors]
        assert_close(by_observer, rows)


def columns(trace: Trace, block: Block, names: Sequence[str]) -> np.ndarray:
    return trace.y[:, [list(block.y).index(name) for name in names]].T


def assert_close(shown: Sequence, computed: Sequence) -> None:
    expected = np.array(computed)
    np.testing.assert_allclose(np.array(shown, dtype=float).reshape(expected.shape), expected, rtol=CLOSE, atol=CLOSE)
