// Which renders to compare: those that are chosen already, and others of the same size to choose from.

import { useEffect, useState } from "preact/hooks";
import { findFinished, getJob } from "../api.js";
import { ago, count, title } from "../format.js";
import { html } from "../html.js";
import { Picture } from "../picture.js";
import { goTo, MOST } from "./address.js";

const WAIT = 200; // ms of quiet typing before it is searched for

// Those that a job has to do with: what it was held against, went on from or tried again, and its batch.
async function relatedTo({ reference, extends: before, retry_of: first, batch }, signal) {
  const ids = [reference, before, first].filter((id) => id && !id.startsWith("sha256:"));
  const jobs = await Promise.all(ids.map((id) => getJob(id, signal).catch(() => null)));
  const { items } = batch ? await findFinished({ batch }, signal) : { items: [] };
  const all = [...jobs.filter((job) => job?.state === "succeeded"), ...items];
  return [...new Map(all.map((job) => [job.id, job])).values()];
}

export function Picker({ chosen }) {
  const [text, setText] = useState("");
  const [found, setFound] = useState(null);
  const [problem, setProblem] = useState(null);
  const [picked, setPicked] = useState(chosen);
  const size = picked[0];

  useEffect(() => {
    const abort = new AbortController();
    const search = async () => {
      try {
        const [{ items }, related] = await Promise.all([
          findFinished(text ? { text } : {}, abort.signal),
          chosen.length > 0 && !text ? relatedTo(chosen[0], abort.signal) : [],
        ]);
        const ids = new Set(related.map(({ id }) => id));
        setFound([...related, ...items.filter(({ id }) => !ids.has(id))]);
        setProblem(null);
      } catch (error) {
        if (error.name !== "AbortError") setProblem(error);
      }
    };
    const timer = setTimeout(search, text ? WAIT : 0);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [text]);

  const fits = (job) => !size || (job.width === size.width && job.height === size.height);
  const isPicked = (job) => picked.some(({ id }) => id === job.id);
  const others = (found ?? []).filter((job) => fits(job) && !isPicked(job));
  const left = (found ?? []).filter((job) => !fits(job)).length;
  const toggle = (job) => setPicked(isPicked(job) ? picked.filter(({ id }) => id !== job.id) : [...picked, job].slice(0, MOST));
  const compare = (event) => {
    event.preventDefault();
    if (picked.length > 1) goTo(picked.map(({ id }) => id));
  };

  return html`
    <div class="heading">
      <a class="up" href="/" data-route>Renders</a>
      <h1>Compare</h1>
    </div>
    <p class="fact">Choose two to four finished renders of one size. The first is what the others are held against.</p>
    <form class="picker" role="search" onSubmit=${compare}>
      <label>Name <input type="search" value=${text} onInput=${(event) => setText(event.target.value)} /></label>
      <button type="submit" class="primary" disabled=${picked.length < 2}>${picked.length < 2 ? "Compare" : `Compare these ${picked.length}`}</button>
    </form>
    <ul class="picks" aria-label="Renders to choose from">
      ${[...picked, ...others].map((job) => html`
        <li key=${job.id}>
          <label class=${isPicked(job) ? "picked" : ""}>
            <div class="stage"><${Picture} job=${job} every=${0} lazy /></div>
            <span class="title">
              <input type="checkbox" checked=${isPicked(job)} disabled=${!isPicked(job) && picked.length === MOST} onChange=${() => toggle(job)} />
              <span title=${title(job)}>${title(job)}</span>
            </span>
            <span class="fact">${`${job.width} × ${job.height} · ${ago(job.created_at, Date.now())}`}</span>
          </label>
        </li>
      `)}
    </ul>
    <p class="fact" role="status">
      ${problem ? `${problem.message} ` : ""}
      ${found && others.length === 0 ? "No other finished render has that name and size." : ""}
      ${size && left > 0 ? `${count(left)} of another size ${left === 1 ? "is" : "are"} not shown.` : ""}
    </p>
  `;
}
