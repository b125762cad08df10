// What the false colours mean: a bar from the smallest number to the largest, in units.

import { number } from "../format.js";
import { html } from "../html.js";
import { isLogarithmic, mapOf, rangeShown } from "./appearance.js";
import { gradientOf } from "./colours.js";
import { titleOf, unitOf } from "./layers.js";

const MOST_TICKS = 6;

export function Legend({ view, data }) {
  const map = mapOf(view, data);
  if (map === "none") return null;
  const [low, high] = rangeShown(view, data);
  const logarithmic = isLogarithmic(view, data);
  const part = data.channels.length > 1 ? view.channel || (data.kind === "vector" ? data.channels[0] : "luminance") : "";
  const what = `${titleOf(data.name)}${part && `, ${part}`}`;
  const unit = unitOf(data.unit);
  const share = (value) => (logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
  return html`
    <figure class="legend" aria-label=${`False colours of ${what}: from ${number(low)} to ${number(high)}${unit && ` ${unit}`}${logarithmic ? ", logarithmic" : ""}`}>
      <div class="ramp" style=${{ background: gradientOf(map, "to right") }}></div>
      <div class="ticks" aria-hidden="true">
        ${ticks(low, high, logarithmic).map((value) => html`<span key=${value} style=${at(share(value))}>${number(value)}</span>`)}
      </div>
      <figcaption>${what}${unit && html` <span class="fact">${unit}</span>`}</figcaption>
    </figure>
  `;
}

// A label at a share of the bar, within its ends.
const at = (share) => ({ left: `${100 * share}%`, transform: `translateX(${-100 * share}%)` });

// Round numbers from low to high.
export function ticks(low, high, logarithmic) {
  if (logarithmic) {
    const decades = Math.log10(high / low);
    const steps = decades > 2 ? [1] : decades > 1 ? [1, 3] : [1, 2, 5];
    const every = Math.ceil((decades * steps.length) / MOST_TICKS);
    const found = [];
    for (let decade = Math.floor(Math.log10(low)); decade <= Math.log10(high); decade++) {
      for (const step of steps) found.push(step * 10 ** decade);
    }
    return found.filter((value) => value >= low && value <= high).filter((_, index) => index % every === 0);
  }
  const rough = (high - low) / (MOST_TICKS - 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((each) => each * power >= rough) * power;
  const found = [];
  for (let index = Math.ceil(low / step); index * step <= high; index++) found.push(index * step);
  return found;
}
