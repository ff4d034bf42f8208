// SPDX-License-Identifier: MIT

/**
 * What the parts of the page share: values by name, and who wants to know when one changes.
 * @param {Record<string, unknown>} initial
 */
export function createStore(initial) {
  const values = { ...initial };
  const listeners = new Map();
  return {
    get: (name) => values[name],
    /** Tells the listeners of this name, unless the value is what it was. */
    set(name, value) {
      if (Object.is(values[name], value)) return;
      values[name] = value;
      for (const listener of listeners.get(name) ?? []) listener(value);
    },
    on(name, listener) {
      if (!listeners.has(name)) listeners.set(name, []);
      listeners.get(name).push(listener);
    },
  };
}
