# SPDX-License-Identifier: MIT
"""What the module needs of the Python that imports it, said in words before the compiled part fails for it."""
import importlib.machinery
import importlib.util
import pathlib
import sys


def _check() -> None:
    here = pathlib.Path(__file__).parent
    if not any((here / ("_core" + suffix)).exists() for suffix in importlib.machinery.EXTENSION_SUFFIXES):
        built = ", ".join(sorted(file.name for file in here.glob("_core.*.so"))) or "none"
        raise ImportError("poise is not built for %s, Python %d.%d (built: %s)"
                          % (sys.executable, sys.version_info[0], sys.version_info[1], built))
    if importlib.util.find_spec("numpy") is None:
        raise ImportError("poise needs NumPy, which %s has not; Debian's package is python3-numpy, for /usr/bin/python3"
                          % sys.executable)


_check()
