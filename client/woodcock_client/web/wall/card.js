// One render on the wall: its picture, how far it is, and what to select it by.

import { useRef } from "preact/hooks";
import { isActive } from "../api.js";
import { ago, isDeterministic, moment, percent, STATES, title } from "../format.js";
import { html } from "../html.js";
import { Picture } from "../picture.js";
import { Badge, Bar } from "../states.js";

const REFINE = 3000; // ms between two versions of a running card's picture

// index: its place on the wall, of so many, -1 where nobody knows; reached: whether Tab comes to it; rushed: the wall
// is scrolled too fast to look at pictures.
export function Card({ job, index, of, selected, reached, rushed, onSelect }) {
  const pictured = useRef(false);
  pictured.current ||= !rushed;
  const facts = [`${job.width} × ${job.height}`];
  if (job.relative_rmse !== null) facts.push(`${isDeterministic(job) ? "≤ " : "±"}${percent(job.relative_rmse)}`);
  return html`
    <li class=${selected ? "selected" : ""} data-id=${job.id} aria-setsize=${of} aria-posinset=${index + 1}>
      <a class="card" href=${`/renders/${encodeURIComponent(job.id)}`} tabindex=${reached ? 0 : -1} data-route>
        <div class="stage">
          ${pictured.current && html`<${Picture} job=${job} link=${job.thumbnail} every=${REFINE} />`}
          ${isActive(job) && html`<${Bar} job=${job} label=${`Progress of ${title(job)}`} />`}
        </div>
        <div class="line">
          <span class="name" title=${title(job)}>${title(job)}</span>
          ${job.state === "running" && html`<${Badge} state="running" label=${`${Math.floor(100 * job.fraction)} %`} />`}
          ${job.state !== "running" && job.state !== "succeeded" &&
          html`<${Badge} state=${job.state} label=${STATES[job.state]} />`}
        </div>
        <div class="line fact">
          <span class="facts" title=${job.said ?? "Size, and estimated error of a pixel"}>${job.said ?? facts.join(" · ")}</span>
          <time dateTime=${job.created_at} title=${moment(job.created_at)}>${ago(job.created_at, Date.now())}</time>
        </div>
      </a>
      <label class="pick">
        <input
          type="checkbox"
          aria-label=${`Select ${title(job)}`}
          checked=${selected}
          tabindex=${reached ? 0 : -1}
          onClick=${(event) => onSelect(job.id, event.shiftKey)}
        />
      </label>
      ${job.batch &&
      html`<a class="of-batch" href=${`/batches/${encodeURIComponent(job.batch)}`} aria-label=${`Batch of ${title(job)}`} tabindex=${reached ? 0 : -1} data-route>Batch</a>`}
    </li>
  `;
}
