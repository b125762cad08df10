// Where a picture comes from, exactly: enough to make it again.

import { useEffect, useState } from "preact/hooks";
import { brief } from "../format.js";
import { html } from "../html.js";
import { sceneText } from "./downloads.js";

export function Provenance({ job, report }) {
  const digest = useDigest(job.scene);
  const ranges = (report.sample_ranges ?? []).map(([start, stop]) => `${start} to ${stop - 1}`).join(", ");
  const files = filesOf(job.scene);
  return html`
    <section>
      <h2>How to make it again</h2>
      <dl class="table">
        <${Row} name="Version">${report.version && `Woodcock ${report.version}`}<//>
        <${Row} name="Program">${report.program_hash && html`<code>${report.program_hash}</code>`}<//>
        <${Row} name="Scene">${digest && html`<code>${digest}</code> <span class="fact">SHA-256 of the scene’s file</span>`}<//>
        <${Row} name="Seed">${job.scene.seed}<//>
        <${Row} name="Samples">${ranges}<//>
        ${(report.devices ?? []).map((use) => html`
          <${Row} key=${use.id} name="Device">
            ${use.name} <span class="fact">${[use.id, use.platform_version ?? use.platform, use.driver && `driver ${use.driver}`, `${use.lanes} paths in lockstep`, use.precision === "double" && "double precision"].filter(Boolean).join(", ")}</span>
          <//>
        `)}
        <${Row} name="Reference">${report.reference && brief(report.reference)}<//>
        ${files.map(([path, id]) => html`
          <${Row} key=${path} name="File"><a href=${`/api/v1/volumes/${id}`}><code>${id}</code></a> <span class="fact">${path}</span><//>
        `)}
      </dl>
      <${Command} job=${job} />
      ${job.target.kind === "seconds" && html`
        <p class="explain">How many samples fit into the time depends on the machine. With <code>${`"stop": {"kind": "samples", "samples": ${job.samples}}`}</code> it is this picture again.</p>
      `}
    </section>
  `;
}

const Row = ({ name, children }) => {
  const said = [children].flat().some((each) => each !== null && each !== undefined && each !== false && each !== "");
  return said && html`<div><dt>${name}</dt><dd>${children}</dd></div>`;
};

// The files that a scene names, by where: [path, id].
function filesOf(value, path = "") {
  if (Array.isArray(value)) return value.flatMap((each, index) => filesOf(each, `${path}[${index}]`));
  if (value === null || typeof value !== "object") return [];
  return Object.entries(value).flatMap(([key, each]) => {
    const at = path ? `${path}.${key}` : key;
    return key === "file" && typeof each === "string" ? [[at, each]] : filesOf(each, at);
  });
}

// In hexadecimal; null until it is known, and where the browser counts no digests, which takes HTTPS or this machine.
function useDigest(scene) {
  const [digest, setDigest] = useState(null);
  useEffect(() => {
    if (!globalThis.crypto?.subtle) return;
    crypto.subtle.digest("SHA-256", new TextEncoder().encode(sceneText(scene))).then((bytes) =>
      setDigest([...new Uint8Array(bytes)].map((byte) => byte.toString(16).padStart(2, "0")).join("")));
  }, [scene]);
  return digest;
}

// What renders it again on this service, once the scene has been saved.
function Command({ job }) {
  const [copied, setCopied] = useState(false);
  const device = job.devices.length === 1 ? ` --device ${job.devices[0]}` : "";
  const command = `woodcock submit scene.json --server ${location.origin}${device} --follow -o picture.exr`;
  const copy = () => navigator.clipboard.writeText(command).then(() => setCopied(true), () => setCopied(false));
  return html`
    <p class="explain">Save the scene as <code>scene.json</code> (under Files), then:</p>
    <div class="command">
      <pre tabindex="0" aria-label="Command">${command}</pre>
      ${navigator.clipboard && html`<button type="button" class="small" onClick=${copy}>${copied ? "Copied" : "Copy"}</button>`}
      <span class="hidden" role="status">${copied ? "The command is copied." : ""}</span>
    </div>
  `;
}
