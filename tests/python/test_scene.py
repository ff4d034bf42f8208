# SPDX-License-Identifier: MIT
"""Scene files, the command, records, results."""
import json
import os
import subprocess
import sys

import numpy
import pytest

import poise
from poise import results

ARGUMENTS = ["--bodies", "50", "--frames", "40", "--clock", "work", "--budget-work", "150", "--quiet"]


def run_command(command, *arguments):
    subprocess.run([command, "run", "jacks", *ARGUMENTS, *arguments], check=True)


def as_dict(table):
    return {name: list(table[name]) for name in table}


def test_a_scene_gives_the_state_hash_and_the_figures_of_the_command(command, tmp_path):
    run_command(command, "--json", tmp_path / "run.json", "--frames-csv", tmp_path / "frames.csv")
    document = poise.read_run(tmp_path / "run.json")
    scene = poise.SceneRun("jacks", bodies=50, threads=1)
    reports = scene.run(40, poise.Budget.work(150))
    assert scene.world.state_hash() == document["state_hash"]
    ours, theirs = as_dict(poise.frames_table(reports)), as_dict(poise.read_table(tmp_path / "frames.csv"))
    assert set(theirs) - set(ours) == {"warm_up", "releases_skipped"}
    for name in ours:
        if not name.endswith("_ms") and name != "cut_margin":
            assert numpy.array_equal(ours[name], theirs[name]) or _all_missing(ours[name], theirs[name]), name


def _all_missing(a, b):
    return all(x is None or x != x for x in [*a, *b])


def test_a_record_is_done_again_bit_for_bit(command, tmp_path):
    record = tmp_path / "jacks.poise"
    run_command(command, "--record", record)
    replay = poise.Replay(record, threads=1)
    assert (replay.scene, replay.clock, replay.deadline_s) == ("jacks", "work", 0)
    reports = list(replay)
    assert len(reports) == replay.frames == 40 and replay.same and replay.whole and replay.damage is None
    scene = poise.SceneRun("jacks", bodies=50, threads=1)
    scene.run(40, poise.Budget.work(150))
    assert replay.world.state_hash() == scene.world.state_hash() and replay.step() is None
    content = record.read_bytes()
    record.write_bytes(content[:-40])
    short = poise.Replay(record)
    assert len(list(short)) > 0 and short.same and not short.whole and short.damage
    # A World that somebody else moved is not that of the record any more.
    record.write_bytes(content)
    moved = poise.Replay(record)
    moved.step()
    body = moved.world.bodies()[-1]
    moved.world.set_state(body, position_m=(0, 0, 50))
    assert len(list(moved)) == 1 and not moved.same and moved.first_difference == 1


def test_streams_come_and_the_camera_moves_as_the_scene_says(tmp_path):
    file = tmp_path / "small.json"
    file.write_text(json.dumps(SMALL))
    run = poise.SceneRun(file, threads=1)
    assert (run.name, run.dt_s, run.frames, run.deadline_s) == ("small", 0.01, 50, 0.02)
    before = len(run.bodies())
    seen = []
    reports = run.run(each=seen.append)
    assert reports == seen and len(reports) == run.frame == 50 and reports[-1].time_s == pytest.approx(0.5)
    assert len(run.bodies()) == before + 10 == len(run.world)
    assert [body.number for body in run.bodies()] == list(range(before + 10))
    assert {body.motion for body in run.bodies()} == {"static", "dynamic"}
    assert run.view.position_m == (0, -10, 3) and run.world.settings.gravity_mps2 == (0, 0, -9.81)
    assert run.step(poise.Budget.work(5)).frame == 50


SMALL = {
    "name": "small", "gravity_mps2": [0, 0, -9.81], "dt_s": 0.01, "frames": 50, "deadline_ms": 20,
    "camera": {"position_m": [0, -10, 3], "look_at_m": [0, 0, 1]},
    "materials": {"wood": {"restitution": 0.2, "friction": 0.5, "density_kgpm3": 500}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.2}}, "floor": {"plane": {"normal": [0, 0, 1]}}},
    "bodies": [{"shape": "floor", "material": "wood", "motion": "static"}],
    "generators": [{"stream": {"shapes": ["ball"], "material": "wood", "per_second": 25, "total": 10, "from_s": 0,
                               "region_min_m": [-1, -1, 1], "region_max_m": [1, 1, 2], "seed": 5}}],
}


def test_ctrl_c_ends_a_run_between_frames(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        "import os, signal, poise\n"
        "run = poise.SceneRun('two-body', threads=1)\n"
        "try:\n"
        "    run.run(1000000, each=lambda report: report.frame == 3 and os.kill(os.getpid(), signal.SIGINT))\n"
        "except KeyboardInterrupt:\n"
        "    print('stopped after', run.frame)\n")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "stopped after 4"


def test_shipped_scenes_are_found_by_name():
    scenes = poise.shipped_scenes()
    assert {"jacks", "pile", "metropolis"} <= set(scenes) and all(path.exists() for path in scenes.values())


