// SPDX-License-Identifier: MIT
import { byId, element } from "../elements.js";
import { milliseconds, number, whole } from "../format.js";

const kSteps = 1000;
/** Cues that only a program that embeds the library can feed. */
const kOfHosts = new Set(["host", "attention"]);

const log = (least, most) => ({
  toShare: (value) => Math.log(value / least) / Math.log(most / least),
  toValue: (share) => Number((least * (most / least) ** share).toPrecision(3)),
});
const linear = (least, most, digits) => ({
  toShare: (value) => (value - least) / (most - least),
  toValue: (share) => Number((least + share * (most - least)).toFixed(digits)),
});

/** A labelled slider. Its value is what the run says; while a hand is on it, what the hand says. */
function slider({ id, label, title, scale, text, change }) {
  const input = element("input", { type: "range", id, min: "0", max: String(kSteps), step: "1", title: title ?? "" });
  const output = element("output", { for: id, id: `${id}-value` });
  let isHeld = false;
  input.addEventListener("pointerdown", () => (isHeld = true));
  for (const name of ["pointerup", "pointercancel", "blur"]) input.addEventListener(name, () => (isHeld = false));
  input.addEventListener("input", () => change(scale.toValue(Number(input.value) / kSteps)));
  return {
    row: element("div", { class: "slider", title: title ?? "" }, element("label", { for: id }, label), output, input),
    show(value) {
      output.textContent = text(value);
      input.setAttribute("aria-valuetext", text(value));
      if (!isHeld) input.value = String(Math.round(kSteps * Math.min(1, Math.max(0, scale.toShare(value)))));
    },
  };
}

/** How many bodies the slider reaches: a round number well above those of the start. */
const mostBodies = (status) => {
  const wanted = Math.max(200, 4 * Math.max(status.bodies, status.bodies_asked));
  const ten = 10 ** Math.floor(Math.log10(wanted));
  return Math.min(status.bodies_most, Math.ceil(wanted / ten) * ten);
};

/** The controls at the side, made when the first status comes. */
export function startControls({ status, send }) {
  const sliders = {
    deadline: slider({
      id: "deadline",
      label: "Deadline",
      title: "Time that each frame has",
      scale: log(0.2, 100),
      text: (value) => milliseconds(value),
      change: (ms) => send({ do: "deadline", ms }),
    }),
    bodies: slider({
      id: "bodies-wanted",
      label: "Bodies",
      title: "More are poured in, or the last are taken away",
      scale: linear(0, mostBodies(status), 0),
      text: (value) => whole(value),
      change: (count) => send({ do: "bodies", count }),
    }),
    alpha: slider({
      id: "alpha",
      label: "Share of late frames accepted",
      title: "alpha: a smaller share keeps a larger reserve before the deadline",
      scale: log(1e-5, 0.5),
      text: (value) => `${number(100 * value, 2)} %`,
      change: (value) => send({ do: "alpha", value }),
    }),
  };
  byId("sliders").replaceChildren(...Object.values(sliders).map(({ row }) => row));
  const policy = byId("policy");
  policy.replaceChildren(...status.policies.map((name) => element("option", { value: name }, name)));
  policy.addEventListener("change", () => send({ do: "policy", name: policy.value }));
  const weights = Object.entries(status.weights)
    .filter(([cue]) => !kOfHosts.has(cue))
    .map(([cue, { least, most }]) => [
      cue,
      slider({
        id: `weight-${cue}`,
        label: cue,
        scale: linear(least, Math.min(most, 4), 2),
        text: (value) => number(value),
        change: (value) => send({ do: "weight", cue, value }),
      }),
    ]);
  byId("weights").replaceChildren(...weights.map(([, { row }]) => row));
  return {
    show(now) {
      sliders.deadline.show(now.deadline_ms);
      sliders.bodies.show(now.bodies_asked);
      sliders.alpha.show(now.alpha);
      if (policy.value !== now.policy) policy.value = now.policy;
      for (const [cue, { show }] of weights) show(now.weights[cue].value);
      byId("weights-note").hidden = now.policy === "perceptual";
      const pause = byId("pause");
      pause.textContent = now.paused ? "Go on" : "Pause";
      pause.classList.toggle("on", now.paused);
    },
  };
}
