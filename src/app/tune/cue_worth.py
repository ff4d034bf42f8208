# SPDX-License-Identifier: MIT
"""What each cue is worth: alone, and among the others."""
import fields
import figures

# Measured as cues are, though it is a parameter.
_LEARNING = "learning"


def _without_cues():
    return {"kind": "perceptual", **{cue: 0 for cue in fields.CUES}, _LEARNING: 0}


def measure(runs, base, seed, say):
    """A row for each cue: `alone` is E_seen with this cue only over that without any; `among` is E_seen of the base
    with the cue over the base without it. Below 1 the cue earns something."""
    shipped = {**fields.SHIPPED, **base}
    none = runs.ask(_without_cues())
    rows = []
    for cue in (*fields.CUES, _LEARNING):
        weight = shipped[cue] if shipped[cue] > 0 else 1
        alone = runs.ask({**_without_cues(), cue: weight})
        with_it = runs.ask({**base, cue: weight})
        without = runs.ask({**base, cue: 0})
        row = {"cue": cue, "weight": weight, "on": shipped[cue] > 0, "alone": figures.ratio(alone, none, seed),
               "among": figures.ratio(with_it, without, seed)}
        say(f"{cue}: alone {figures.shown(row['alone'])}, among the others {figures.shown(row['among'])}")
        rows.append(row)
    return rows


def conclusion(row):
    """What the interval among the others says."""
    among = row["among"]
    if among is None:
        return "-"
    if figures.too_few(among):
        return "too few states"
    if among["high"] < 1:
        return "earns"
    return "harms" if among["low"] > 1 else "not sure"


def table(rows):
    """As Markdown."""
    lines = ["| cue | weight | on | alone | among the others | |", "|---|---|---|---|---|---|"]
    for row in rows:
        lines.append(f"| `{row['cue']}` | {row['weight']:g} | {'yes' if row['on'] else 'no'} | "
                     f"{figures.shown(row['alone'])} | {figures.shown(row['among'])} | {conclusion(row)} |")
    return "\n".join(lines) + "\n"
