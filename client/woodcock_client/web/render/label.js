// A render's name and tags, changed where they stand.

import { useState } from "preact/hooks";
import { changeJob } from "../api.js";
import { useFocus, useReturn } from "../focus.js";
import { title } from "../format.js";
import { html } from "../html.js";
import { useOnce } from "../once.js";

// onChange: given what has become of the job
export function Name({ job, onChange }) {
  const [editing, setEditing] = useState(false);
  const button = useReturn(editing);
  const { busy, problem, run } = useOnce(async (_, name) => {
    if (name !== job.name) onChange({ name: (await changeJob(job.id, { name })).name });
    setEditing(false);
  });
  if (!editing) {
    return html`
      <h1>${title(job)}</h1>
      <button type="button" class="small" ref=${button} onClick=${() => setEditing(true)}>Rename</button>
    `;
  }
  return html`
    <form class="rename" onSubmit=${(event) => { event.preventDefault(); run(new FormData(event.target).get("name").trim()); }}>
      <h1 class="hidden">${title(job)}</h1>
      <${Field} label="Name" name="name" value=${job.name} most="200" busy=${busy} onLeave=${() => setEditing(false)} />
      <button class="small" disabled=${busy}>Save</button>
      <button type="button" class="small" onClick=${() => setEditing(false)}>Leave it</button>
      <span class="fault" role="alert">${problem?.message}</span>
    </form>
  `;
}

function Field({ label, name, value, most, busy, onLeave }) {
  const field = useFocus();
  return html`
    <input ref=${field} name=${name} aria-label=${label} placeholder=${label} defaultValue=${value} maxlength=${most} readonly=${busy} onKeyDown=${(event) => event.key === "Escape" && onLeave()} />
  `;
}

export function Tags({ job, onChange }) {
  const [adding, setAdding] = useState(false);
  const button = useReturn(adding);
  const { busy, problem, run } = useOnce(async (_, tags) => {
    onChange({ tags: (await changeJob(job.id, { tags })).tags });
    setAdding(false);
    button.current?.focus(); // the tag that was removed had it
  });
  function add(event) {
    event.preventDefault();
    const tag = new FormData(event.target).get("tag").trim();
    if (tag) run([...job.tags, tag]);
    else setAdding(false);
  }
  return html`
    <ul class="labels" aria-label="Tags">
      ${job.tags.map((tag) => html`
        <li key=${tag} class="tag">
          <a href=${`/?tag=${encodeURIComponent(tag)}`} data-route>${tag}</a>
          <button type="button" aria-label=${`Remove the tag ${tag}`} disabled=${busy} onClick=${() => run(job.tags.filter((each) => each !== tag))}>×</button>
        </li>
      `)}
      <li>
        ${adding
          ? html`<form class="rename" onSubmit=${add}><${Field} label="New tag" name="tag" value="" most="64" busy=${busy} onLeave=${() => setAdding(false)} /><button class="small" disabled=${busy}>Add</button></form>`
          : html`<button type="button" class="small" ref=${button} onClick=${() => setAdding(true)}>Add tag</button>`}
      </li>
      <li><span class="fault" role="alert">${problem?.message}</span></li>
    </ul>
  `;
}
