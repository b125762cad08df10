// What a render is made of: the request at once, and what the report adds once there is one.

import { ErrorChart } from "./chart.js";
import { count, duration, moment, target } from "./format.js";
import { html } from "./html.js";

export function Facts({ job, report, devices }) {
  const { seed, stop } = job.scene;
  return html`
    ${report && html`<${Cautions} report=${report} />`}
    ${report?.error?.length > 1 && html`<${ErrorChart} series=${report.error} />`}
    <section>
      <h2>Facts</h2>
      <dl class="table">
        <${Fact} name="Size">${`${job.width} × ${job.height} pixels`}<//>
        <${Fact} name="Stops after">${target(job)}<//>
        <${Fact} name="Samples">${`${count(job.samples)} per pixel`}<//>
        <${Fact} name="Seed">${seed}<//>
        <${Fact} name="Submitted"><time dateTime=${job.created_at}>${moment(job.created_at)}</time><//>
        ${job.finished_at &&
        html`<${Fact} name="Finished"><time dateTime=${job.finished_at}>${moment(job.finished_at)}</time><//>`}
        ${job.devices.length > 0 &&
        html`<${Fact} name=${job.devices.length > 1 ? "Devices" : "Device"}><${Devices} ids=${job.devices} known=${devices} uses=${report?.devices ?? []} /><//>`}
        ${report?.program_hash &&
        html`<${Fact} name="Program"><code title=${report.program_hash}>${report.program_hash.slice(0, 12)}</code><//>`}
      </dl>
    </section>
    ${report?.seconds && html`<${Times} seconds=${report.seconds} />`}
    ${report?.kinds && html`<${Kinds} kinds=${report.kinds} />`}
  `;
}

const Fact = ({ name, children }) => html`<div><dt>${name}</dt><dd>${children}</dd></div>`;

// The name is the device's own; the report adds its part in the render.
const Devices = ({ ids, known, uses }) =>
  ids.map((id) => {
    const use = uses.find((each) => each.id === id);
    const device = use ?? known.find((each) => each.id === id);
    const part = use && `${id}: ${count(use.samples)} samples in ${duration(use.render_seconds)}, ${use.lanes} at a time`;
    return html`<span class="device" key=${id}>${device?.name ?? id} <span class="fact">${part ?? (device ? id : "")}</span></span>`;
  });

// What would make a reader doubt the picture is said before anything else.
function Cautions({ report }) {
  const { rejected_samples: rejected, majorant_violations: violations } = report;
  if (!rejected && !violations) return null;
  return html`
    <section class="caution">
      <h2>Take care with this picture</h2>
      ${rejected > 0 &&
      html`<p>${count(rejected)} sample${rejected === 1 ? " was" : "s were"} not a finite number and left out.</p>`}
      ${violations > 0 &&
      html`<p>The density exceeded its majorant ${count(violations)} time${violations === 1 ? "" : "s"}: the picture may be biased.</p>`}
    </section>
  `;
}

function Times({ seconds }) {
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
        ${parts.map(([name, each]) => html`<${Fact} key=${name} name=${name}>${duration(each)}<//>`)}
      </dl>
    </section>
  `;
}

const Kinds = ({ kinds }) => html`
  <section>
    <h2>Compiled in</h2>
    <p class="explain">The program holds these kinds and no others; what the scene does not use costs nothing.</p>
    <dl class="table">
      ${Object.entries(kinds).map(([concept, names]) => html`
        <${Fact} key=${concept} name=${concept}>${names.length ? names.join(", ") : "none"}<//>
      `)}
    </dl>
  </section>
`;
