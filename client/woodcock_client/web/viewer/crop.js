// A part of the picture: what it holds on average, and a link to it.

import { useState } from "preact/hooks";
import { html } from "../html.js";
import { titleOf } from "./layers.js";
import { writeView } from "./view.js";
import { Line } from "./values.js";

const PARTS = [["x", "Left"], ["y", "Top"], ["width", "Width"], ["height", "Height"]];

// Half of the picture to each side, for whoever chooses without a pointer.
export function middleOf({ width, height }) {
  const side = (length) => Math.max(1, Math.round(length / 2));
  return { x: Math.floor((width - side(width)) / 2), y: Math.floor((height - side(height)) / 2), width: side(width), height: side(height) };
}

export const isInside = (crop, { width, height }) => crop.x + crop.width <= width && crop.y + crop.height <= height;

export function Crop({ view, onView, data, pixels }) {
  const { crop } = view;
  function change(name, value) {
    const next = { ...crop, [name]: value };
    if (Number.isInteger(value) && value >= (name === "x" || name === "y" ? 0 : 1) && isInside(next, data)) onView({ ...view, crop: next });
  }
  return html`
    <section class="crop" aria-label="Crop">
      ${PARTS.map(([name, label]) => html`
        <label key=${name}>${label} <input type="number" min=${name.length > 1 ? 1 : 0} value=${crop[name]} onChange=${(event) => change(name, event.target.valueAsNumber)} /></label>
      `)}
      <button type="button" onClick=${() => onView({ ...view, zoom: "crop", x: null, y: null, panorama: false })}>Zoom to it</button>
      <${CopyLink} view=${view} key=${JSON.stringify(crop)} />
      <button type="button" onClick=${() => onView({ ...view, crop: null, zoom: view.zoom === "crop" ? null : view.zoom })}>Clear</button>
      <p class="mean" role="status" title="Mean of the pixels ± √(sum of their variances) / their number">
        ${pixels ? html`Mean of ${titleOf(data.name)}: <${Line} pixels=${pixels} layer=${data.name} />` : "…"}
      </p>
      <p class="fact">Mean of the pixels, each counting the same, ± √(Σ variance) / number of pixels where variances are known.</p>
    </section>
  `;
}

function CopyLink({ view }) {
  const [state, setState] = useState("");
  const query = writeView({ ...view, zoom: "crop", x: null, y: null }, new URLSearchParams(location.search));
  const link = `${location.origin}${location.pathname}?${query}`;
  async function copy() {
    try {
      await navigator.clipboard.writeText(link);
      setState("copied");
    } catch {
      setState("shown"); // no clipboard without TLS, or none for this page
    }
  }
  return html`
    <button type="button" onClick=${copy}>Copy link</button>
    ${state === "copied" && html`<span class="fact" role="status">Copied</span>`}
    ${state === "shown" && html`<label>Link <input class="link" readonly value=${link} ref=${(input) => input?.select()} /></label>`}
  `;
}
