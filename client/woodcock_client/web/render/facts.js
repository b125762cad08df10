// What a render is made of: the request at once, and what the report adds once there is one.

import { Cautions, Certificate } from "./certificate.js";
import { ErrorChart } from "./chart.js";
import { brief, count, duration, isDeterministic, moment, number, percent, samples, target } from "../format.js";
import { html } from "../html.js";

export function Facts({ job, report, devices }) {
  const { seed } = job.scene;
  const certificate = report?.certificate;
  return html`
    ${certificate && html`<${Cautions} certificate=${certificate} />`}
    ${report?.error?.length > 1 && html`<${ErrorChart} series=${report.error} />`}
    <section>
      <h2>Facts</h2>
      <dl class="table">
        <${Fact} name="Size">${`${job.width} × ${job.height} pixels`}<//>
        <${Fact} name=${job.target.kind === "relative_error" ? "Stops at" : "Stops after"}>${target(job)} ${report?.contract && html`<${Kept} contract=${report.contract} />`}<//>
        <${Fact} name="Samples">${`${count(job.samples)} per pixel`} ${report?.mean_samples < job.samples && html`<span class="fact">${`at most, ${number(report.mean_samples)} on average`}</span>`}<//>
        ${typeof report?.slope?.slope === "number" && html`<${Fall} slope=${report.slope} />`}
        ${typeof report?.efficiency === "number" &&
        html`<${Fact} name="Efficiency">${number(report.efficiency)} <span class="fact">1 / (variance × seconds)</span><//>`}
        ${report?.against && html`<${Against} against=${report.against} mean=${report.mean_luminance} />`}
        ${job.batch && html`<${Fact} name="Batch"><a href=${`/batches/${encodeURIComponent(job.batch)}`} data-route>${point(job.point)}</a><//>`}
        ${job.reference && html`<${Fact} name="Reference">${brief(job.reference)}<//>`}
        <${Fact} name="Seed">${seed}<//>
        ${job.integrator &&
        html`<${Fact} name="Integrator">${job.integrator} <span class="fact">${isDeterministic(job) ? "without random numbers" : "by random paths"}</span><//>`}
        ${report?.orders && html`<${Rest} orders=${report.orders} mean=${report.mean_luminance} />`}
        <${Fact} name="Submitted"><time dateTime=${job.created_at}>${moment(job.created_at)}</time><//>
        ${job.finished_at &&
        html`<${Fact} name="Finished"><time dateTime=${job.finished_at}>${moment(job.finished_at)}</time><//>`}
        ${job.device !== "any" &&
        html`<${Fact} name="Asked for"><${Devices} ids=${[job.device]} known=${devices} uses=${[]} /><//>`}
        ${job.devices.length > 0 &&
        html`<${Fact} name=${job.devices.length > 1 ? "Devices" : "Device"}><${Devices} ids=${job.devices} known=${devices} uses=${report?.devices ?? []} /><//>`}
        ${report?.program_hash &&
        html`<${Fact} name="Program"><code title=${report.program_hash}>${report.program_hash.slice(0, 12)}</code><//>`}
      </dl>
    </section>
    ${certificate && html`<${Certificate} certificate=${certificate} />`}
    ${report?.devices?.[0]?.media?.length > 0 && html`<${Media} media=${report.devices[0].media} />`}
    ${report?.seconds && html`<${Times} seconds=${report.seconds} utilisation=${report.utilisation} />`}
    ${report?.kinds && html`<${Kinds} kinds=${report.kinds} />`}
  `;
}

const Fact = ({ name, children }) => html`<div><dt>${name}</dt><dd>${children}</dd></div>`;

// Where in a batch a render is.
const point = (values) =>
  Object.entries(values).map(([path, value]) => brief(`${path} = ${JSON.stringify(value)}`)).join(", ");

const Kept = ({ contract: { kind, met, reached } }) => {
  const error = kind === "relative_error" && typeof reached === "number" ? `reached ${percent(reached)}` : "";
  return html`<span class="fact">${met ? error || "kept" : `not kept${error && `: ${error}`}`}</span>`;
};

// How the error fell with time: its exponent, which is -1/2 where samples are independent.
const Fall = ({ slope: { slope, low, high, verdict } }) => {
  const sign = (x) => `${x < 0 ? "−" : ""}${Math.abs(x).toFixed(2)}`;
  const band = typeof low === "number" && typeof high === "number" ? `, ${sign(low)} to ${sign(high)} with 95 %` : "";
  return html`<${Fact} name="Error falls as">t<sup>${sign(slope)}</sup> <span class="fact">${verdict}${band}</span><//>`;
};

