# SPDX-License-Identifier: MIT
"""How a policy fares against others on a group of runs."""
import fields
import figures


def rivals_of(options, base, searched):
    """Names and policies that a policy is measured against: the base it was searched from if that is a file, the
    shipped policy, and --rivals. Nothing is measured against itself: without a search the policy is the base."""
    against = [("base", base)] if options.base and searched else []
    against += [("shipped", fields.SHIPPED_POLICY)] if options.base or searched else []
    return against + [(rival, rival) for rival in options.rivals]


def measure(runs, mine, others, seed, say):
    """The evidence of a group of runs: E_seen of the policy `mine` over that of each of `others` (rivals_of), over all
    budgets and at each, with 95 % intervals."""
    mine_seen = runs.ask(mine)
    budgets = range(len(runs.runs[0].facts["budgets"]))
    against = []
    for name, policy in others:
        against.append((name, runs.ask(policy)))
        say(f"stepped by {name}")
    means = figures.means_by_budget([mine_seen, *(seen for _, seen in against)])
    return {"runs": [{"scene": run.scene, "seed": run.seed, "bodies": run.facts["bodies"],
                      "states": run.facts["states"]} for run in runs.runs],
            "E_seen": means[0],
            "against": [{"policy": name, "E_seen": mean, **_over(figures.ratio(mine_seen, seen, seed)),
                         "by_budget": [_over(figures.ratio(mine_seen, seen, seed, [k])) for k in budgets]}
                        for (name, seen), mean in zip(against, means[1:])]}


def _over(figure):
    return figure if figure is not None else {"ratio": None, "low": None, "high": None, "states": 0}


def table(title, group, budgets, unit):
    """As Markdown: E_seen of the policy over that of the others."""
    sign = {"percent": " %", "ms": " ms"}.get(unit, "")
    lines = [f"{title}: {len(group['runs'])} runs", "",
             "| E_seen over that of | " + " | ".join(f"{b:g}{sign}" for b in budgets) + " | all budgets |",
             "|---" * (len(budgets) + 2) + "|"]
    for row in group["against"]:
        cells = [figures.shown(cell if cell["ratio"] is not None else None) for cell in (*row["by_budget"], row)]
        lines.append(f"| `{row['policy']}` | " + " | ".join(cells) + " |")
    if any(figures.too_few(row) for row in group["against"]):
        lines += ["", f"Too few states: fewer than {figures.LEAST_STATES} conclude nothing."]
    return "\n".join(lines) + "\n"
