# SPDX-License-Identifier: MIT
"""The end of the interpreter: it waits for the steps that daemon threads are in, and lets none begin."""
import atexit
import time

from . import _core


@atexit.register
def _wait_for_steps() -> None:
    _core._close()
    while _core._running():
        time.sleep(0.001)
