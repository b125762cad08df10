// The numbers under the pointer, and those of a crop.

import { html } from "../html.js";
import { titleOf } from "./layers.js";

const SPECIAL = { NaN: "NaN", Infinity: "∞", "-Infinity": "−∞" };

// Six digits, without an exponent where the number is of everyday size.
export function precise(value, digits = 6) {
  if (typeof value === "string") return SPECIAL[value];
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4 ? value.toExponential(digits - 1).replace("e+", "e") : String(Number(value.toPrecision(digits)));
  return text.replaceAll("-", "−");
}

const withError = (value, error) => `${precise(value)}${error === undefined ? "" : ` ± ${precise(error, 2)}`}`;

// One layer in a line.
export function Line({ pixels, layer }) {
  const held = pixels.layers.find(({ name }) => name === layer);
  if (!held) return null;
  return html`<span class="line">
    ${held.channels.map((channel, index) => html`<span key=${channel}><b>${channel}</b> ${withError(held.values[index], held.errors?.[index])}</span>`)}
  </span>`;
}

export const samplesAt = (pixels) => pixels.layers.find(({ name }) => name === "samples")?.values[0];

// All of them.
export function Values({ pixels }) {
  return html`
    <div><table class="values">
      <caption>${`Pixel ${pixels.x}, ${pixels.y}`}</caption>
      <tbody>
        ${pixels.layers.map(({ name, values }) => html`
          <tr key=${name}>
            <th scope="row">${titleOf(name)}</th>
            ${values.map((value, index) => html`<td key=${index} class=${typeof value === "string" ? "special" : ""}>${precise(value)}</td>`)}
          </tr>
        `)}
      </tbody>
    </table></div>
  `;
}
