// Two to four renders of one size held against each other: pictures, maps of how they differ, numbers, and the answer to
// whether that is noise or bias.

import { useEffect, useState } from "preact/hooks";
import { isActive } from "../api.js";
import { STATES, title } from "../format.js";
import { html } from "../html.js";
import { ErrorChart } from "../render/chart.js";
import { seriesOf } from "../render/curves.js";
import { Notice } from "../states.js";
import { readView } from "../viewer/view.js";
import { readAddress, writeAddress } from "./address.js";
import { useDifferences, useJobs } from "./load.js";
import { Numbers } from "./numbers.js";
import { Picker } from "./picker.js";
import { Renders } from "./renders.js";
import { Stage } from "./stage.js";
import { Verdicts } from "./verdicts.js";

const SETTLED = 250; // ms; browsers let an address be changed only so often

export function Compare({ query }) {
  const { ids } = readAddress(query);
  const { jobs, reports, problem } = useJobs(ids);

  useEffect(() => {
    scrollTo(0, 0);
    document.getElementById("main").focus({ preventScroll: true });
    document.title = "Compare · Woodcock";
  }, []);

  const others = html`<a class="button" href="/compare" data-route>Choose others</a>`;
  if (problem?.status === 404) {
    return html`<${Notice} title="One of these renders is not there" action=${others}><p>${problem.message} It may have been deleted.</p><//>`;
  }
  if (problem) {
    const name = problem.status === 0 ? "The service does not answer" : "These renders cannot be compared";
    return html`<${Notice} title=${name} action=${others}><p>${problem.message} Trying again…</p><//>`;
  }
  if (!jobs) return html`<${Loading} />`;
  const fault = jobs.length > 1 ? faultOf(jobs) : null;
  if (fault) return html`<${Notice} title="These renders cannot be compared" action=${others}><p>${fault}</p><//>`;
  if (jobs.length < 2) return html`<${Picker} chosen=${jobs.filter((job) => job.state === "succeeded")} />`;
  return html`<${Comparison} query=${query} jobs=${jobs} reports=${reports} />`;
}

// Why not, as a sentence.
function faultOf(jobs) {
  const undone = jobs.find((job) => job.state !== "succeeded");
  if (undone) {
    const wait = isActive(undone) ? " Come back once it is." : "";
    return `Only finished renders are compared. “${title(undone)}” is not done: ${STATES[undone.state].toLowerCase()}.${wait}`;
  }
  const size = (job) => `${job.width} × ${job.height}`;
  const other = jobs.find((job) => size(job) !== size(jobs[0]));
  return other ? `Only pictures of one size are compared. “${title(jobs[0])}” is ${size(jobs[0])} pixels, “${title(other)}” ${size(other)}.` : null;
}

function Comparison({ query, jobs, reports }) {
  const [state, setState] = useState(() => readAddress(query));
  const [view, setView] = useState(() => readView(query));
  const change = (values) => setState((before) => ({ ...before, ...values }));
  useEffect(() => {
    const timer = setTimeout(() => writeAddress(state, view), SETTLED);
    return () => clearTimeout(timer);
  }, [state, view]);

  const differences = useDifferences(jobs, state.reference);
  const compared = jobs
    .map((job, place) => ({ job, place, ...differences[job.id] }))
    .filter(({ place }) => place !== state.reference);
  return html`
    <div class="heading">
      <a class="up" href="/" data-route>Renders</a>
      <h1>Compare</h1>
      <span class="fact">${`${jobs[0].width} × ${jobs[0].height}`}</span>
      <a class="fact" href=${`/compare?renders=${encodeURIComponent(jobs[state.reference].id)}`} data-route>Choose others</a>
    </div>
    <div class="compare">
      <${Stage} jobs=${jobs} differences=${differences} state=${state} change=${change} view=${view} onView=${setView} />
      <div class="side">
        <${Verdicts} compared=${compared} />
        <${Renders}
          jobs=${jobs}
          reports=${reports}
          reference=${state.reference}
          shown=${state.shown}
          onReference=${(reference) => change({ reference })}
          onShown=${(shown) => change({ shown })}
        />
      </div>
      <${Numbers} compared=${compared} reference=${jobs[state.reference]} />
      <${Errors} jobs=${jobs} reports=${reports} />
    </div>
  `;
}

// How the error of each fell with time.
function Errors({ jobs, reports }) {
  const series = jobs.flatMap((job, place) => (reports[place]?.error?.length ? [seriesOf(`${place + 1} ${title(job)}`, reports[place])] : []));
  return series.length > 0 ? html`<${ErrorChart} series=${series} />` : null;
}

const Loading = () => html`
  <div class="heading" role="status"><a class="up" href="/" data-route>Renders</a><h1>Compare</h1><span class="fact">Loading…</span></div>
  <div class="compare" aria-hidden="true"><div class="stages"><div class="stage"></div></div><div class="side"></div></div>
`;
