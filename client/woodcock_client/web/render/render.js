// One render: the picture, how far it is, how wrong it may still be, what it is made of, and its files.

import { useEffect, useState } from "preact/hooks";
import { followJob, getJob, getReport, isActive, listDevices } from "../api.js";
import { Downloads } from "./downloads.js";
import { Facts } from "./facts.js";
import { duration, isDeterministic, number, percent, progress, STATES, title } from "../format.js";
import { html } from "../html.js";
import { Badge, Bar, Notice, Offline } from "../states.js";
import { Viewer } from "../viewer/viewer.js";

const RETRY = 3000; // ms before a page that could not be loaded tries again

const BACK = html`<a class="button" href="/" data-route>All renders</a>`;

export function Render({ id, query }) {
  const { job, report, devices, problem, away } = useRender(id);

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
      <h1>${title(job)}</h1>
      <${Badge} state=${job.state} label=${STATES[job.state]} />
    </div>
    <div class="render">
      <${Viewer} job=${job} query=${query} />
      <div class="side">
        ${job.state === "failed" && html`<${Failure} job=${job} />`}
        <${Progress} job=${job} report=${report} />
        ${report?.contract && job.links.report_page && html`<p><a class="button" href=${job.links.report_page}>Report page <span class="fact">error, pictures of it</span></a></p>`}
        <${Downloads} job=${job} />
        <${Facts} job=${job} report=${report} devices=${devices} />
      </div>
    </div>
  `;
}

function useRender(id) {
  const [job, setJob] = useState(null);
  const [report, setReport] = useState(null);
  const [devices, setDevices] = useState([]);
  const [problem, setProblem] = useState(null);
  const [away, setAway] = useState(false);

  useEffect(() => {
    const abort = new AbortController();
    let stop = () => {};
    let timer;
    const ignore = () => {}; // the page does without

    async function start() {
      try {
        const loaded = await getJob(id, abort.signal);
        if (abort.signal.aborted) return undefined;
        setJob(loaded);
        setProblem(null);
        const finish = (done) => done.links.report && getReport(done, abort.signal).then(setReport, ignore);
        if (!isActive(loaded)) return finish(loaded);
        let latest = loaded;
        stop = followJob(loaded, {
          onJob: (summary) => setJob((latest = { ...latest, ...summary })),
          onEnd: () => finish(latest),
          onLost: setAway,
        });
      } catch (error) {
        if (error.name === "AbortError") return undefined;
        setProblem(error);
        if (error.status !== 404) timer = setTimeout(start, RETRY);
      }
      return undefined;
    }

    start();
    listDevices(abort.signal).then(({ items }) => setDevices(items), ignore);
    return () => {
      abort.abort();
      clearTimeout(timer);
      stop();
    };
  }, [id]);
  return { job, report, devices, problem, away };
}

// The first line is the sentence; a compiler's or a driver's own words may follow it.
function Failure({ job }) {
  const [sentence, ...rest] = (job.error || "The service gave no reason; its log may.").trim().split("\n");
  return html`
    <section class="failure" role="alert">
      <h2>This render failed</h2>
      <p>${sentence}</p>
      ${rest.length > 0 && html`<details><summary>Everything that was said</summary><pre>${rest.join("\n").trim()}</pre></details>`}
      <p class="fact">It will not be tried again by itself. Its scene can be downloaded below, mended and submitted anew.</p>
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

const Loading = () => html`
  <div class="heading" role="status"><a class="up" href="/" data-route>Renders</a><h1>Loading…</h1></div>
  <div class="render" aria-hidden="true">
    <div class="viewer"><div class="stage large"></div></div>
    <div class="side"></div>
  </div>
`;
