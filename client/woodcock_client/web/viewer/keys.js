// The viewer's keys.

import { useEffect, useRef } from "preact/hooks";
import { html } from "../html.js";

const KEYS = [
  ["← ↑ → ↓", "move the picture, faster with Shift"],
  ["+ −", "larger, smaller"],
  ["0, 1", "all of it; pixel for pixel"],
  ["e, E", "darker, brighter by half a stop"],
  ["l, L", "next layer, the one before"],
  ["c", "next tone curve"],
  ["f", "false colour"],
  ["h", "histogram"],
  ["v", "values of every layer"],
  ["n", "highlight what is no finite number"],
  ["p", "panorama or flat, of spherical pictures"],
  ["?", "these keys"],
];
const POINTERS = [
  ["Drag, wheel, pinch", "move, larger and smaller"],
  ["Shift and drag", "choose a crop"],
];

export const KEYS_ID = "viewer-keys";

// What a screen reader says of the canvas.
export const Spoken = () => html`<p id=${KEYS_ID} class="spoken">Keys: ${KEYS.map(([keys, what]) => `${keys}: ${what}`).join("; ")}.</p>`;

export function Keys({ open, onClose }) {
  const dialog = useRef();
  useEffect(() => {
    if (open && !dialog.current.open) dialog.current.showModal();
    if (!open && dialog.current.open) dialog.current.close();
  }, [open]);
  return html`
    <dialog class="keys" ref=${dialog} aria-label="Keys of the viewer" onClose=${onClose}>
      <h2>Keys</h2>
      <dl>${[...KEYS, ...POINTERS].map(([keys, what]) => html`<div key=${keys}><dt>${keys}</dt><dd>${what}</dd></div>`)}</dl>
      <button type="button" onClick=${onClose}>Close</button>
    </dialog>
  `;
}

// Calls what a key stands for, unless it is typed into something.
export function onKey(event, commands) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const { tagName, type } = event.target;
  if (tagName === "SELECT" || (tagName === "INPUT" && !["range", "checkbox"].includes(type)) || event.target.closest("dialog")) return;
  const command = commands[event.key];
  if (!command) return;
  event.preventDefault();
  command();
}
