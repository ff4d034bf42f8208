# SPDX-License-Identifier: MIT
"""How a policy fares against the shipped one and its rivals on a group of runs."""
import figures


def measure(runs, mine, base, rivals, seed, say):
    """The evidence of a group of runs: E_seen of the policy over that of the shipped one and of each rival, over all
    budgets and at each, with 95 % intervals. `mine` None: the shipped policy is measured itself."""
    base_seen = runs.ask(base)
    mine_seen = runs.ask(mine) if mine is not None else base_seen
    budgets = range(len(runs.runs[0].facts["budgets"]))
    against = [("shipped", base_seen)] if mine is not None else []
    for rival in rivals:
        against.append((rival, runs.ask(rival)))
        say(f"stepped by {rival}")
    means = figures.means_by_budget([mine_seen, *(seen for _, seen in against)])
    return {"runs": [{"scene": run.scene, "seed": run.seed, "bodies": run.facts["bodies"],
                      "states": run.facts["states"]} for run in runs.runs],
            "E_seen": means[0],
            "against": [{"policy": name, "E_seen": mean, **_over(figures.ratio(mine_seen, seen, seed)),
                         "by_budget": [_over(figures.ratio(mine_seen, seen, seed, [k])) for k in budgets]}
                        for (name, seen), mean in zip(against, means[1:])]}


def _over(figure):
    return figure if figure is not None else {"ratio": None, "low": None, "high": None}


def table(title, group, budgets, unit):
    """As Markdown: E_seen of the policy over that of the others."""
    sign = {"percent": " %", "ms": " ms"}.get(unit, "")
    lines = [f"{title}: {len(group['runs'])} runs", "",
             "| E_seen over that of | " + " | ".join(f"{b:g}{sign}" for b in budgets) + " | all budgets |",
             "|---" * (len(budgets) + 2) + "|"]
    for row in group["against"]:
        cells = [figures.shown(cell if cell["ratio"] is not None else None) for cell in (*row["by_budget"], row)]
        lines.append(f"| `{row['policy']}` | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"
