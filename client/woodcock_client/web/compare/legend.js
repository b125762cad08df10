// What the colours of a map mean, and its formula.

import { number } from "../format.js";
import { html } from "../html.js";
import { gradientOf } from "../viewer/colours.js";
import { MAPS } from "./maps.js";

// range: [low, high], null while it is not known; the room is kept.
export function Legend({ map, range }) {
  const { name, formula, says, unit, colours } = MAPS[map];
  return html`
    <div class="meaning">
      <p><strong>${name}</strong> <span class="formula">${formula}</span></p>
      <div class="scale">
        <span>${range ? signed(range[0]) : "–"}</span>
        <i style=${{ backgroundImage: gradientOf(colours, "to right") }}></i>
        <span>${range ? signed(range[1]) : "–"}${unit && html` <span class="fact">${unit}</span>`}</span>
      </div>
      <p class="explain">${says}</p>
    </div>
  `;
}

const signed = (x) => (x < 0 ? `−${number(-x)}` : number(x));
