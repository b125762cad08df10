// What can be done with the renders that are selected.

import { useState } from "preact/hooks";
import { deleteJobs, isActive, MOST_DELETED } from "../api.js";
import { count } from "../format.js";
import { html } from "../html.js";
import { putOff } from "../undo.js";
import { Tags } from "./tags.js";

const COMPARED = [2, 4]; // renders, at least and at most
export const HEIGHT = 76; // pixels that it covers at the foot of the window, with its margins

const renders = (n) => `${count(n)} render${n === 1 ? "" : "s"}`;

export function Toolbar({ jobs, onClear, onChanged }) {
  const [tagging, setTagging] = useState(false);
  const ended = jobs.filter((job) => !isActive(job));
  const pictures = jobs.every((job) => job.state === "succeeded");
  const comparable = pictures && jobs.length >= COMPARED[0] && jobs.length <= COMPARED[1];
  const compared = `/compare?renders=${jobs.map((job) => encodeURIComponent(job.id)).join()}`;

  function remove() {
    const ids = ended.map((job) => job.id);
    const left = jobs.length - ended.length;
    const said = `${renders(ids.length)} deleted${left > 0 ? `; ${count(left)} in progress stay${left === 1 ? "s" : ""}` : ""}.`;
    putOff({ said, ids, send: async (leaving) => (await deleteJobs(ids, leaving)).kept });
    onClear();
  }

  return html`
    <div class="toolbar" role="toolbar" aria-label="Selected renders">
      <span class="number" role="status">${count(jobs.length)} selected</span>
      ${comparable
        ? html`<a class="button" href=${compared} data-route>Compare</a>`
        : html`<button type="button" disabled title="Two to four renders that are done can be compared">Compare</button>`}
      <button type="button" onClick=${() => setTagging(true)}>Tags</button>
      <button
        type="button"
        disabled=${ended.length === 0 || ended.length > MOST_DELETED}
        title=${ended.length > MOST_DELETED ? `At most ${count(MOST_DELETED)} at a time` : "Those that have ended"}
        onClick=${remove}
      >Delete</button>
      <button type="button" class="plain" aria-label="Clear the selection" title="Clear the selection" onClick=${onClear}>×</button>
    </div>
    ${tagging && html`<${Tags} jobs=${jobs} onDone=${() => setTagging(false)} onChanged=${onChanged} />`}
  `;
}
