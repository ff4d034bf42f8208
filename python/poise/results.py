# SPDX-License-Identifier: MIT
"""Results as tables: reports of steps, the JSON of `poise run`, CSV tables of frames, results of sweeps.

A table is a pandas.DataFrame where pandas is installed; elsewhere a dict of column names and NumPy arrays, in which
table["column"] works too. A value that is missing is NaN in a column of numbers, None in others.
"""
import csv
import json
import os
import sqlite3
from pathlib import Path
from typing import Any, Iterable, Mapping, Union

import numpy

from ._core import FrameReport
from ._errors import Error

try:
    import pandas
except ImportError:
    pandas = None

PathLike = Union[str, "os.PathLike[str]"]


def table(rows: "Iterable[Mapping[str, Any]]") -> Any:
    """A table of rows that are dicts: a pandas.DataFrame, or a dict of columns without pandas.

    The columns are those of all rows, in the order in which they first come.
    """
    rows = list(rows)
    names = list(dict.fromkeys(name for row in rows for name in row))
    return _table(names, [[row.get(name) for name in names] for row in rows])


# What is a text whatever it looks like: a hash of sixteen digits is no number, nor is a body that is named nan.
_TEXTS = frozenset(["trial", "scene", "state_hash", "commit", "policy", "state", "host", "engine", "processor",
                    "name", "shape", "file", "material", "motion"])


def _table(names: "list[str]", rows: "Iterable[Any]") -> Any:
    rows = list(rows)
    columns = {name: _column([row[i] for row in rows]) for i, name in enumerate(names)}
    return pandas.DataFrame(columns) if pandas is not None else columns


def frames_table(reports: "Iterable[FrameReport]") -> Any:
    """A table with a row for each FrameReport and the columns of `poise run --frames-csv`; times end in _ms."""
    return table(report.as_dict() for report in reports)


def read_run(path: PathLike) -> "dict[str, Any]":
    """The JSON of `poise run --json` (schema poise.run/2) as it is (docs/run-report.md).

    Raises Error for a file that is not one.
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as problem:
        raise Error("%s: %s" % (os.fspath(path), problem)) from problem
    schema = document.get("schema") if isinstance(document, dict) else None
    if not isinstance(schema, str) or not schema.startswith("poise.run/"):
        raise Error("%s: schema = %s, must be poise.run/2" % (os.fspath(path), schema))
    return document


def runs_table(runs: "PathLike | Iterable[PathLike | Mapping[str, Any]]") -> Any:
    """A table with a row for each run: paths of JSON files, or what read_run gave, or a folder that is searched for them.

    Columns are dotted paths, as --require has them: frame_ms.p99, misses.rate, levels.histogram.2. `file` comes first where
    a path was given. In a folder, JSON files of other schemas are left out.
    """
    if isinstance(runs, (str, os.PathLike)):
        folder = Path(runs)
        if folder.is_dir():
            return table(_row(file) for file in sorted(folder.rglob("*.json")) if _is_run(file))
        runs = [folder]
    return table(_row(run) for run in runs)


def read_table(path: PathLike) -> Any:
    """A CSV table: of frames (`poise run --frames-csv`), of states (`--states`), of a sweep. An empty cell is missing."""
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
    except (OSError, ValueError, csv.Error) as problem:
        raise Error("%s: %s" % (os.fspath(path), problem)) from problem
    if not rows:
        raise Error("%s: the file is empty, it must have a line of column names" % os.fspath(path))
    for name in rows[0]:
        if rows[0].count(name) > 1:
            raise Error('%s: line 1 has two columns "%s"' % (os.fspath(path), name))
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(rows[0]):
            raise Error("%s: line %d has %d cells, must have %d" % (os.fspath(path), number, len(row), len(rows[0])))
    names = rows[0]
    return _table(names, [[_cell(name, cell) for name, cell in zip(names, row)] for row in rows[1:]])


def read_sweep(path: PathLike, sql: str = "SELECT * FROM trials") -> Any:
    """A table of what `poise sweep` left: path is its folder of results, or a copy of the sweep.sqlite in it.

    By default a row for each trial, with the columns of trials.csv; `sql` may be any query of that database
    (docs/sweep.md), whose names with a dot are in quotes: SELECT bodies, avg("misses.rate") FROM trials GROUP BY bodies.
    Raises Error for a path without results and for a query that SQLite refuses. The file is only read.
    """
    file = Path(path)
    if file.is_dir():
        file = file / "sweep.sqlite"
    try:
        with open(file, "rb"):
            pass
        # Nobody writes into the file of a sweep: it is replaced by the next one.
        database = sqlite3.connect(file.absolute().as_uri() + "?mode=ro&immutable=1", uri=True)
        try:
            cursor = database.execute(sql)
            names = [name for name, *_ in cursor.description or ()]
            rows = cursor.fetchall()
        finally:
            database.close()
    except (OSError, sqlite3.Error, sqlite3.Warning) as problem:
        raise Error("%s: %s" % (os.fspath(file), problem)) from problem
    return _table(names, rows)


def _cell(name: str, text: str) -> Any:
    if text == "":
        return None
    # Python allows 1_000 in numbers; a table does not.
    if name in _TEXTS or "_" in text:
        return text
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return text


def _column(values: "list[Any]") -> Any:
    numbers = [value for value in values if isinstance(value, (int, float)) and not isinstance(value, bool)]
    missing = values.count(None)
    if values and len(numbers) + missing == len(values):
        whole = all(isinstance(value, int) for value in numbers)
        # Seeds have up to 64 bits, and a float would lose the last of them.
        exact = not whole or all(abs(value) <= 2**53 for value in numbers)
        if exact and (missing or not whole):
            return numpy.array([numpy.nan if value is None else value for value in values], dtype=float)
        for kind in (numpy.int64, numpy.uint64):
            limits = numpy.iinfo(kind)
            if whole and not missing and all(limits.min <= value <= limits.max for value in numbers):
                return numpy.array(values, dtype=kind)
    if values and all(isinstance(value, bool) for value in values):
        return numpy.array(values)
    column = numpy.empty(len(values), dtype=object)
    column[:] = values
    return column


def _flat(value: Any, name: str, row: "dict[str, Any]") -> None:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            _flat(inner, "%s.%s" % (name, key) if name else str(key), row)
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            _flat(inner, "%s.%d" % (name, index), row)
    else:
        row[name] = value


def _row(run: "PathLike | Mapping[str, Any]") -> "dict[str, Any]":
    row: "dict[str, Any]" = {}
    if not isinstance(run, Mapping):
        row["file"] = os.fspath(run)
        run = read_run(run)
    _flat(run, "", row)
    return row


def _is_run(path: Path) -> bool:
    try:
        read_run(path)
    except Error:
        return False
    return True