// The picture against its reference: how far a pixel is off, and the mean of all of them.
const Against = ({ against: { mse, bias, bias_error: error, flip }, mean }) => {
  const share = (value) => (mean > 0 ? percent(value / mean) : number(value));
  const said = [
    `mean off by ${share(bias)}${typeof error === "number" ? ` ± ${share(error)}` : ""}`,
    typeof flip === "number" && `ꟻLIP ${number(flip)}`,
  ];
  return html`<${Fact} name="True error">${share(Math.sqrt(Math.max(0, mse)))} <span class="fact">${said.filter(Boolean).join(", ")}</span><//>`;
};

const STABILITY = {
  failed: "failed its stability check",
  running: "its stability is being checked",
  "not checked": "its stability is not checked",
};

// The name is the device's own; the report adds its part in the render. What is said of its stability is of now, and
// of no other device that has come to bear its id.
const Devices = ({ ids, known, uses }) =>
  ids.map((id) => {
    const use = uses.find((each) => each.id === id);
    const present = known.find((each) => each.id === id);
    const device = use ?? present;
    const stability = present?.name === device?.name && STABILITY[present?.stability];
    const precise = use?.precision === "double" ? ", in double precision" : "";
    const part = use && `${id}: ${samples(use.samples)} in ${duration(use.render_seconds)}, ${use.lanes} at a time${precise}`;
    return html`<span class="device" key=${id}>${device?.name ?? id} <span class="fact">${part ?? (device ? id : "")}</span>${stability && html`<span class="stability ${present.stability}">${stability}</span>`}</span>`;
  });

// What the orders of scattering beyond the last that has a layer of its own amount to.
function Rest({ orders, mean }) {
  const { last, rest, rest_error: error, rest_bound: bound } = orders;
  const share = (value) => (mean > 0 ? percent(value / mean) : number(value));
  const known = (value) => typeof value === "number";
  const limit = known(bound) && bound < mean; // one of all the light and more says nothing
  const said = `${share(rest)}${known(error) ? ` ± ${share(error)}` : ""}${mean > 0 ? " of the light" : ""}`;
  return html`<${Fact} name=${`After order ${last}`}>${said} ${limit && html`<span class="fact">at most ${share(bound)}</span>`}<//>`;
}

function Media({ media }) {
  return html`
    <section>
      <h2>${media.length > 1 ? "Media" : "Medium"}</h2>
      <dl class="table">
        ${media.map((each, index) => html`<${Fact} key=${index} name=${each.kind}><${Medium} medium=${each} /><//>`)}
      </dl>
    </section>
  `;
}

function Medium({ medium }) {
  const { sigma_t: sigma, storage, scatters, emits, coloured } = medium;
  const does = [scatters ? "scatters" : "absorbs", emits && "emits", coloured && "in colour"].filter(Boolean);
  return html`
    ${does.join(", ")} <span class="fact">${`σₜ up to ${sigma.map(number).join(", ")}`}</span>
    ${Object.entries(storage ?? {}).map(([name, { kind, error }]) => html`
      <span class="device" key=${name}>${name} <span class="fact">${`stored as ${kind}, ${error > 0 ? `off by ${percent(error)} of its largest at most` : "exactly"}`}</span></span>
    `)}
  `;
}

function Times({ seconds, utilisation }) {
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
      ${typeof utilisation === "number" && html`<p class="explain">${`Devices were rendering for ${percent(utilisation)} of their time; meanwhile what they sent was merged, checked and written.`}</p>`}
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
