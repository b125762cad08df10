// One render: the picture, how far it is, how wrong it may still be, what it is made of, and its files.

import { useEffect } from "preact/hooks";
import { Actions } from "./actions.js";
import { Downloads } from "./downloads.js";
import { Facts } from "./facts.js";
import { useRender } from "./follow.js";
import { brief, duration, isDeterministic, number, percent, progress, STATES, title } from "../format.js";
import { html } from "../html.js";
import { Name, Tags } from "./label.js";
import { Report } from "./report.js";
import { reasonOf } from "../reasons.js";
import { Badge, Bar, Notice, Offline } from "../states.js";
import { Viewer } from "../viewer/viewer.js";

const BACK = html`<a class="button" href="/" data-route>All renders</a>`;

export function Render({ id, query }) {
  const { job, report: found, devices, problem, away, onChange } = useRender(id);
  const report = found?.problem ? null : found;

  useEffect(() => {
    scrollTo(0, 0);
    document.getElementById("main").focus({ preventScroll: true });
  }, []);
  useEffect(() => {
    const sign = !job ? "" : job.state === "running" ? `${Math.floor(100 * job.fraction)} % · ` : "";
    document.title = `${sign}${job ? title(job) : "Render"} · Woodcock`;
  }, [job]);

  if (problem?.status === 404) {
    return html`
      <${Notice} title="There is no such render" action=${BACK}>
        <p>The address may be mistyped, or the render was made by another service.</p>
      <//>
    `;
  }
  if (problem) {
    const title = problem.status === 0 ? "The service does not answer" : "The render cannot be shown";
    return html`<${Notice} title=${title} action=${BACK}><p>${problem.message} Trying again…</p><//>`;
  }
  if (!job) return html`<${Loading} />`;
  return html`
    <${Offline} when=${away} />
    <div class="heading">
      <a class="up" href="/" data-route>Renders</a>
      <${Name} job=${job} onChange=${onChange} />
      <${Badge} state=${job.state} label=${STATES[job.state]} />
      <${Tags} job=${job} onChange=${onChange} />
    </div>
    <div class="render">
      <${Viewer} job=${job} query=${query} />
      <div class="side">
        ${job.state === "failed" && html`<${Failure} job=${job} />`}
        <${Progress} job=${job} report=${report} />
        <${Actions} job=${job} report=${report} onChange=${onChange} />
        <${Downloads} job=${job} whole=${Boolean(report?.contract && job.links.report_page)} />
        <${Facts} job=${job} report=${report} devices=${devices} />
      </div>
    </div>
    ${report && html`<${Report} job=${job} report=${report} />`}
    ${!report && job.links.report && html`<${Awaited} ...${found} />`}
  `;
}

// The first line is the sentence; a compiler's or a driver's own words may follow it.
function Failure({ job }) {
  const { help } = reasonOf(job.error);
  const [sentence, ...rest] = (job.error || "The service gave no reason; its log may.").trim().split("\n");
  return html`
    <section class="failure" role="alert">
      <h2>This render failed</h2>
      <p>${brief(sentence)}</p>
      ${rest.length > 0 && html`<details><summary>Everything that was said</summary><pre>${rest.join("\n").trim()}</pre></details>`}
      <p class="fact">${help}</p>
      <p class="fact">It will not be tried again by itself.</p>
    </section>
  `;
}

function Progress({ job, report }) {
  const { rmse, relative_rmse: relative } = job;
  const noiseless = report?.deterministic ?? isDeterministic(job);
  return html`
    <section aria-label="Progress">
      <${Bar} job=${job} label="Progress" />
      <p class="numbers">${progress(job)}</p>
      ${job.waiting && html`<p class="waiting" role="status">${job.waiting}</p>`}
      <dl class="figures">
        <div>
          <dt>${noiseless ? "Error at most" : "Estimated error"}</dt>
          <dd>${relative !== null ? percent(relative) : rmse !== null ? number(rmse) : "–"}</dd>
        </div>
        <div>
          <dt>Rendering time</dt>
          <dd>${duration(job.seconds)}</dd>
        </div>
      </dl>
      <p class="explain">
        ${noiseless ? bounded(rmse, relative, report?.bound?.largest) : estimated(rmse, relative)}
      </p>
    </section>
  `;
}

function estimated(rmse, relative) {
  if (rmse === null) return "The error is estimated from how samples of the same pixel differ, once there are two.";
  return `One standard error of a pixel’s luminance, root mean square over the picture${inUnits(rmse, relative)}. Four times the samples halve it.`;
}

// largest: at most that in any pixel, once it is known
function bounded(rmse, relative, largest) {
  const without = "Computed without random numbers: no noise";
  if (rmse === null) return `${without}. How far rounding may have put it off has no bound.`;
  const anywhere = typeof largest === "number" ? `, and at most ${number(largest)} in any pixel` : "";
  return `${without}. The error is at most this, root mean square over the picture${inUnits(rmse, relative)}${anywhere}. More samples only smooth edges.`;
}

const inUnits = (rmse, relative) =>
  relative !== null
    ? `: ${percent(relative)} of the mean, ${number(rmse)} in the scene’s unit of radiance`
    : ", in the scene’s unit of radiance";

// In the report's place while it is fetched, or cannot be.
const Awaited = ({ problem, again }) => html`
  <div class="report awaited" role=${problem ? "alert" : "status"}>
    ${problem
      ? html`<p>The report cannot be shown. ${problem.message} <button type="button" onClick=${again}>Try again</button></p>`
      : html`<p class="fact">Loading the report…</p>`}
  </div>
`;

const Loading = () => html`
  <div class="heading" role="status"><a class="up" href="/" data-route>Renders</a><h1>Loading…</h1></div>
  <div class="render" aria-hidden="true">
    <div class="viewer"><div class="stage large"></div></div>
    <div class="side"></div>
  </div>
`;
