// Scenes to start from.

import { useEffect, useRef, useState } from "preact/hooks";
import { listExamples } from "../api.js";
import { html } from "../html.js";
import { withFiles } from "./insert.js";

// open: at the start; uploads: by which an example's files go to the service; onScene(scene, name)
export function Examples({ open, uploads, onScene }) {
  const [examples, setExamples] = useState([]);
  const [busy, setBusy] = useState(null);
  const [fault, setFault] = useState(null);
  const [opened] = useState(open); // what is open stays so while somebody writes
  const list = useRef();
  useEffect(() => {
    const abort = new AbortController();
    const ignore = () => {}; // the page does without
    listExamples(abort.signal).then(({ items }) => setExamples(items), ignore);
    return () => abort.abort();
  }, []);

  async function choose({ name, scene, files }) {
    setBusy(name);
    setFault(null);
    const ids = {};
    try {
      for (const [file, address] of Object.entries(files)) {
        const response = await fetch(address);
        if (!response.ok) throw new Error(`${file} cannot be had: the service answered ${response.status}.`);
        const volume = await uploads.add(new File([await response.blob()], file));
        if (volume) ids[file] = volume.id; // else its fault is shown
      }
      onScene(withFiles(scene, ids), name);
      list.current.open = false; // what was chosen takes its room
    } catch (error) {
      setFault(error.message);
    }
    setBusy(null);
  }

  return html`
    <details class="examples" ref=${list} open=${opened}>
      <summary>Examples</summary>
      <p class="fault" role="alert">${fault}</p>
      <ul>
        ${examples.map((example) => html`
          <li key=${example.name}>
            <button type="button" disabled=${busy !== null} aria-describedby=${`about-${example.name}`} onClick=${() => choose(example)}>
              <img src=${example.picture} alt="" width="240" height="180" />
              <span class="name">${busy === example.name ? "Loading…" : example.name}</span>
            </button>
            <p class="fact" id=${`about-${example.name}`}>${example.about}</p>
          </li>
        `)}
      </ul>
    </details>
  `;
}
