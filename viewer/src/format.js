// SPDX-License-Identifier: MIT

/** A number with at most `digits` significant digits; large ones whole. Anything but a number gives an en dash. */
export function number(value, digits = 3) {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 10 ** digits) return Math.round(value).toLocaleString("en-US");
  if (size < 1e-4) return value.toExponential(Math.max(0, digits - 1));
  return String(Number(value.toPrecision(digits)));
}

export const whole = (value) => (Number.isFinite(value) ? Math.round(value).toLocaleString("en-US") : "–");

/** A share of 1 as per cent. */
export const percent = (share, digits = 2) =>
  typeof share === "number" && Number.isFinite(share) ? `${number(100 * share, digits)} %` : "–";

export const milliseconds = (value, digits = 3) => `${number(value, digits)} ms`;

/** "1 frame", "2 frames". */
export const counted = (count, noun) => `${whole(count)} ${noun}${count === 1 ? "" : "s"}`;
