// Every render as a card, newest first, or those that a filter means.

import { useEffect, useLayoutEffect, useReducer } from "preact/hooks";
import { isActive } from "../api.js";
import { count } from "../format.js";
import { html } from "../html.js";
import { go } from "../navigation.js";
import { Notice, Offline } from "../states.js";
import { gone, useGone } from "../undo.js";
import { filterOf } from "./filter.js";
import { Filters } from "./filters.js";
import { Grid } from "./grid.js";
import { listing, more, renew, show, watch } from "./listing.js";
import { clear, reach, selection, toggle } from "./selection.js";
import { HEIGHT, Toolbar } from "./toolbar.js";

export function Wall({ query }) {
  const filter = filterOf(query);
  const [, redraw] = useReducer((n) => n + 1, 0);
  useGone();
  useEffect(() => {
    document.title = "Renders · Woodcock";
  }, []);
  useLayoutEffect(() => {
    if (listing.filter !== filter) clear();
    const stop = watch(filter, redraw);
    scrollTo(0, listing.place);
    return stop;
  }, [filter]);
  useLayoutEffect(() => {
    const onScroll = () => {
      listing.place = scrollY;
      if (scrollY === 0) show();
    };
    addEventListener("scroll", onScroll, { passive: true });
    return () => removeEventListener("scroll", onScroll);
  }, []);

  const { away, fresh, behind } = listing;
  const jobs = gone.size > 0 ? listing.jobs?.filter((job) => !gone.has(job.id) && !gone.has(job.batch)) : listing.jobs;
  const selected = selection.ids.size > 0 && jobs ? jobs.filter((job) => selection.ids.has(job.id)) : [];
  const running = jobs?.filter(isActive).length ?? 0;
  const select = (change) => (...how) => {
    change(...how);
    redraw();
  };
  const onClear = select(clear);
  const batch = query.get("batch");
  return html`
    <${Offline} when=${away} />
    <div class="heading">
      <h1>Renders</h1>
      ${batch && html`<a href=${`/batches/${encodeURIComponent(batch)}`} data-route>of a batch</a>`}
      ${running > 0 && html`<span class="fact">${count(running)} in progress</span>`}
      ${!jobs && !listing.problem && html`<span class="fact" role="status">Loading…</span>`}
    </div>
    ${(filter || jobs?.length !== 0) && html`<${Filters} filter=${filter} />`}
    <div class="news" role="status">
      ${(fresh.length > 0 || behind) && html`
        <button type="button" onClick=${() => { show(); scrollTo(0, 0); }}>
          ${behind ? "New renders" : `${count(fresh.length)} new render${fresh.length === 1 ? "" : "s"}`}
        </button>
      `}
    </div>
    <${Shown}
      filter=${filter}
      jobs=${jobs}
      stale=${listing.stale || listing.filter !== filter}
      selected=${selection.ids}
      covered=${selected.length > 0 ? HEIGHT : 0}
      onSelect=${select((id, through) => (through ? reach(jobs, id) : toggle(id)))}
      onClear=${onClear}
    />
    ${selected.length > 0 && html`<${Toolbar} jobs=${selected} onClear=${onClear} onChanged=${renew} />`}
  `;
}

function Shown({ filter, jobs, stale, ...rest }) {
  const { next, problem, place } = listing;
  if ((!jobs || stale) && problem) return html`<${Failed} problem=${problem} />`;
  if (!jobs) return html`<${Ghosts} />`;
  if (jobs.length === 0 && !next && !stale) return filter ? html`<${NoMatch} />` : html`<${Empty} />`;
  const onEnd = () => next && !problem && more();
  return html`
    <${Grid} jobs=${jobs} whole=${!next} stale=${stale} place=${place} onEnd=${onEnd} ...${rest} />
    ${next && html`
      <div class="rest">
        ${problem ? html`<p role="alert">${problem.message}</p><button type="button" onClick=${more}>Try again</button>` : html`<p class="fact">Loading older renders…</p>`}
      </div>
    `}
  `;
}

const Ghosts = () => html`
  <ul class="ghosts" aria-hidden="true">
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

const NoMatch = () => html`
  <${Notice} title="No render is like that" action=${html`<button type="button" onClick=${() => go("/")}>All renders</button>`}>
    <p>None has such a name and all that was chosen above.</p>
  <//>
`;

const Empty = () => html`
  <${Notice} title="Nothing rendered yet">
    <p>Send a scene from a terminal, and it appears here as it renders:</p>
    <pre><code>woodcock submit scene.json --follow --server ${location.origin}</code></pre>
    <p class="fact">Or <code>POST</code> it to <code>/api/v1/jobs</code>: the <a href="/docs">API</a> shows how.</p>
  <//>
`;
