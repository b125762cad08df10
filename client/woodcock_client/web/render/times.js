// Where a render's time went.

import { duration, percent } from "../format.js";
import { html } from "../html.js";

const ABOUT = {
  read: "reading the scene’s files",
  build: "compiling its program, or finding it compiled",
  upload: "moving the scene to the device",
  render: "rendering",
  merge: "adding up samples",
  check: "measuring errors and checking laws",
  write: "writing pictures and samples",
};

export function Times({ seconds, utilisation }) {
  const parts = Object.entries(seconds).filter(([, each]) => typeof each === "number" && each >= 0);
  const sum = parts.reduce((total, [, each]) => total + each, 0);
  if (!(sum > 0)) return null;
  return html`
    <section>
      <h2>Where the time went</h2>
      <div class="split" aria-hidden="true">
        ${parts.map(([name, each]) => html`<i key=${name} style=${{ flexGrow: each / sum }}></i>`)}
      </div>
      <dl class="table split-key">
        ${parts.map(([name, each]) => html`
          <div key=${name}><dt>${name}</dt><dd>${duration(each)} <span class="fact">${share(each / sum)}${ABOUT[name] ? `, ${ABOUT[name]}` : ""}</span></dd></div>
        `)}
      </dl>
      ${typeof utilisation === "number" && html`<p class="explain">${`Devices were rendering for ${percent(utilisation)} of their time; meanwhile what they sent was merged, checked and written.`}</p>`}
    </section>
  `;
}

const share = (part) => (part < 0.01 ? "less than 1 %" : `${Math.round(100 * part)} %`);
