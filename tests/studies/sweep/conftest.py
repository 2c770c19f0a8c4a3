"""An unfinished sweep, and the result that it must come to."""

from pathlib import Path

import pytest

from unfinished_sweeps import PARTS, Sweep


@pytest.fixture(scope="session")
def untouched(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The result of a sweep that nothing disturbs."""
    here = Sweep(tmp_path_factory.mktemp("untouched"))
    here.run()
    assert sorted(here.computed) == list(range(PARTS))
    return here.out.read_bytes()


@pytest.fixture
def unfinished(tmp_path: Path) -> Sweep:
    """Parts 0, 1, 2 of five are kept."""
    here = Sweep(tmp_path)
    assert [path.name for path in here.start(3)] == ["00000000.part", "00000001.part", "00000002.part"]
    return here
