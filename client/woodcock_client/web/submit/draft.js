// What is being written, kept for as long as the tab: a reload or a sign-in loses nothing.

import { useState } from "preact/hooks";
import { written } from "./written.js";

const KEY = "woodcock-draft";

const CUBE = {
  camera: { kind: "perspective", origin: [1.8, 1.4, 2.8], target: [0.5, 0.5, 0.5] },
  volumes: [
    { kind: "constant", shape: { kind: "box", min: [0, 0, 0], max: [1, 1, 1] }, sigma_t: 8, albedo: 0.98 },
  ],
  lights: [
    { kind: "constant", radiance: 0.2 },
    { kind: "directional", direction: [-1, -1, -0.4], irradiance: 4 },
  ],
  film: { width: 320, height: 240 },
  stop: { kind: "samples", samples: 64 },
};

// axes: what a sweep varies, as axes.js has it
export const START = { text: written(CUBE), name: "", tags: "", priority: "0", device: "any", pinned: false, axes: [] };

function kept() {
  try {
    return { ...START, ...JSON.parse(sessionStorage.getItem(KEY)) };
  } catch {
    return START; // storage is forbidden, or holds something else
  }
}

function keep(draft) {
  try {
    sessionStorage.setItem(KEY, JSON.stringify(draft));
  } catch {
    // the page does without
  }
}

// The draft, and a function that changes some of it.
export function useDraft() {
  const [draft, setDraft] = useState(kept);
  const change = (values) =>
    setDraft((before) => {
      const after = { ...before, ...values };
      keep(after);
      return after;
    });
  return [draft, change];
}

// What is sent to have it rendered; null while the text is not JSON.
export function requestOf({ text, name, tags, priority, device, pinned }) {
  try {
    const scene = JSON.parse(text);
    const words = tags.split(",").map((tag) => tag.trim());
    return { scene, name, tags: words.filter(Boolean), priority: Number(priority), device, pinned };
  } catch {
    return null;
  }
}
