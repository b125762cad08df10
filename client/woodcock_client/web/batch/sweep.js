// The renders of a batch where their values put them: rows and columns of two axes, or one axis after the other's end.

import { isActive } from "../api.js";
import { isDeterministic, percent, STATES } from "../format.js";
import { html } from "../html.js";
import { Picture } from "../picture.js";
import { Badge, Bar } from "../states.js";
import { called, placed, pointed, valued } from "./points.js";

const REFINE = 3000; // ms between two versions of a running tile's picture

// at: of the axes before the last two, which value is shown.
export function Sweep({ batch, at, onAt }) {
  const { axes, scene } = batch;
  const jobs = placed(axes, batch.jobs);
  const size = { width: scene.film.width, height: scene.film.height };
  const tile = (...place) => html`<${Tile} job=${jobs.get(place.join())} size=${size} />`;
  if (axes.length < 2) return html`<${Line} axis=${axes[0]} tile=${tile} />`;
  const others = axes.slice(0, -2);
  const [down, across] = axes.slice(-2);
  return html`
    ${others.length > 0 && html`
      <div class="others">
        ${others.map((axis, index) => html`
          <label key=${index}>
            <span aria-hidden="true">${called(axis)}</span>
            <select aria-label=${called(axis)} value=${at[index]} onChange=${(event) => onAt(at.with(index, Number(event.currentTarget.value)))}>
              ${axis.rows.map((row, value) => html`<option key=${value} value=${value}>${valued(row)}</option>`)}
            </select>
          </label>
        `)}
      </div>
    `}
    <div class="sweep" role="region" aria-label="Renders by their values" tabindex="0">
      <table>
        <thead>
          <tr><td></td><th scope="colgroup" colspan=${across.rows.length}><code>${called(across)}</code></th></tr>
          <tr>
            <th scope="col"><code>${called(down)}</code></th>
            ${across.rows.map((row, column) => html`<th key=${column} scope="col">${valued(row)}</th>`)}
          </tr>
        </thead>
        <tbody>
          ${down.rows.map((row, line) => html`
            <tr key=${line}>
              <th scope="row">${valued(row)}</th>
              ${across.rows.map((_, column) => html`<td key=${column}>${tile(...at, line, column)}</td>`)}
            </tr>
          `)}
        </tbody>
      </table>
    </div>
  `;
}

// axis: undefined where nothing varies
const Line = ({ axis, tile }) => html`
  ${axis && html`<p class="axis"><code>${called(axis)}</code></p>`}
  <ul class="along">
    ${(axis?.rows ?? [[]]).map((row, index) => html`<li key=${index}>${tile(...(axis ? [index] : []))}<p>${valued(row)}</p></li>`)}
  </ul>
`;

function Tile({ job, size }) {
  if (!job) return html`<div class="tile"><div class="stage"><span class="no-picture">Deleted</span></div></div>`;
  const { state, relative_rmse: error } = job;
  const label = pointed(job.point) || "Render";
  const shown = { ...job, ...size, name: label };
  const failed = job.error ?? job.waiting;
  return html`
    <a class="tile" href=${`/renders/${encodeURIComponent(job.id)}`} title=${failed ?? label} data-route>
      <div class="stage">
        <${Picture} key=${job.id} job=${shown} link=${job.links.thumbnail} every=${REFINE} lazy />
        ${isActive(job) && html`<${Bar} job=${job} label=${`Progress of ${label}`} />`}
      </div>
      <span class="fact">
        ${state === "succeeded" ? error !== null && `${isDeterministic(job) ? "≤ " : "±"}${percent(error)}` : html`<${Badge} state=${state} label=${STATES[state]} />`}
      </span>
    </a>
  `;
}
