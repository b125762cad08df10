// What is deleted is hidden at once, and deleted some seconds later, so that it can be undone: told at the foot of every
// page. Who leaves the gallery meanwhile has meant it.

import { useEffect, useReducer } from "preact/hooks";
import { html } from "./html.js";

const WAIT = 8000; // ms

export const gone = new Set(); // ids of jobs and batches that are hidden, for good once they are deleted

const listeners = new Set();
let pending = null;
let fault = null;
let timer;

function change(now) {
  pending = now;
  for (const listener of listeners) listener();
}

function hold() {
  clearTimeout(timer);
}

function run() {
  hold();
  if (pending) timer = setTimeout(carryOut, WAIT);
}

// Hides what bears the ids, until `send` has deleted it. said: what the reader is told; send: is given whether the page
// is being left, and resolves to why some stay, by id.
export function putOff({ said, ids, send }) {
  carryOut();
  fault = null;
  for (const id of ids) gone.add(id);
  change({ said, ids, send });
  run();
}

function restore(ids) {
  for (const id of ids) gone.delete(id);
}

function undo() {
  hold();
  restore(pending.ids);
  change(null);
}

async function carryOut(leaving = false) {
  if (!pending) return;
  const { ids, send } = pending;
  hold();
  change(null);
  try {
    const kept = Object.entries(await send(leaving));
    restore(kept.map(([id]) => id));
    if (kept.length > 0) fault = `${kept.length} of ${ids.length} could not be deleted. ${kept[0][1]}`;
  } catch (problem) {
    restore(ids);
    fault = `Nothing was deleted. ${problem.message}`;
  }
  change(pending);
}

addEventListener("pagehide", () => carryOut(true));

// Draws the component again whenever something is hidden or comes back.
export function useGone() {
  const [, redraw] = useReducer((n) => n + 1, 0);
  useEffect(() => {
    listeners.add(redraw);
    return () => listeners.delete(redraw);
  }, []);
}

export function Toast() {
  useGone();
  const dismiss = () => {
    fault = null;
    change(pending);
  };
  return html`
    <div class="toasts">
      <div role="status" onMouseEnter=${hold} onMouseLeave=${run} onFocusIn=${hold} onFocusOut=${run}>
        ${pending && html`<p class="toast">${pending.said} <button type="button" onClick=${undo}>Undo</button></p>`}
      </div>
      <div role="alert">
        ${fault && html`<p class="toast fault">${fault} <button type="button" onClick=${dismiss}>Close</button></p>`}
      </div>
    </div>
  `;
}
