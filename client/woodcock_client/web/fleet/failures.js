// What failed lately, by reason, and which ends nobody could be told.

import { ago, brief, count, moment, title } from "../format.js";
import { html } from "../html.js";
import { byReason } from "../reasons.js";

const SHOWN = 5; // of each reason, before one asks for more

// failed: as usePoll has them; most: how many of the newest were asked for
export function Failures({ failed: { value, problem }, most }) {
  const jobs = value?.items ?? [];
  return html`
    <section aria-labelledby="failures">
      <h2 id="failures">What failed, and why</h2>
      ${!value && html`<p class="fact" role="status">${problem ? problem.message : "Loading…"}</p>`}
      ${value && jobs.length === 0 && html`<p class="empty">Nothing that is kept here has failed.</p>`}
      ${jobs.length > 0 && html`
        <ul class="reasons">
          ${byReason(jobs).map((group) => html`<${Group} key=${group.reason.says} ...${group} />`)}
        </ul>
      `}
      ${value?.next && html`<p class="fact">${`Of the newest ${most} that failed. `}<a href="/?state=failed" data-route>All of them</a></p>`}
      <${Unheard} jobs=${jobs} />
    </section>
  `;
}

function Group({ reason, jobs }) {
  const [newest] = jobs;
  const rest = jobs.slice(SHOWN);
  return html`
    <li>
      <h3>${reason.says} <span class="fact">${`${count(jobs.length)} render${jobs.length === 1 ? "" : "s"}, the newest `}<${When} at=${newest.finished_at} /></span></h3>
      <p class="help">${reason.help}</p>
      <ul class="failed-jobs">${jobs.slice(0, SHOWN).map((job) => html`<${Failed} key=${job.id} job=${job} />`)}</ul>
      ${rest.length > 0 && html`
        <details>
          <summary>${`${count(rest.length)} more`}</summary>
          <ul class="failed-jobs">${rest.map((job) => html`<${Failed} key=${job.id} job=${job} />`)}</ul>
        </details>
      `}
    </li>
  `;
}

const Failed = ({ job }) => html`
  <li>
    <a href=${`/renders/${encodeURIComponent(job.id)}`} data-route>${title(job)}</a>
    <span class="fact"><${When} at=${job.finished_at} /></span>
    ${job.error && html`<p class="fact">${brief(job.error.trim().split("\n")[0])}</p>`}
  </li>
`;

const When = ({ at }) => at && html`<time dateTime=${at} title=${moment(at)}>${ago(at, Date.now())}</time>`;

// Webhooks of these renders that nobody answered.
function Unheard({ jobs }) {
  const unheard = jobs.filter(({ webhook }) => webhook?.error && webhook.state !== "delivered");
  if (!unheard.length) return null;
  return html`
    <h3>Webhooks that nobody answered</h3>
    <ul class="failed-jobs">
      ${unheard.map(({ id, webhook, ...job }) => html`
        <li key=${id}>
          <a href=${`/renders/${encodeURIComponent(id)}`} data-route>${title(job)}</a>
          <span class="fact">${webhook.state === "given up" ? "given up" : `tried ${webhook.attempts} times, and will be again`}</span>
          <p class="fact">${webhook.url}: ${webhook.error}</p>
        </li>
      `)}
    </ul>
  `;
}
