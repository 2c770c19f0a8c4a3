"""Signals that come at a bad time wait."""

import os
import signal

from hillobs.codegen.system.signals import HeldSignals


def test_a_signal_while_a_process_starts_waits_for_it() -> None:
    """Once, at the release, and with the handler that was there."""
    came: list[int] = []
    before = signal.signal(signal.SIGHUP, lambda number, frame: came.append(number))
    try:
        held = HeldSignals()
        os.kill(os.getpid(), signal.SIGHUP)
        assert came == []
        held.release()
        assert came == [signal.SIGHUP]
        held.release()
        os.kill(os.getpid(), signal.SIGHUP)
        assert came == [signal.SIGHUP] * 2
    finally:
        signal.signal(signal.SIGHUP, before)
