// Every render as a card, or those of a batch, newest first.

import { useEffect, useLayoutEffect, useReducer, useRef } from "preact/hooks";
import { isActive } from "../api.js";
import { ago, brief, count, isDeterministic, moment, percent, STATES, title } from "../format.js";
import { html } from "../html.js";
import { listing, more, watch } from "./listing.js";
import { Picture } from "../picture.js";
import { Badge, Bar, Notice, Offline } from "../states.js";

const REFINE = 3000; // ms between two versions of a running card's preview

let place = 0; // how far the wall was scrolled when it was left

export function Wall({ query }) {
  const batch = query.get("batch");
  const [, redraw] = useReducer((n) => n + 1, 0);
  useEffect(() => watch(batch, redraw), []);
  useEffect(() => {
    document.title = `${batch ? "Batch" : "Renders"} · Woodcock`;
  }, []);
  useLayoutEffect(() => {
    if (listing.batch !== batch) place = 0;
    scrollTo(0, place);
    const onScroll = () => (place = scrollY);
    addEventListener("scroll", onScroll, { passive: true });
    return () => removeEventListener("scroll", onScroll);
  }, []);

  const { jobs, next, problem, away } = listing;
  if (listing.batch !== batch) return html`<${Loading} />`; // what is known is of another wall
  if (!jobs && problem) return html`<${Failed} problem=${problem} />`;
  if (!jobs) return html`<${Loading} />`;
  if (jobs.length === 0) return html`<${Offline} when=${away} /><${batch ? EmptyBatch : Empty} />`;
  const running = jobs.filter(isActive).length;
  return html`
    <${Offline} when=${away} />
    <div class="heading">
      ${batch && html`<a class="up" href="/" data-route>Renders</a>`}
      <h1>${batch ? "Batch" : "Renders"}</h1>
      ${running > 0 && html`<span class="fact">${count(running)} in progress</span>`}
    </div>
    <ul class="wall">
      ${jobs.map((job) => html`<${Card} key=${job.id} job=${job} now=${Date.now()} />`)}
    </ul>
    ${next && html`<${Rest} key=${next} problem=${problem} />`}
  `;
}

function Card({ job, now }) {
  const active = isActive(job);
  const facts = [`${job.width} × ${job.height}`];
  if (job.relative_rmse !== null) facts.push(`${isDeterministic(job) ? "≤ " : "±"}${percent(job.relative_rmse)}`);
  const said = job.error ?? job.waiting;
  return html`
    <li>
      <a class="card" href=${`/renders/${encodeURIComponent(job.id)}`} data-route>
        <div class="stage">
          <${Picture} job=${job} every=${REFINE} lazy />
          ${active && html`<${Bar} job=${job} label=${`Progress of ${title(job)}`} />`}
        </div>
        <div class="line">
          <span class="name" title=${title(job)}>${title(job)}</span>
          ${job.state === "running" && html`<${Badge} state="running" label=${`${Math.floor(100 * job.fraction)} %`} />`}
          ${job.state !== "running" && job.state !== "succeeded" &&
          html`<${Badge} state=${job.state} label=${STATES[job.state]} />`}
        </div>
        <div class="line fact">
          <span class="facts" title=${said ?? "Size, and estimated error of a pixel"}>${said ? brief(said) : facts.join(" · ")}</span>
          <time dateTime=${job.created_at} title=${moment(job.created_at)}>${ago(job.created_at, now)}</time>
        </div>
      </a>
    </li>
  `;
}

// Asks for the next page when it comes near the window; after a failure, when asked to.
function Rest({ problem }) {
  const end = useRef();
  useEffect(() => {
    if (problem) return undefined;
    const observer = new IntersectionObserver(
      ([entry]) => entry.isIntersecting && more(),
      { rootMargin: "800px" },
    );
    observer.observe(end.current);
    return () => observer.disconnect();
  }, [problem]);
  return html`
    <div class="rest" ref=${end}>
      ${problem ? html`<p>${problem.message}</p>` : ""}
      <button type="button" onClick=${more}>${problem ? "Try again" : "Show older renders"}</button>
    </div>
  `;
}

const Loading = () => html`
  <div class="heading" role="status"><h1>Renders</h1><span class="fact">Loading…</span></div>
  <ul class="wall" aria-hidden="true">
    ${Array.from({ length: 12 }, () => html`
      <li><div class="ghost"><div class="stage"></div><div class="line"></div><div class="line"></div></div></li>
    `)}
  </ul>
`;

const Failed = ({ problem }) => html`
  <${Notice}
    title=${problem.status === 0 ? "The service does not answer" : "The renders cannot be listed"}
    action=${html`<button type="button" onClick=${more}>Try again</button>`}
  >
    <p>
      ${problem.status === 0
        ? "It may be starting, stopped, or out of reach of this computer. This page keeps trying."
        : problem.message}
    </p>
  <//>
`;

const EmptyBatch = () => html`
  <${Notice} title="There are no renders of this batch" action=${html`<a class="button" href="/" data-route>All renders</a>`}>
    <p>The address may be mistyped, or they were deleted.</p>
  <//>
`;

const Empty = () => html`
  <${Notice} title="Nothing rendered yet">
    <p><a class="button" href="/submit" data-route>Begin with an example</a></p>
    <p>Or send a scene from a terminal, and it appears here as it renders:</p>
    <pre><code>woodcock submit scene.json --follow --server ${location.origin}</code></pre>
    <p class="fact">Or <code>POST</code> it to <code>/api/v1/jobs</code>: the <a href="/docs">API</a> shows how.</p>
  <//>
`;
