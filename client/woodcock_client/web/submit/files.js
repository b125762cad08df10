// Uploads: on their way with how far they are, and those that the service has.

import { useRef, useState } from "preact/hooks";
import { percent } from "../format.js";
import { html } from "../html.js";
import { Contents, inBrief } from "./volume.js";

// onUse(volume, more): puts it into the scene
export function Files({ uploads, onFiles, onUse }) {
  const { volumes, next, problem, sending, more, drop } = uploads;
  const chooser = useRef();
  const chosen = (event) => {
    onFiles([...event.target.files]);
    event.target.value = ""; // so that the same file can be chosen again
  };
  return html`
    <section aria-labelledby="files">
      <h2 id="files">Files</h2>
      <input ref=${chooser} type="file" multiple hidden onChange=${chosen} aria-label="Files to upload" />
      <button type="button" class="drop" onClick=${() => chooser.current.click()}>
        Upload volumes, meshes, pictures
        <span class="fact">or drop them anywhere on this page</span>
      </button>
      <ul class="sending">
        ${sending.map((one) => html`<${Sending} key=${one.key} upload=${one} onDrop=${() => drop(one.key)} />`)}
      </ul>
      ${volumes?.map((volume) => html`<${Stored} key=${volume.id} volume=${volume} onUse=${(how) => onUse(volume, how)} />`)}
      ${!volumes && html`<p class="fact" role="status">${problem ? `They cannot be listed: ${problem.message}` : "Loading…"}</p>`}
      ${volumes && next && html`<button type="button" onClick=${more}>Older files</button>`}
      ${!volumes && problem && html`<button type="button" onClick=${more}>Try again</button>`}
    </section>
  `;
}

function Sending({ upload: { name, share, problem }, onDrop }) {
  if (problem) {
    return html`
      <li class="refusal" role="alert">
        <p>${problem.message.startsWith(name) ? problem.message : `${name}: ${problem.message}`}</p>
        <button type="button" onClick=${onDrop}>Dismiss</button>
      </li>
    `;
  }
  const said = share < 1 ? percent(Math.floor(100 * share) / 100) : "being read…";
  return html`
    <li>
      <div class="line"><span class="name">${name}</span><span class="fact">${said}</span></div>
      <div class="progress" role="progressbar" aria-label=${`Upload of ${name}`} aria-valuemin="0" aria-valuemax="100" aria-valuenow=${Math.round(100 * share)}>
        <i style=${{ transform: `scaleX(${share})` }}></i>
      </div>
    </li>
  `;
}

function Stored({ volume, onUse }) {
  const [open, setOpen] = useState(false);
  return html`
    <details class="stored" onToggle=${(event) => setOpen(event.target.open)}>
      <summary><span class="name" title=${volume.id}>${volume.name}</span> <span class="fact">${inBrief(volume)}</span></summary>
      ${open && html`<div class="contents"><${Contents} volume=${volume} onUse=${onUse} /></div>`}
    </details>
  `;
}
