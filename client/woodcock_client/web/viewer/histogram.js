// How often a layer has which numbers, and which of them the view shows.

import { number } from "../format.js";
import { html } from "../html.js";
import { exposureShown, isLogarithmic, mapOf, rangeShown } from "./appearance.js";
import { ticks } from "./legend.js";
import { histogramOf } from "./statistics.js";

const WIDTH = 280;
const HEIGHT = 72;
const STEPS = 140;

export function Histogram({ view, data }) {
  const toned = mapOf(view, data) === "none";
  const logarithmic = toned ? data.kind === "light" : isLogarithmic(view, data);
  const found = histogramOf(data, view.channel, logarithmic, STEPS);
  if (!found) return html`<p class="histogram">No numbers${logarithmic ? " above 0" : ""}</p>`;
  const { low, high, counts } = found;
  const of = logarithmic ? Math.log : (value) => value;
  const at = (value) => (WIDTH * (of(value) - of(low))) / (of(high) - of(low) || 1);
  const most = Math.max(...counts);
  const width = WIDTH / STEPS;
  // Roots: what is rare is seen, too.
  const tops = counts.map((count, index) => `V${(HEIGHT * (1 - Math.sqrt(count / most))).toFixed(1)}H${((index + 1) * width).toFixed(1)}`);
  const shown = toned ? [["white", 2 ** -exposureShown(view, data)]] : rangeShown(view, data).map((value, index) => [["from", "to"][index], value]);
  const inside = shown.filter(([, value]) => (value > 0 || !logarithmic) && value >= low && value <= high);
  return html`
    <figure class="histogram">
      <svg viewBox=${`0 -10 ${WIDTH} ${HEIGHT + 26}`} role="img" aria-label=${`Histogram from ${number(low)} to ${number(high)}${logarithmic ? ", logarithmic" : ""}`}>
        <path class="bars" d=${`M0 ${HEIGHT}${tops.join("")}V${HEIGHT}Z`} />
        ${(low < high ? ticks(low, high, logarithmic) : [low]).map((value) => html`
          <text key=${value} x=${Math.min(Math.max(at(value), 12), WIDTH - 12)} y=${HEIGHT + 13} text-anchor="middle">${number(value)}</text>
        `)}
        ${inside.map(([name, value]) => html`
          <g key=${name}>
            <line class="shown" x1=${at(value)} x2=${at(value)} y1="0" y2=${HEIGHT} />
            <text x=${Math.min(Math.max(at(value), 14), WIDTH - 14)} y="-2" text-anchor="middle">${name}</text>
          </g>
        `)}
      </svg>
    </figure>
  `;
}
