// A render's files.

import { useEffect, useState } from "preact/hooks";
import { isActive } from "../api.js";
import { html } from "../html.js";

// A name that every file system takes
const stem = (job) => job.name.replace(/[^\p{L}\p{N}._-]+/gu, "-").replace(/^[-.]+|[-.]+$/g, "") || job.id;

// whole: is there a report's page?
export function Downloads({ job, whole }) {
  const scene = useScene(job.scene);
  const { image, preview, report, report_page: page } = job.links;
  const name = stem(job);
  const absent = isActive(job) ? "not yet" : "none";
  return html`
    <section>
      <h2>Files</h2>
      <ul class="files">
        <${File} href=${image} name=${`${name}.exr`} label="EXR" about=${image ? "linear, all layers" : absent} />
        <${File} href=${preview} name=${`${name}.png`} label="PNG" about=${preview ? "tone-mapped" : absent} />
        <${File} href=${report} name=${`${name}.report.json`} label="Report" about=${report ? "JSON" : absent} />
        <${File} href=${scene} name=${`${name}.json`} label="Scene" about="JSON" />
        ${whole && html`<li class="whole"><a class="button" href=${page}>Report page <span class="fact">error, pictures of it</span></a></li>`}
      </ul>
    </section>
  `;
}

const File = ({ href, name, label, about }) => html`
  <li>
    ${href
      ? html`<a class="button" href=${href} download=${name}>${label} <span class="fact">${about}</span></a>`
      : html`<span class="button absent" aria-disabled="true">${label} <span class="fact">${about}</span></span>`}
  </li>
`;

// The scene as its file has it.
export const sceneText = (scene) => `${JSON.stringify(scene, null, 2)}\n`;

function useScene(scene) {
  const [href, setHref] = useState(null);
  useEffect(() => {
    const file = new Blob([sceneText(scene)], { type: "application/json" });
    const address = URL.createObjectURL(file);
    setHref(address);
    return () => URL.revokeObjectURL(address);
  }, [scene]);
  return href;
}
