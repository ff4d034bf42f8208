// SPDX-License-Identifier: MIT
import { byId } from "./elements.js";

const kStored = "poise-theme";

/** What was chosen before; pages from disk may not be allowed to remember. */
function stored() {
  try {
    return localStorage.getItem(kStored);
  } catch {
    return null;
  }
}

/** Light or dark: as chosen, else as the system says. */
export function startTheme(store) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const button = byId("theme");
  const show = (theme) => {
    document.documentElement.dataset.theme = theme;
    button.textContent = theme === "dark" ? "☀ Light" : "☾ Dark";
    button.title = `Change to ${theme === "dark" ? "light" : "dark"} colours (T)`;
    store.set("theme", theme);
  };
  const toggle = () => {
    const theme = store.get("theme") === "dark" ? "light" : "dark";
    try {
      localStorage.setItem(kStored, theme);
    } catch {
      // It holds for this page alone.
    }
    show(theme);
  };
  show(stored() ?? (system.matches ? "dark" : "light"));
  system.addEventListener("change", () => {
    if (!stored()) show(system.matches ? "dark" : "light");
  });
  button.addEventListener("click", toggle);
  return toggle;
}
