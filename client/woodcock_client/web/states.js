// What a page shows when there is nothing else to show, and the line that says the service is away.

import { html } from "./html.js";

export const Notice = ({ title, children, action }) => html`
  <section class="notice" role="status">
    <h1>${title}</h1>
    ${children}
    ${action && html`<p>${action}</p>`}
  </section>
`;

export const Offline = ({ when }) =>
  html`<p class="offline" role="status" hidden=${!when}>The service does not answer. What you see may be old; trying again…</p>`;

export const Badge = ({ state, label }) => html`<span class="badge ${state}">${label}</span>`;

export const Bar = ({ job, label }) => html`
  <div
    class="progress ${job.state}"
    role="progressbar"
    aria-label=${label}
    aria-valuemin="0"
    aria-valuemax="100"
    aria-valuenow=${Math.round(100 * job.fraction)}
  >
    <i style=${{ transform: `scaleX(${job.fraction})` }}></i>
  </div>
`;
