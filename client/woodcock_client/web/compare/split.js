// Two pictures in one place, parted by a line that the pointer or the arrow keys move.

import { useRef } from "preact/hooks";
import { html } from "../html.js";

const STEP = 0.02; // of the width, that a key moves the line by
const KEYS = { ArrowLeft: -STEP, ArrowDown: -STEP, ArrowRight: STEP, ArrowUp: STEP, PageDown: -0.1, PageUp: 0.1 };

const within = (at) => Math.min(Math.max(at, 0), 1);

// at: of the width, where the line is; names: of what is left and right of it
export function Split({ at, onAt, left, right, names }) {
  const line = useRef();
  const percent = `${100 * at}%`;

  function drag(event) {
    if (!line.current.hasPointerCapture(event.pointerId)) return;
    const box = line.current.parentElement.getBoundingClientRect();
    onAt(within((event.clientX - box.left) / box.width));
  }

  function press(event) {
    const ends = { Home: 0, End: 1 };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (KEYS[event.key]) onAt(within(at + KEYS[event.key]));
    else if (Object.hasOwn(ends, event.key)) onAt(ends[event.key]);
    else return;
    event.preventDefault();
  }

  return html`
    <div class="half">${left}</div>
    <div class="half" style=${{ clipPath: `inset(0 0 0 ${percent})` }}>${right}</div>
    <p class="caption">${names[0]}</p>
    <p class="caption right">${names[1]}</p>
    <div
      ref=${line}
      class="seam"
      role="slider"
      tabindex="0"
      aria-label="Where the pictures meet"
      aria-orientation="horizontal"
      aria-valuemin="0"
      aria-valuemax="100"
      aria-valuenow=${Math.round(100 * at)}
      aria-valuetext=${`${Math.round(100 * at)} % from the left`}
      style=${{ left: percent }}
      onPointerDown=${(event) => event.currentTarget.setPointerCapture(event.pointerId)}
      onPointerMove=${drag}
      onKeyDown=${press}
    ></div>
  `;
}
