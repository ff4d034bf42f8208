#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The figures of a study from the table that docs/ shows of it, as `poise study draw` takes them, so that a picture can
be drawn again without a measurement: docs/table_figures.py NAME > NAME.json"""
import json
import pathlib
import re
import sys

DOCS = pathlib.Path(__file__).parent


def unique(names):
    """Names of columns; one that comes again has its number behind it, from 2 on."""
    return [name if names[:i].count(name) == 0 else f"{name} {names[: i + 1].count(name)}" for i, name in enumerate(names)]


def tables_of(page, after):
    """Rows of the tables behind a line that begins so, as dictionaries by column."""
    text = (DOCS / page).read_text(encoding="utf-8")
    text = text[text.index("\n" + after) :]
    for block in re.findall(r"(?:^\|.*\n)+", text, re.M):
        rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in block.splitlines()]
        yield [dict(zip(unique(rows[0]), row)) for row in rows[2:]]


def table(page, after, column):
    return next(rows for rows in tables_of(page, after) if column in rows[0])


def number(text):
    found = re.match(r"-?[\d.]+", text.replace(",", ""))
    return float(found.group()) if found else None


def points(rows, x, y, low_high=None):
    made = []
    for row in rows:
        point = [number(row[x]), number(row[y])]
        if low_high:
            point += [number(row[name]) for name in low_high]
        if point[1] is not None:
            made.append(point)
    return sorted(made)


def line(label, values, marks="both"):
    return {"label": label, "marks": marks, "points": values}


def chart(id_, title, x_label, lines, levels=(), x_log=False, y_log=False, y_from_data=False, x_names=()):
    return {
        "id": id_, "title": title, "note": "", "x_label": x_label, "x_log": x_log, "y_log": y_log,
        "x_measured": False, "y_from_data": y_from_data, "x_names": list(x_names), "lines": lines,
        "levels": [{"label": label, "y": y, "line": of} for label, y, of in levels],
    }  # fmt: skip


def compliance():
    rows = table("deadlines.md", "## Compliance", "x served")
    alphas = list(dict.fromkeys(row["alpha"] for row in rows))
    lines, levels = [], []
    for i, alpha in enumerate(alphas):
        of_alpha = [row for row in rows if row["alpha"] == alpha]
        values = points(of_alpha, "x served", "forecast + overrun %", ("95 % from", "to"))
        allowed = 100 * number(alpha)
        lines.append(line(f"alpha = {allowed:g} %", values))
        levels.append((f"allowed: {allowed:g} %", allowed, i))
    title = "misses by forecast or overrun, %"
    return 1, [chart("misses", title, "bodies, in multiples of what full refinement serves", lines, levels, x_log=True)]


def constant_time():
    rows = table("deadlines.md", "## Near-constant time", "mean level")
    under = points(rows, "bodies", "p99 ms")
    full = points(rows, "bodies", "p99 ms 2")
    level = points(rows, "bodies", "mean level")
    times = chart("frame-time", "99 of 100 frames take at most, ms", "bodies",
                  [line("under the deadline", under), line("without", full)], [("deadline", 16, None)],
                  x_log=True, y_log=True)  # fmt: skip
    levels = chart("levels", "mean level under the deadline", "bodies", [line("mean level", level)], x_log=True)
    return 2, [times, levels]


def population():
    rows = table("deadlines.md", "## Population", "islands wait")
    times, levels = [], []
    for wait, name in (("yes", "islands may wait"), ("no", "every body in every frame")):
        of_wait = [row for row in rows if row["islands wait"] == wait]
        times.append(line(name, points(of_wait, "bodies", "p99 ms")))
        levels.append(line(name, points(of_wait, "bodies", "level in the last third")))
    first = chart("frame-time", "99 of 100 frames take at most, ms", "bodies", times, [("deadline", 16, None)],
                  x_log=True, y_log=True)  # fmt: skip
    return 2, [first, chart("levels", "mean level in the last third", "bodies", levels, x_log=True)]


def overload():
    rows = table("deadlines.md", "## Overload", "level up")
    charts = []
    for drive in dict.fromkeys(row["driven"] for row in rows):
        of_drive = [row for row in rows if row["driven"] == drive]
        for name, title, up, back in (
            ("level", "mean level", "level up", "back"),
            ("potential", "potential energy / without a limit", "height up", "back 5"),
        ):
            lines = [line("demand goes up", points(of_drive, "demand", up)), line("and back", points(of_drive, "demand", back))]
            charts.append(chart(f"{drive}-{name}", f"{drive} driven: {title}", "demand", lines, x_log=True,
                                y_from_data=name == "potential"))  # fmt: skip
    return 2, charts


def levels():
    rows = table("levels.md", "Means over the pairs of a group", "to reach")
    pairs = table("levels.md", "Mean error of dv as a share", "oracle 1, 3 mm")
    places = list(dict.fromkeys(row["level"] for row in rows))
    charts = []
    for group in dict.fromkeys(row["group"] for row in rows):
        of_group = [row for row in rows if row["group"] == group]
        models = list(dict.fromkeys(row["model"] for row in of_group))
        values = lambda model, column: [
            [places.index(row["level"]), max(number(row[column]), 0.001)]
            for row in of_group
            if row["model"] == model and number(row[column]) is not None
        ]
        lines = [line(model, values(model, "dv mean")) for model in models]
        targets = values(models[0], "to reach")
        if targets:
            lines.append(line("to reach", targets, "dots"))
        measured = [number(row["oracle 1, 3 mm"]) for row in pairs if row["group"] == group]
        oracle = max(sum(measured) / len(measured), 0.001)
        count = len({row["pair"] for row in pairs if row["group"] == group})
        charts.append(chart(group, f"{group}, {count} pairs of shapes: mean error of dv", "level", lines,
                            [("oracle, 1 mm", oracle, None)], y_log=True,
                            x_names=[place.removeprefix("L") for place in places]))  # fmt: skip
    return 2, charts


STUDIES = {"compliance": compliance, "constant-time": constant_time, "levels": levels, "overload": overload, "population": population}

if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in STUDIES:
        sys.exit(f"docs/table_figures.py: one of {' '.join(STUDIES)}")
    columns, charts = STUDIES[sys.argv[1]]()
    json.dump({"study": sys.argv[1], "drawing": {"columns": columns, "charts": charts}}, sys.stdout, indent=1)
    print()
