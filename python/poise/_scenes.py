# SPDX-License-Identifier: MIT
"""The scenes that ship with Poise."""
import os
from pathlib import Path

from . import _core
from ._errors import Error


def shipped_scenes() -> "dict[str, Path]":
    """The scene files that ship, by name: what SceneRun and `poise run` take without a path."""
    for folder in _core.scene_folders:
        files = sorted(Path(folder).glob("*.json"))
        if files:
            return {file.stem: file for file in files}
    return {}


def scene_path(scene: "str | os.PathLike[str]") -> Path:
    """The file that a scene means: a name without folder and ending is one that ships, everything else a path.

    Raises Error for a name that no shipped scene has.
    """
    text = os.fspath(scene)
    if "/" in text or "." in text:
        return Path(text)
    scenes = shipped_scenes()
    if text in scenes:
        return scenes[text]
    raise Error("scene = %s, must be a path or one of %s" % (text, ", ".join(scenes)))
