# SPDX-License-Identifier: MIT
"""Every example runs, with small sizes, and gives what it says."""
import os
import pathlib
import re
import subprocess
import sys

import pytest

import poise

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "python"
SMALL = {
    "stress.py": ["--scene", "jacks", "--most", "40", "--frames", "5"],
    "gaze.py": ["--frames", "60"],
    "plots.py": ["--bodies", "30", "--frames", "10"],
}


MODULE = {**os.environ, "PYTHONPATH": str(pathlib.Path(poise.__file__).absolute().parents[1])}


PAGE = (EXAMPLES.parents[1] / "docs" / "python.md").read_text()


def run(name, *arguments, folder=None):
    return subprocess.run([sys.executable, str(EXAMPLES / name), *arguments], capture_output=True, text=True, cwd=folder,
                          env=MODULE)


def test_every_example_is_run_here():
    assert {file.name for file in EXAMPLES.glob("*.py")} == set(SMALL)


@pytest.mark.parametrize("name", sorted(SMALL))
def test_example(name, tmp_path):
    done = run(name, *SMALL[name], folder=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.strip()
    if name == "plots.py" and "Matplotlib is not installed" not in done.stdout:
        assert (tmp_path / "plots.png").stat().st_size > 5000


def test_plots_say_so_where_matplotlib_is_missing(tmp_path):
    # A module of that name that is not there, before the one that is.
    (tmp_path / "matplotlib.py").write_text("raise ImportError('hidden by the test')\n")
    done = subprocess.run(
        [sys.executable, "-c", "import sys, runpy; sys.path.insert(0, %r); sys.argv = ['plots.py', '--bodies', '10', '--frames', '2'];"
         "runpy.run_path(%r, run_name='__main__')" % (str(tmp_path), str(EXAMPLES / "plots.py"))],
        capture_output=True, text=True, cwd=tmp_path, env=MODULE)
    assert done.returncode == 0, done.stderr
    assert "Matplotlib is not installed" in done.stdout and "python3-matplotlib" in done.stdout


@pytest.mark.parametrize("name", sorted(SMALL))
def test_wrong_options_are_refused(name):
    done = run(name, "--frames", "-1")
    assert done.returncode == 2 and "--frames" in done.stderr


def test_the_code_of_the_page_runs(capsys):
    first, cue, records = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    names = {"HERO": 7}
    exec(compile(first, "docs/python.md", "exec"), names)
    assert names["world"].state(names["ball"]).position_m[2] == pytest.approx(0.5, abs=0.02), "at rest on its plane"
    assert capsys.readouterr().out
    for block in (cue, records):
        exec(compile(block, "docs/python.md", "exec"), names)
    names["world"].step(poise.Budget.work(10))
    assert len(names["reports"]) == len(names["frames"]["frame"]) == 300
