"""Exported floats on a Cortex-M4 with its floating point unit, in an emulator."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from exported_programs import STRICT, assert_same, compiled, followed, recorded, saved
from hillobs.observers import OBSERVERS

GCC, QEMU = shutil.which("arm-none-eabi-gcc"), shutil.which("qemu-system-arm")
BOARD = Path(__file__).parent / "board"
CORE = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-Os", "-ffunction-sections"]
# of the emulator's clock, which counts 25 million a second while an instruction takes a nanosecond
INSTRUCTIONS_PER_TICK = 40
# bytes of stack and instructions that a step may take: half of a small board's memory, a tenth of its 0.5 ms at 168 MHz
MOST_STACK, MOST_INSTRUCTIONS = 4096, 84_000

pytestmark = [
    pytest.mark.chaos,
    pytest.mark.skipif(not (GCC and QEMU), reason="there are no arm-none-eabi-gcc and qemu-system-arm"),
]


@pytest.mark.parametrize("observer", OBSERVERS)
def test_a_board_estimates_what_the_follower_does(observer: str, tmp_path: Path) -> None:
    y = recorded("paper-noisy")
    y.astype("<f4").tofile(tmp_path / "samples.bin")
    steps = saved(tmp_path, observer, single=True, scenario="paper-noisy")
    own = [f'-DOBSERVER_H="{observer}.h"', f"-DOBSERVER(part)=hillobs_{observer}_##part", "-I."]
    board = [*CORE, "-nostartfiles", "-T", BOARD / "board.ld", "-Wl,--gc-sections", "--specs=nosys.specs"]
    machine = ["-M", "mps2-an386", "-cpu", "cortex-m4", "-icount", "shift=0", "-nographic", "-monitor", "none"]
    semihosting = ["-semihosting-config", "enable=on,target=native", "-serial", "none"]
    for command in (
        [GCC, *CORE, *STRICT, "-fno-math-errno", "-c", f"{observer}.c"],
        [GCC, *CORE, *own, "-c", BOARD / "board.c"],
        [GCC, *board, f"{observer}.o", "board.o", "-lm", "-lc", "-o", "board.elf"],
        [QEMU, *machine, *semihosting, "-kernel", "board.elf"],
    ):
        subprocess.run(command, cwd=tmp_path, check=True, timeout=600)
    ours = followed(compiled("paper-noisy", {}, True, "scalar"), observer, "paper-noisy", {}, y, steps)
    table = np.fromfile(tmp_path / "estimates.bin", "<f4").reshape(len(y), -1)
    assert_same(dict(zip(ours, table.T, strict=True)), ours, single=True)
    ticks, taken, stack = np.fromfile(tmp_path / "cost.bin", "<u4")
    print(f"{observer}: {ticks * INSTRUCTIONS_PER_TICK / taken:.0f} instructions a step, {stack} bytes of stack")
    assert taken == len(y) - 1
    assert ticks * INSTRUCTIONS_PER_TICK / taken < MOST_INSTRUCTIONS
    assert stack < MOST_STACK


def test_nothing_of_a_board_is_written_to_but_the_stack(tmp_path: Path) -> None:
    saved(tmp_path, "high_gain", single=True, scenario="paper-noisy")
    subprocess.run([GCC, *CORE, *STRICT, "-fno-math-errno", "-c", "high_gain.c"], cwd=tmp_path, check=True)
    sizes = subprocess.run(
        ["arm-none-eabi-size", "high_gain.o"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    _, data, bss, *_ = sizes.stdout.splitlines()[1].split()
    assert (data, bss) == ("0", "0")
