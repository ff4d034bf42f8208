// SPDX-License-Identifier: MIT
import { byId } from "./elements.js";

/** Shortcuts of the whole page (the help lists them). */
export function startKeyboard({ store, player, replay, toggleTheme, wholeZoom }) {
  const help = byId("help");
  byId("help-button").addEventListener("click", () => help.showModal());
  const zoom = (factor) => wholeZoom?.zoom?.(factor);
  const keys = {
    " ": () => player.toggle(),
    ArrowLeft: (event) => player.step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => player.step(event.shiftKey ? 10 : 1),
    Home: () => player.goTo(0),
    End: () => player.goTo(player.last),
    n: () => player.toLate(1),
    p: () => player.toLate(-1),
    "[": () => player.changeSpeed(-1),
    "]": () => player.changeSpeed(1),
    "+": () => zoom(0.5),
    "=": () => zoom(0.5),
    "-": () => zoom(2),
    0: () => zoom(Infinity),
    c: () => replay?.next("color"),
    s: () => replay?.next("show"),
    v: () => replay?.switchCamera(),
    a: () => replay?.choose("camera", "all"),
    b: () => replay?.pickAtGaze(),
    k: () => replay?.toggle("show-contacts"),
    g: () => replay?.toggle("show-gaze"),
    f: () => replay?.toggle("show-frustum"),
    l: () => replay?.toggle("show-coarse"),
    t: () => toggleTheme(),
    "?": () => help.showModal(),
    Escape: () => replay?.closeFacts(),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
    // Elements keep the keys that they have a meaning for.
    const inSelect = event.target instanceof HTMLSelectElement;
    const isPress =
      event.key === " " && (event.target instanceof HTMLButtonElement || event.target?.type === "checkbox");
    if (inSelect || isPress) return;
    const action = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}