def test_runs_of_a_folder_are_rows_with_dotted_columns(tmp_path):
    for number in range(3):
        (tmp_path / ("run%d.json" % number)).write_text(json.dumps(
            {"schema": "poise.run/2", "scene": "pile", "misses": {"rate": 0.1 * number}, "levels": {"histogram": [5, number]},
             "deadline_ms": None if number == 1 else 8}))
    (tmp_path / "other.json").write_text('{"schema": "poise.tree/2"}')
    (tmp_path / "broken.json").write_text("{")
    table = as_dict(poise.runs_table(tmp_path))
    assert table["misses.rate"] == [0, 0.1, 0.2] and table["levels.histogram.1"] == [0, 1, 2]
    assert [os.path.basename(file) for file in table["file"]] == ["run0.json", "run1.json", "run2.json"]
    assert table["deadline_ms"][0] == 8 and table["deadline_ms"][1] != table["deadline_ms"][1]
    with pytest.raises(poise.Error, match="poise.run/2"):
        poise.read_run(tmp_path / "other.json")
    with pytest.raises(poise.Error, match="broken.json"):
        poise.runs_table([tmp_path / "broken.json"])
    with pytest.raises(poise.Error, match="none.json"):
        poise.read_run(tmp_path / "none.json")
    (tmp_path / "deep.json").write_text("[" * 100000 + "]" * 100000)
    with pytest.raises(poise.Error, match="deep.json"):
        poise.read_run(tmp_path / "deep.json")


def test_tables_of_csv_files_have_numbers_words_and_gaps(tmp_path):
    file = tmp_path / "sweep.csv"
    file.write_text('scene,bodies,rate,note\r\njacks,100,0.5,\r\n"a, b",200,,x_1\r\n')
    table = as_dict(poise.read_table(file))
    assert table["scene"] == ["jacks", "a, b"] and table["bodies"] == [100, 200] and table["note"] == [None, "x_1"]
    assert table["rate"][0] == 0.5 and table["rate"][1] != table["rate"][1]
    file.write_text("a,b\n1,\n2,\n")
    assert all(value != value for value in as_dict(poise.read_table(file))["b"])
    file.write_text("name,state_hash,seed\nnan,0000000000000012,18446744073709551615\n1e5,00001234e5678901,9007199254740993\n")
    table = as_dict(poise.read_table(file))
    assert table["name"] == ["nan", "1e5"] and table["state_hash"] == ["0000000000000012", "00001234e5678901"]
    assert table["seed"] == [18446744073709551615, 9007199254740993], "to the last bit"
    file.write_text("seed\n9007199254740993\n\"\"\n")
    assert as_dict(poise.read_table(file))["seed"] == [9007199254740993, None]
    file.write_text("a,a\n1,2\n")
    with pytest.raises(poise.Error, match='line 1 has two columns "a"'):
        poise.read_table(file)
    file.write_bytes(b"\xff\xfe,a\n1,2\n")
    with pytest.raises(poise.Error, match="sweep.csv"):
        poise.read_table(file)
    file.write_text("a,b\n1\n")
    with pytest.raises(poise.Error, match="line 2 has 1 cells, must have 2"):
        poise.read_table(file)
    file.write_text("")
    with pytest.raises(poise.Error, match="empty"):
        poise.read_table(file)


def test_a_sweep_is_read_from_its_folder_its_database_and_by_a_query(command, tmp_path):
    spec = {"schema": "poise.sweep/1", "scenes": ["gas"], "settings": {"frames": 5, "clock": "work", "threads": 1},
            "axes": {"bodies": [20, 30]}, "seeds": [1, 2]}
    (tmp_path / "spec.json").write_text(json.dumps(spec))
    folder = tmp_path / "results of a sweep?"  # what a URI would take for its end
    subprocess.run([command, "sweep", tmp_path / "spec.json", "--out", folder, "--quiet"], check=True)
    ours, csv = as_dict(poise.read_sweep(folder)), as_dict(poise.read_table(folder / "trials.csv"))
    assert list(ours) == list(csv) and ours["bodies"] == [20, 20, 30, 30] and ours["state"] == ["done"] * 4
    assert ours["state_hash"] == csv["state_hash"] and ours["run.bodies"] == csv["run.bodies"]
    query = 'SELECT bodies, count(*) AS trials, avg("run.bodies") AS mean FROM trials GROUP BY bodies'
    rows = as_dict(poise.read_sweep(folder / "sweep.sqlite", query))
    assert rows["bodies"] == [20, 30] and rows["trials"] == [2, 2] and rows["mean"] == csv["run.bodies"][::2]
    assert list(as_dict(poise.read_sweep(folder, "SELECT bodies FROM trials WHERE bodies > 50"))) == ["bodies"]
    for path, sql, message in [(tmp_path, "SELECT * FROM trials", "sweep.sqlite"), (tmp_path / "spec.json", "SELECT 1 FROM trials", "not a database"),
                               (folder, "SELECT speed FROM trials", "no such column: speed"), (folder, "DELETE FROM trials", "readonly")]:
        with pytest.raises(poise.Error, match=message):
            poise.read_sweep(path, sql)


def test_without_pandas_a_table_is_a_dict_of_arrays(monkeypatch):
    rows = [{"a": 1, "b": "x"}, {"a": 2, "c": True}]
    if results.pandas is not None:
        frame = results.table(rows)
        assert isinstance(frame, results.pandas.DataFrame) and list(frame.columns) == ["a", "b", "c"]
        assert frame["a"].dtype.kind == "i" and len(frame) == 2
    monkeypatch.setattr(results, "pandas", None)
    columns = results.table(rows)
    assert type(columns) is dict and columns["a"].dtype.kind == "i" and list(columns["b"]) == ["x", None]
    assert results.table([]) == {}
