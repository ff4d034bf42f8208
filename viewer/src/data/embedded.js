// SPDX-License-Identifier: MIT

/** Text of the script element with this id; empty where the page has none. */
const textOf = (id) => document.getElementById(id)?.textContent.trim() ?? "";

/** The bytes of base64 text. */
export function bytesOf(base64) {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let k = 0; k < binary.length; ++k) bytes[k] = binary.charCodeAt(k);
  return bytes;
}

/**
 * What the command wrote into the page; each part may be missing.
 * @returns {{run: any, frames: string, page: any, captures: Uint8Array[]}}
 */
export function readEmbedded() {
  const json = (id) => {
    const text = textOf(id);
    return text === "" ? null : JSON.parse(text);
  };
  const captures = ["poise-capture", "poise-capture-b"].map(textOf).filter((text) => text !== "");
  return {
    run: json("poise-run"),
    frames: textOf("poise-frames"),
    page: json("poise-page") ?? {},
    captures: captures.map(bytesOf),
  };
}
