// What can be done with a render: stop it, have it rendered again or better, keep it, forget it.

import { cancelJob, changeJob, deleteJobs, extendJob, isActive, retryJob, submitJob } from "../api.js";
import { duration, isDeterministic, target, title } from "../format.js";
import { html } from "../html.js";
import { go } from "../navigation.js";
import { useOnce } from "../once.js";
import { putOff } from "../undo.js";
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
  const pin = useOnce(async () => onChange({ pinned: (await changeJob(job.id, { pinned: !job.pinned })).pinned }));
  const better = done && !isDeterministic(job) && halved(job, report?.contract?.reached);
  const problem = [stop, retry, again, extend, pin].find((each) => each.problem)?.problem;
  return html`
    <section aria-label="What can be done with it">
      ${better && html`
        <button type="button" class="primary wide" disabled=${extend.busy} onClick=${() => extend.run(better.stop)}>
          <span>Extend to half the error</span>
          <span class="fact">${`about ${duration(better.seconds)} more, to ${target({ target: better.stop })}`}</span>
        </button>
      `}
      <div class="actions">
        ${active && html`<button type="button" disabled=${stop.busy || job.state === "cancelling"} onClick=${() => stop.run()}>${job.state === "cancelling" ? "Stopping…" : "Cancel"}</button>`}
        ${!active && !done && html`<button type="button" class="primary" disabled=${retry.busy} onClick=${() => retry.run()}>Try again</button>`}
        ${done && html`<button type="button" disabled=${again.busy} title="The same scene with other random numbers, as a new render" onClick=${() => again.run()}>Render again</button>`}
        <a class="button" href=${`/submit?from=${encodeURIComponent(job.id)}`} data-route>Edit a copy</a>
        ${done && html`<a class="button" href=${`/compare?renders=${encodeURIComponent(job.id)}`} data-route>Compare</a>`}
        <button type="button" aria-pressed=${String(job.pinned)} disabled=${pin.busy} title="A pinned render is not deleted for its age or for want of room" onClick=${() => pin.run()}>${job.pinned ? "Pinned" : "Pin"}</button>
        ${!active && html`<button type="button" onClick=${() => remove(job)}>Delete</button>`}
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

// From the wall on, where it can be undone.
function remove(job) {
  putOff({
    said: `${title(job)} is deleted.`,
    ids: [job.id],
    send: async (leaving) => (await deleteJobs([job.id], leaving)).kept,
  });
  go("/");
}
