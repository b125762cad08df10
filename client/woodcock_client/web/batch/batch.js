// The page of a batch: what is swept, and how far each of its renders is.

import { useEffect, useState } from "preact/hooks";
import { cancelBatch, deleteBatch, getBatch, isActive } from "../api.js";
import { count } from "../format.js";
import { html } from "../html.js";
import { go } from "../navigation.js";
import { Notice, Offline } from "../states.js";
import { gone, putOff, useGone } from "../undo.js";
import { Sweep } from "./sweep.js";

const BEAT = 2000; // ms between looks while something renders
const REST = 10000; // ms when nothing does: renders may be tried again or extended

const BACK = html`<a class="button" href="/" data-route>All renders</a>`;

export function Batch({ id, query }) {
  const { batch, problem, away, look } = useBatch(id);
  const [at, setAt] = useState(() => (query.get("at") ?? "").split(",").map(Number));
  useGone();
  useEffect(() => {
    scrollTo(0, 0);
    document.getElementById("main").focus({ preventScroll: true });
  }, []);
  const name = batch?.name || "Batch";
  useEffect(() => {
    document.title = `${name} · Woodcock`;
  }, [name]);

  if (gone.has(id)) return html`<${Notice} title="This batch is deleted" action=${BACK} />`;
  if (problem?.status === 404) {
    return html`
      <${Notice} title="There is no such batch" action=${BACK}>
        <p>The address may be mistyped, or all of its renders were deleted.</p>
      <//>
    `;
  }
  if (problem) {
    const title = problem.status === 0 ? "The service does not answer" : "The batch cannot be shown";
    return html`<${Notice} title=${title} action=${BACK}><p>${problem.message} Trying again…</p><//>`;
  }
  if (!batch) return html`<${Loading} />`;
  // Of the axes that are not rows or columns, which value is shown; what the address says may be of none.
  const chosen = batch.axes.slice(0, -2).map(({ rows }, axis) => (rows[at[axis]] ? at[axis] : 0));
  const choose = (now) => {
    setAt(now);
    history.replaceState(null, "", `?at=${now.join()}`);
  };
  return html`
    <${Offline} when=${away} />
    <div class="heading">
      <a class="up" href="/" data-route>Renders</a>
      <h1>${name}</h1>
      <span class="fact" role="status">${stated(batch.counts)}</span>
    </div>
    <${Actions} batch=${batch} look=${look} />
    <${Sweep} batch=${batch} at=${chosen} onAt=${choose} />
  `;
}

function useBatch(id) {
  const [batch, setBatch] = useState(null);
  const [problem, setProblem] = useState(null);
  const [away, setAway] = useState(false);
  const [look, setLook] = useState(() => () => {});
  useEffect(() => {
    const abort = new AbortController();
    let timer;
    let last = null;
    async function beat() {
      clearTimeout(timer);
      if (!document.hidden) {
        try {
          last = await getBatch(id, abort.signal);
          setBatch(last);
          setProblem(null);
          setAway(false);
        } catch (error) {
          if (error.name === "AbortError") return;
          if (!last || error.status === 404) setProblem(error);
          else setAway(true);
        }
      }
      clearTimeout(timer); // another beat may have come while this one waited
      if (!abort.signal.aborted) timer = setTimeout(beat, last?.jobs.every((job) => !isActive(job)) ? REST : BEAT);
    }
    const onVisibility = () => document.hidden || beat();
    document.addEventListener("visibilitychange", onVisibility);
    setLook(() => beat);
    beat();
    return () => {
      abort.abort();
      clearTimeout(timer);
      document.removeEventListener("visibilitychange", onVisibility);
    };
  }, [id]);
  return { batch, problem, away, look };
}

function stated(counts) {
  const all = Object.values(counts).reduce((sum, each) => sum + each, 0);
  const others = [["running", "rendering"], ["queued", "queued"], ["cancelling", "stopping"], ["failed", "failed"], ["cancelled", "cancelled"]];
  const said = others.filter(([state]) => counts[state] > 0).map(([state, word]) => `${count(counts[state])} ${word}`);
  return [`${count(counts.succeeded)} of ${count(all)} done`, ...said].join(", ");
}

// What cannot be taken back is asked once more.
function Actions({ batch, look }) {
  const [asking, setAsking] = useState(false);
  const [fault, setFault] = useState(null);
  const active = batch.jobs.filter(isActive).length;

  async function stop() {
    setAsking(false);
    try {
      await cancelBatch(batch.id);
      setFault(null);
    } catch (problem) {
      setFault(problem.message);
    }
    look();
  }

  function remove() {
    const said = `${batch.name || "Batch"} deleted, with ${count(batch.jobs.length)} render${batch.jobs.length === 1 ? "" : "s"}.`;
    putOff({ said, ids: [batch.id], send: async (leaving) => (await deleteBatch(batch.id, leaving)) ?? {} });
    go("/");
  }

  return html`
    <div class="batch-actions">
      <a class="button" href=${`/?batch=${encodeURIComponent(batch.id)}`} data-route>On the wall</a>
      ${active === 0
        ? html`<button type="button" onClick=${remove}>Delete</button>`
        : asking
          ? html`
              <span role="alert">Stop ${count(active)} render${active === 1 ? "" : "s"}?</span>
              <button type="button" onClick=${stop}>Stop</button>
              <button type="button" onClick=${() => setAsking(false)}>Go on</button>
            `
          : html`<button type="button" onClick=${() => setAsking(true)}>Stop all…</button>`}
      ${fault && html`<p class="fault" role="alert">${fault}</p>`}
    </div>
  `;
}

const Loading = () => html`
  <div class="heading" role="status"><a class="up" href="/" data-route>Renders</a><h1>Loading…</h1></div>
`;
