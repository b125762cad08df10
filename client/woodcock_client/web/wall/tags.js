// A dialogue in which tags are put on renders and taken off them.

import { useEffect, useRef, useState } from "preact/hooks";
import { changeJob } from "../api.js";
import { count } from "../format.js";
import { html } from "../html.js";

const AT_ONCE = 4; // requests: browsers allow six connections to one address

// onChanged: of a job as the service has it then
export function Tags({ jobs, onDone, onChanged }) {
  const dialog = useRef();
  const [wanted, setWanted] = useState(() => new Map()); // tag -> whether all are to have it, or none
  const [busy, setBusy] = useState(false);
  const [fault, setFault] = useState(null);
  useEffect(() => dialog.current.showModal(), []);

  const found = new Map();
  for (const tag of jobs.flatMap((job) => job.tags)) found.set(tag, (found.get(tag) ?? 0) + 1);
  const shown = [...new Set([...found.keys(), ...wanted.keys()])].sort();
  const set = (tag, on) => setWanted(new Map(wanted).set(tag, on));

  async function save(event) {
    event.preventDefault();
    const typed = event.target.elements.tag.value.trim();
    const after = typed ? new Map(wanted).set(typed, true) : wanted;
    setBusy(true);
    const { failed, why } = await retag(jobs, after, onChanged);
    if (failed === 0) return dialog.current.close();
    setBusy(false);
    return setFault(`${count(failed)} of ${count(jobs.length)} could not be changed. ${why}`);
  }

  return html`
    <dialog class="tagging" ref=${dialog} aria-labelledby="tags-title" onClose=${onDone}>
      <form onSubmit=${save}>
        <h2 id="tags-title">Tags of ${count(jobs.length)} render${jobs.length === 1 ? "" : "s"}</h2>
        ${shown.length > 0 && html`
          <ul class="tag-list">
            ${shown.map((tag) => {
              const number = found.get(tag) ?? 0;
              const on = wanted.get(tag) ?? number === jobs.length;
              const some = !wanted.has(tag) && number > 0 && number < jobs.length;
              return html`
                <li key=${tag}>
                  <label><input type="checkbox" checked=${on} indeterminate=${some} onChange=${(event) => set(tag, event.currentTarget.checked)} /> ${tag}</label>
                  ${some && html`<span class="fact">${count(number)} of ${count(jobs.length)}</span>`}
                </li>
              `;
            })}
          </ul>
        `}
        <label for="new-tag">New tag</label>
        <input id="new-tag" name="tag" maxlength="64" autocomplete="off" />
        <p class="fault" role="alert">${fault}</p>
        <p class="actions">
          <button disabled=${busy}>Save</button>
          <button type="button" class="plain" onClick=${() => dialog.current.close()}>Cancel</button>
        </p>
      </form>
    </dialog>
  `;
}

// How many jobs could not be given the tags, and why the first could not.
async function retag(jobs, wanted, onChanged) {
  const left = jobs.slice();
  let failed = 0;
  let why = "";
  async function work() {
    for (let job = left.pop(); job; job = left.pop()) {
      const tags = new Set(job.tags);
      for (const [tag, on] of wanted) on ? tags.add(tag) : tags.delete(tag);
      const after = [...tags].sort();
      if (after.join("\n") === job.tags.join("\n")) continue;
      try {
        onChanged(await changeJob(job.id, { tags: after }));
      } catch (problem) {
        failed += 1;
        why ||= problem.message;
      }
    }
  }
  await Promise.all(Array.from({ length: AT_ONCE }, work));
  return { failed, why };
}
