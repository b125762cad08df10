// What can be done with a render: stop it, have it rendered again or better, keep it, forget it.

import { useState } from "preact/hooks";
import { cancelJob, changeJob, deleteJob, extendJob, isActive, retryJob, submitJob } from "../api.js";
import { useFocus, useReturn } from "../focus.js";
import { duration, isDeterministic, target } from "../format.js";
import { html } from "../html.js";
import { go } from "../navigation.js";
import { useOnce } from "../once.js";
import { halved } from "./extend.js";

const pageOf = ({ id }) => `/renders/${encodeURIComponent(id)}`;

// onChange: given what has become of the job
export function Actions({ job, report, onChange }) {
  const active = isActive(job);
  const done = job.state === "succeeded";
  const stop = useOnce(async () => onChange(await cancelJob(job)));
  const retry = useOnce(async (key) => go(pageOf(await retryJob(job, key))));
  const again = useOnce(async (key) => go(pageOf(await submitJob(anew(job), key))));
  const extend = useOnce(async (key, longer) => go(pageOf(await extendJob(job, longer, key))));
  const pin = useOnce(async () => onChange(await changeJob(job, { pinned: !job.pinned })));
  const remove = useOnce(async () => {
    await deleteJob(job);
    go("/");
  });
  const better = done && !isDeterministic(job) && halved(job, report?.contract?.reached);
  const problem = [stop, retry, again, extend, pin, remove].find((each) => each.problem)?.problem;
  return html`
    <section aria-label="What can be done with it">
      ${better && html`
        <button type="button" class="main wide" disabled=${extend.busy} onClick=${() => extend.run(better.stop)}>
          <span>Extend to half the error</span>
          <span class="fact">${`about ${duration(better.seconds)} more, to ${target({ target: better.stop })}`}</span>
        </button>
      `}
      <div class="actions">
        ${active && html`<button type="button" disabled=${stop.busy || job.state === "cancelling"} onClick=${() => stop.run()}>${job.state === "cancelling" ? "Stopping…" : "Cancel"}</button>`}
        ${!active && !done && html`<button type="button" class="main" disabled=${retry.busy} onClick=${() => retry.run()}>Try again</button>`}
        ${done && html`<button type="button" disabled=${again.busy} title="The same scene with other random numbers, as a new render" onClick=${() => again.run()}>Render again</button>`}
        <a class="button" href=${`/submit?from=${encodeURIComponent(job.id)}`} data-route>Edit a copy</a>
        ${done && html`<a class="button" href=${`/compare?renders=${encodeURIComponent(job.id)}`} data-route>Compare</a>`}
        <button type="button" aria-pressed=${String(job.pinned)} disabled=${pin.busy} title="A pinned render is not deleted for its age or for want of room" onClick=${() => pin.run()}>${job.pinned ? "Pinned" : "Pin"}</button>
        ${!active && html`<${Delete} run=${remove.run} busy=${remove.busy} />`}
      </div>
      <p class="fault" role="alert">${problem?.message}</p>
    </section>
  `;
}

// The same request with another seed: the same one would be the same picture once more.
function anew({ scene, name, tags, priority, device, reference }) {
  const [seed] = crypto.getRandomValues(new Uint32Array(1));
  return { scene: { ...scene, seed }, name, tags, priority, device, reference };
}

// Asks before it does: pictures that are gone do not come back.
function Delete({ run, busy }) {
  const [asked, setAsked] = useState(false);
  const button = useReturn(asked);
  return asked
    ? html`<${Sure} run=${run} busy=${busy} onKeep=${() => setAsked(false)} />`
    : html`<button type="button" ref=${button} onClick=${() => setAsked(true)}>Delete…</button>`;
}

function Sure({ run, busy, onKeep }) {
  const keep = useFocus();
  return html`
    <span class="sure" role="group" aria-label="Delete this render and its files?" onKeyDown=${(event) => event.key === "Escape" && onKeep()}>
      <span>Delete it and its files?</span>
      <button type="button" class="grave" disabled=${busy} onClick=${() => run()}>Delete</button>
      <button type="button" ref=${keep} onClick=${onKeep}>Keep</button>
    </span>
  `;
}
