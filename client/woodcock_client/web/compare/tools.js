// How the pictures are looked at: which way, which of them, how bright, how large.

import { useEffect, useRef } from "preact/hooks";
import { title } from "../format.js";
import { html } from "../html.js";
import { CURVES } from "../viewer/curves.js";
import { onKey } from "../viewer/keys.js";
import { MAPS } from "./maps.js";

const MODES = {
  flip: { name: "Flip", key: "f" },
  split: { name: "Split", key: "s" },
  side: { name: "Side by side", key: "b" },
  map: { name: "Map", key: "m" },
};
const KEYS = [
  ["1 to 4", "show that picture; in a split or a map, hold it against the reference"],
  ["f, s, b, m", "flip, split, side by side, map"],
  ["e, E", "darker, brighter by half a stop"],
  ["← ↑ → ↓", "move the pictures, or the line between them where it has the focus"],
  ["+ −", "larger, smaller"],
  ["0", "all of it"],
  ["?", "these keys"],
];

// seen: the view as it is drawn; other: what is held against the reference; maps: those that there are of it, if that is
// known; channels, channel: of the map that is shown.
export function Tools({ jobs, state, other, change, view, seen, onView, maps, channels, channel }) {
  const keys = useRef();
  const commands = useRef();
  const brighter = (stops) => seen.exposure !== null && onView({ ...view, exposure: seen.exposure + stops });
  commands.current = {
    ...Object.fromEntries(jobs.map((_, place) => [place + 1, () => change({ shown: place })])),
    ...Object.fromEntries(Object.keys(MODES).map((mode) => [MODES[mode].key, () => change({ mode })])),
    e: () => brighter(-0.5),
    E: () => brighter(0.5),
    "?": () => keys.current.showModal(),
  };

  useEffect(() => {
    function press(event) {
      onKey(event, commands.current);
      if (event.defaultPrevented) event.stopPropagation(); // a digit means something else to a canvas alone
    }
    addEventListener("keydown", press, { capture: true });
    return () => removeEventListener("keydown", press, { capture: true });
  }, []);

  const { mode, shown, map } = state;
  return html`
    <div class="ways">
      <div class="group" role="group" aria-label="How to compare">
        ${Object.entries(MODES).map(([each, { name }]) => html`
          <button type="button" key=${each} aria-pressed=${String(each === mode)} onClick=${() => change({ mode: each })}>${name}</button>
        `)}
      </div>
      ${mode !== "side" && html`
        <div class="group" role="group" aria-label=${mode === "flip" ? "Which picture" : "Which picture against the reference"}>
          ${jobs.map((job, place) => mode !== "flip" && place === state.reference ? null : html`
            <button type="button" class="digit" key=${job.id} title=${title(job)} aria-label=${`${place + 1}, ${title(job)}`} aria-pressed=${String(place === (mode === "flip" ? shown : other))} onClick=${() => change({ shown: place })}>${place + 1}</button>
          `)}
        </div>
      `}
      ${mode === "map" && html`
        <label>Map
          <select aria-label="Map" value=${map} onChange=${(event) => change({ map: event.target.value })}>
            ${Object.entries(MAPS).map(([name, { name: label }]) => html`<option key=${name} value=${name} disabled=${maps ? !(name in maps) : false}>${label}</option>`)}
          </select>
        </label>
        ${channels.length > 1 && html`
          <label>Channel
            <select aria-label="Channel" value=${channel} onChange=${(event) => onView({ ...view, channel: event.target.value })}>
              ${!MAPS[map].part && html`<option value="">Luminance</option>`}
              ${channels.map((each) => html`<option key=${each} value=${each}>${CHANNELS[each]}</option>`)}
            </select>
          </label>
        `}
      `}
      ${mode !== "map" && html`
        <label class="exposure">Exposure
          <input
            type="range"
            min=${Math.min(-10, Math.floor(seen.exposure ?? 0))}
            max=${Math.max(10, Math.ceil(seen.exposure ?? 0))}
            step="0.1"
            value=${seen.exposure ?? 0}
            onInput=${(event) => onView({ ...view, exposure: Number(event.target.value) })}
          />
          <output>${stopsOf(seen.exposure ?? 0)}</output>
        </label>
        <label>Curve
          <select aria-label="Curve" value=${view.curve} onChange=${(event) => onView({ ...view, curve: event.target.value })}>
            ${Object.entries(CURVES).map(([name, curve]) => html`<option key=${name} value=${name}>${curve.name}</option>`)}
          </select>
        </label>
      `}
      <div class="group" role="group" aria-label="Size">
        <button type="button" onClick=${() => onView({ ...view, zoom: null, x: null, y: null })}>Fit</button>
        <button type="button" onClick=${() => onView({ ...view, zoom: 1 })}>1 : 1</button>
      </div>
      <button type="button" aria-label="Keys" title="Keys" onClick=${() => keys.current.showModal()}>?</button>
      <dialog ref=${keys} class="keys" aria-labelledby="keys-of-compare">
        <h2 id="keys-of-compare">Keys</h2>
        <dl>
          ${KEYS.map(([key, does]) => html`<div key=${key}><dt>${key}</dt><dd>${does}</dd></div>`)}
        </dl>
        <form method="dialog"><button>Close</button></form>
      </dialog>
    </div>
  `;
}

const CHANNELS = { R: "Red", G: "Green", B: "Blue" };

const stopsOf = (exposure) => `${exposure < 0 ? "−" : "+"}${Math.abs(exposure).toFixed(1)}`;
