// SPDX-License-Identifier: MIT

/** An element with these attributes and children; text becomes text, never markup. */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== false && value !== undefined) made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

export const byId = (id) => document.getElementById(id);

/** The choices of a list, by value and text, and which is chosen. */
export function fillSelect(select, choices, chosen) {
  select.replaceChildren(...Object.entries(choices).map(([value, text]) => element("option", { value }, text)));
  select.value = chosen;
}
