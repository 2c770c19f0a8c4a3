"""The shipped recording and a hinge's estimated once, and a clean recording of two unlike muscles."""

from pathlib import Path

import pytest
import xarray as xr

import hillobs
from few_observers import few_observers
from hillobs.studies.estimate.run import estimate
from hillobs.studies.files.tables import Series, write_csv
from hillobs.studies.laboratory.muscles import read_muscles
from hillobs.studies.laboratory.recording import Recording, read_recording
from hillobs.studies.laboratory.scales import scales
from places import DATA
from shipped_recording import ALL_OBSERVERS, CHAINS, HINGE, MUSCLES, SHIPPED, UNLIKE_MUSCLES, part


@pytest.fixture(scope="session")
def noisy() -> xr.Dataset:
    return estimate(SHIPPED, MUSCLES, ALL_OBSERVERS)


@pytest.fixture(scope="session")
def hinge() -> xr.Dataset:
    return estimate(DATA / "hinge_pair_noisy.csv.gz", HINGE, CHAINS)


@pytest.fixture(scope="session")
def short() -> Recording:
    """The first 1.5 s of the shipped recording, without its truth."""
    return part(read_recording(SHIPPED), slice(0, 300))


@pytest.fixture(scope="session")
def unlike(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A recording at 1 kHz without noise of two unlike muscles with two curve sets, by our own plant."""
    folder = tmp_path_factory.mktemp("unlike")
    (folder / "muscles.toml").write_text(UNLIKE_MUSCLES)
    pair = read_muscles(folder / "muscles.toml")
    s = scales(pair)
    period = float(s.rate * 1e-3)
    changes = {f"muscle{j}.curves": getattr(pair, f"muscle{j}").curves.name for j in (1, 2)} | dict(s.numbers)
    changes |= {"initial.x1": 3.1, "initial.x3": 2.03, "initial.x4": 1.92, "uncertainty.offset": 0.02}
    changes |= {"uncertainty.amplitude": 0.08, "uncertainty.frequency": 0.3, "activation1.frequency": 0.35}
    changes |= {"activation2.frequency": 0.25, "noise.period": 0}
    changes |= {"duration": 3000 * period, "step": period / 2, "record": period}
    with few_observers("high_gain"):
        run = hillobs.simulate("paper-clean", observers=["high_gain"], changes={"plant.drive": "given", **changes})
    x, y = run.x, run.y.values
    write_csv(
        folder / "clean.csv",
        [
            Series("time", "s", run.time.values / s.rate),
            Series("position", "m", s.metres(y[:, 0])),
            *(Series(f"force_{j}", "N", y[:, j] * s.force) for j in (1, 2)),
            Series("velocity", "m/s", s.velocity(x.sel(state="x2").values)),
            Series("disturbance", "N", pair.mass * s.length * s.rate**2 * run.Delta.values),
            *(Series(f"tendon_length_{j}", "m", s.metres(x.sel(state=f"x{j + 2}").values)) for j in (1, 2)),
            *(Series(f"fibre_velocity_{j}", "m/s", s.fibre_velocity(run.u.sel(muscle=j).values)) for j in (1, 2)),
            *(Series(f"activation_{j}", "1", run.a.sel(muscle=j).values) for j in (1, 2)),
        ],
    )
    return folder / "clean.csv", folder / "muscles.toml"
