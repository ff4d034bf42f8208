// SPDX-License-Identifier: MIT
import { byId } from "../elements.js";

/** Shortcuts of the live page (the help lists them). */
export function startKeys({ pour, pause, step, again, toggleTheme, stage }) {
  const help = byId("help");
  byId("help-button").addEventListener("click", () => help.showModal());
  const keys = {
    " ": pause,
    ".": step,
    p: pour,
    r: again,
    c: () => stage()?.next?.("color"),
    s: () => stage()?.next?.("show"),
    v: () => stage()?.switchCamera?.(),
    a: () => stage()?.choose?.("camera", "all"),
    b: () => stage()?.pickAtGaze?.(),
    g: () => stage()?.toggle?.("show-gaze"),
    t: toggleTheme,
    "?": () => help.showModal(),
    Escape: () => stage()?.closeFacts?.(),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
    // Elements keep the keys that they have a meaning for.
    if (event.target instanceof HTMLSelectElement) return;
    const isButton = event.target instanceof HTMLButtonElement || event.target?.type === "checkbox";
    if (event.key === " " && isButton) return;
    const action = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
