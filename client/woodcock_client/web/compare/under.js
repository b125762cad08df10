// What all pictures hold at the pixel under the pointer.

import { number, title } from "../format.js";
import { html } from "../html.js";
import { valuesAt } from "../viewer/halves.js";
import { MAPS } from "./maps.js";

const NAMES = { R: "Red", G: "Green", B: "Blue", Y: "Grey" };

const written = (x) => (Number.isFinite(x) ? `${x < 0 ? "−" : ""}${number(Math.abs(x))}` : Number.isNaN(x) ? "NaN" : "∞");

// mapped: the map that is shown, {data, map}, or null. The room is kept while there is no point, so that nothing jumps.
export function Under({ point, jobs, pictures, mapped }) {
  const rows = (pictures ?? []).map((data, place) => ({ key: jobs[place].id, digit: place + 1, name: title(jobs[place]), data }));
  if (mapped) rows.push({ key: "map", name: MAPS[mapped.map].name, data: mapped.data });
  const channels = rows.reduce((widest, { data }) => (data.channels.length > widest.length ? data.channels : widest), []);
  return html`
    <table class="under">
      <caption>${point ? `Pixel ${point.x}, ${point.y}` : "Values under the pointer"}</caption>
      <thead>
        <tr><th scope="col">Picture</th>${channels.map((channel) => html`<th scope="col" class="figure" key=${channel}>${NAMES[channel] ?? channel}</th>`)}</tr>
      </thead>
      <tbody>
        ${rows.map(({ key, digit, name, data }) => {
          const values = point ? valuesAt(data, point) : [];
          return html`
            <tr key=${key}>
              <th scope="row">${digit && html`<span class="digit">${digit}</span> `}${name}</th>
              ${channels.map((channel, index) => html`<td class="figure" key=${channel}>${values.length > index ? written(values[index]) : point ? "" : "–"}</td>`)}
            </tr>
          `;
        })}
      </tbody>
    </table>
  `;
}
