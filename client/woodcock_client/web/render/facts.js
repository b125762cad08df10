// What a render is made of: the request at once, and what the report adds once there is one.

import { Cautions } from "./certificate.js";
import { brief, count, duration, isDeterministic, moment, number, percent, samples, target } from "../format.js";
import { html } from "../html.js";

export function Facts({ job, report, devices }) {
  const { seed } = job.scene;
  const certificate = report?.certificate;
  return html`
    ${certificate && html`<${Cautions} certificate=${certificate} />`}
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
        ${job.retry_of && html`<${Fact} name="Tries again"><${Other} id=${job.retry_of} /><//>`}
        ${job.extends && html`<${Fact} name="Goes on from"><${Other} id=${job.extends} /><//>`}
      </dl>
    </section>
  `;
}

const Other = ({ id }) => html`<a href=${`/renders/${encodeURIComponent(id)}`} data-route>another render</a>`;

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
