// The viewer's controls.

import { count } from "../format.js";
import { html } from "../html.js";
import { exposureShown, isLogarithmic, mapOf, rangeShown } from "./appearance.js";
import { MAPS } from "./colours.js";
import { CURVES } from "./curves.js";
import { titleOf } from "./layers.js";
import { fitted, oneToOne, place, zoomed } from "./placement.js";
import { badOf } from "./statistics.js";

const REACH = 8; // stops that the slider goes to either side

// The view of another layer: what was chosen for the numbers of the one before does not fit it.
export const withLayer = (view, layer) => ({ ...view, layer, channel: "", exposure: null, map: null, log: null, range: null });

// The view in a curve, or in false colour.
export const shownAs = (view, data, name) => {
  if (name in CURVES) return { ...view, curve: name, map: "none" };
  return { ...view, map: name };
};

// From the inside of a panorama to its outside, and back.
export const turned = (view) => ({ ...view, panorama: !view.inside, zoom: view.zoom === "crop" ? null : view.zoom });

export const inFalseColour = (view, data) => mapOf(view, data) !== "none";

export function Tools({ view, onView, data, list, size, spherical, onCrop, onKeys }) {
  const change = (part) => onView({ ...view, ...part });
  return html`
    <div class="tools" role="group" aria-label="View">
      <label>Layer
        <select value=${data.name} onChange=${(event) => onView(withLayer(view, event.target.value))}>
          ${list.layers.map(({ name }) => html`<option key=${name} value=${name}>${titleOf(name)}</option>`)}
        </select>
      </label>
      ${data.channels.length > 1 && html`
        <label>Channel
          <select value=${view.channel} onChange=${(event) => onView(withChannel(view, event.target.value))}>
            <option value="">${inFalseColour(view, data) && data.kind !== "vector" ? "Luminance" : "All"}</option>
            ${data.channels.map((channel) => html`<option key=${channel} value=${channel}>${channel}</option>`)}
          </select>
        </label>
      `}
      <label>Shown as <${ShownAs} view=${view} onView=${onView} data=${data} /></label>
      ${inFalseColour(view, data)
        ? html`<${Range} view=${view} change=${change} data=${data} />`
        : data.kind !== "vector" && html`<${Exposure} view=${view} change=${change} data=${data} />`}
      <${Zoom} view=${view} onView=${onView} data=${data} size=${size} />
      <div class="toggles">
        ${spherical && html`<${Toggle} on=${view.inside} onClick=${() => onView(turned(view))}>Panorama<//>`}
        <${Toggle} on=${view.histogram} onClick=${() => change({ histogram: !view.histogram })}>Histogram<//>
        <${Toggle} on=${view.values} onClick=${() => change({ values: !view.values })}>Values<//>
        <${Bad} view=${view} change=${change} data=${data} />
        <${Toggle} on=${view.crop !== null} onClick=${onCrop}>Crop<//>
        <button type="button" onClick=${onKeys} aria-label="Keys" title="Keys">?</button>
      </div>
    </div>
  `;
}

const Toggle = ({ on, onClick, title, children }) => html`
  <button type="button" aria-pressed=${String(on)} title=${title} onClick=${onClick}>${children}</button>
`;

const withChannel = (view, channel) => ({ ...view, channel, range: null, map: view.map === "none" ? null : view.map });

const ShownAs = ({ view, onView, data }) => html`
  <select value=${inFalseColour(view, data) ? mapOf(view, data) : data.kind === "vector" ? "none" : view.curve} onChange=${(event) => onView(shownAs(view, data, event.target.value))}>
    ${data.kind === "vector"
      ? html`<option value="none">Parts as colours</option>`
      : html`<optgroup label="Tones">${Object.entries(CURVES).map(([key, { name, formula }]) => html`<option key=${key} value=${key} title=${formula}>${name}</option>`)}</optgroup>`}
    <optgroup label="False colour">${Object.entries(MAPS).map(([key, { name }]) => html`<option key=${key} value=${key}>${name}</option>`)}</optgroup>
  </select>
`;

function Exposure({ view, change, data }) {
  const automatic = exposureShown({ ...view, exposure: null }, data);
  const stops = exposureShown(view, data) - automatic;
  const said = view.exposure === null ? "auto" : `${stops >= 0 ? "+" : "−"}${Math.abs(stops).toFixed(1)} stops`;
  return html`
    <div class="part">
      <label>Exposure
        <input type="range" min=${-REACH} max=${REACH} step="0.1" value=${stops} aria-valuetext=${said}
          onInput=${(event) => change({ exposure: automatic + event.target.valueAsNumber })} />
      </label>
      <output>${said}</output>
      <button type="button" disabled=${view.exposure === null} onClick=${() => change({ exposure: null })}>Auto</button>
    </div>
  `;
}

function Range({ view, change, data }) {
  const range = rangeShown(view, data);
  const logarithmic = isLogarithmic(view, data);
  const brief = (value) => Number(value.toPrecision(4));
  function set(index, value) {
    const next = range.map((each, other) => (other === index ? value : each));
    if (Number.isFinite(value) && next[0] < next[1] && (!logarithmic || next[0] > 0)) change({ range: next });
  }
  return html`
    <div class="part">
      ${["From", "to"].map((label, index) => html`
        <label key=${label}>${label} <input type="number" step="any" value=${brief(range[index])} onChange=${(event) => set(index, event.target.valueAsNumber)} /></label>
      `)}
      <button type="button" disabled=${view.range === null} onClick=${() => change({ range: null })}>Auto</button>
      <label class="check"><input type="checkbox" checked=${logarithmic} onChange=${() => change({ log: !logarithmic, range: null })} /> Log</label>
    </div>
  `;
}

function Zoom({ view, onView, data, size }) {
  if (!size) return null;
  const placed = place(view, data, size);
  const by = (factor) => () => onView(zoomed(view, data, size, factor));
  const said = placed.panorama ? `${Math.round((view.fov * 180) / Math.PI)}°` : `${percent(placed.zoom)} %`;
  return html`
    <div class="part" role="group" aria-label="Zoom">
      <button type="button" aria-label="Smaller" onClick=${by(Math.SQRT1_2)}>−</button>
      <output class="zoom">${said}</output>
      <button type="button" aria-label="Larger" onClick=${by(Math.SQRT2)}>+</button>
      <button type="button" onClick=${() => onView(fitted(view))}>Fit</button>
      <button type="button" disabled=${placed.panorama} onClick=${() => onView(oneToOne(view, data, size))}>1:1</button>
    </div>
  `;
}

const percent = (zoom) => (zoom >= 0.1 ? Math.round(100 * zoom) : (100 * zoom).toFixed(1));

// How many pixels are no numbers; whether they are seen.
function Bad({ view, change, data }) {
  const bad = badOf(data);
  return html`
    <${Toggle} on=${view.flag} title="NaN magenta, infinities cyan" onClick=${() => change({ flag: !view.flag })}>
      NaN/Inf <span class=${bad ? "bad" : "fact"}>${bad ? `${count(bad)} pixel${bad === 1 ? "" : "s"}` : "none"}</span>
    <//>
  `;
}
