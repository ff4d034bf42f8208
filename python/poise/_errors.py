# SPDX-License-Identifier: MIT
"""The exception of the module."""
import re

# `pile.json: bodies[3].mass_kg = -1, must be > 0`: where (may be missing), field, value and rule.
_WITH_VALUE = re.compile(r"^(?:(?P<where>.*): )?(?P<field>[^:=]*[^:= ]) = (?P<value>.*?), (?P<rule>(?:must|each|the|this|it)\b.*)$",
                         re.DOTALL)
_WITHOUT_VALUE = re.compile(r"^(?:(?P<where>.*): )?(?P<field>[A-Za-z_][\w.\[\]]*)(?::|,) (?P<rule>[^:]*)$", re.DOTALL)


class Error(Exception):
    """A call was refused; nothing was changed. str() is the library's message: place, field, value and rule.

    Attributes:
        kind: 'bad_input', 'stale_handle' (a handle of something that was removed), 'output_failed', 'capacity_full' or
            'cancelled'.
        where: the file or place that the message begins with, or None.
        field: the argument or field that is wrong, e.g. 'bodies[3].mass_kg', or None where the message names none.
        value: its value as text, e.g. '-1', or None.
        rule: the rule that it breaks, e.g. 'must be > 0', or None.
    """

    kind: str
    where: "str | None"
    field: "str | None"
    value: "str | None"
    rule: "str | None"

    def __init__(self, message: str, kind: str = "bad_input") -> None:
        super().__init__(message)
        self.kind = kind
        parts = _WITH_VALUE.match(message) or _WITHOUT_VALUE.match(message)
        found = parts.groupdict() if parts else {}
        self.where = found.get("where")
        self.field = found.get("field")
        self.value = found.get("value")
        self.rule = found.get("rule")

    def __reduce__(self):
        return (type(self), (str(self), self.kind))


Error.__module__ = "poise"
