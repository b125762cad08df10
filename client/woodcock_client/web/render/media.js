// The media of a scene as they are on the device.

import { number, percent } from "../format.js";
import { html } from "../html.js";

export const Media = ({ media }) => html`
  <section>
    <h2>${media.length > 1 ? "Media" : "Medium"}</h2>
    <dl class="table">
      ${media.map((each, index) => html`<div key=${index}><dt>${each.kind}</dt><dd><${Medium} medium=${each} /></dd></div>`)}
    </dl>
  </section>
`;

function Medium({ medium }) {
  const { sigma_t: sigma, storage, scatters, emits, coloured } = medium;
  const does = [scatters ? "scatters" : "absorbs", emits && "emits", coloured && "in colour"].filter(Boolean);
  return html`
    ${does.join(", ")} <span class="fact">${`σₜ up to ${sigma.map(number).join(", ")}`}</span>
    ${Object.entries(storage ?? {}).map(([name, { kind, error }]) => html`
      <span class="device" key=${name}>${name} <span class="fact">${`stored as ${kind}, ${error > 0 ? `off by ${percent(error)} of its largest at most` : "exactly"}`}</span></span>
    `)}
  `;
}
