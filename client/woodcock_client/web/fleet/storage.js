// What the service keeps, by which rule, and what that would delete next.

import { bytes, count, moment } from "../format.js";
import { html } from "../html.js";

// retention: as usePoll has it
export function Storage({ retention: { value, problem } }) {
  return html`
    <section aria-labelledby="storage">
      <h2 id="storage">Storage</h2>
      ${!value && html`<p class="fact" role="status">${problem ? problem.message : "Loading…"}</p>`}
      ${value && html`<${Kept} ...${value} />`}
    </section>
  `;
}

function Kept({ days, size, kept, freed, renders, files }) {
  const rules = [
    days !== null && `renders that ended more than ${count(days)} day${days === 1 ? "" : "s"} ago are deleted`,
    size !== null && `the oldest go once all take more than ${bytes(size)}`,
  ].filter(Boolean);
  const jobs = renders.flatMap((group) => group.jobs);
  return html`
    <p><b>${bytes(kept)}</b> ${size !== null && html`of ${bytes(size)} `}<span class="fact">in pictures, samples and uploaded files</span></p>
    ${size > 0 && html`<meter class="room" aria-label="Room that is taken" min="0" max=${size} value=${Math.min(kept, size)}></meter>`}
    <p class="fact">
      ${rules.length ? `By this service’s rule ${rules.join(", and ")}. What is pinned stays.` : "Everything is kept until somebody deletes it: no rule is set."}
    </p>
    ${jobs.length + files.length > 0 && html`
      <p>${`Next to go: ${count(jobs.length)} render${jobs.length === 1 ? "" : "s"} and ${count(files.length)} file${files.length === 1 ? "" : "s"}, ${bytes(freed)}.`}</p>
      <ul class="failed-jobs">
        ${renders.slice(0, 5).map(({ jobs: [id], name, finished_at: at, size: takes }) => html`
          <li key=${id}><a href=${`/renders/${encodeURIComponent(id)}`} data-route>${name || "Untitled"}</a> <span class="fact">${bytes(takes)}, ended <time dateTime=${at}>${moment(at)}</time></span></li>
        `)}
      </ul>
    `}
  `;
}
