// The devices, a card each: what it is, what it does now, how fast it was, and whether it is to be trusted.

import { ago, bytes, count, moment, number, title } from "../format.js";
import { html } from "../html.js";
import { Badge, Bar } from "../states.js";
import { Check } from "./stability.js";

const STATES = { ready: "Ready", distrusted: "Distrusted", failed: "Cannot be used" };
const COLOURS = { ready: "succeeded", distrusted: "failed", failed: "failed" };
const KINDS = { cpu: "CPU", gpu: "GPU", accelerator: "Accelerator" };

// devices: null while they are not known; running: jobs; ask: for the devices anew
export function Devices({ devices, running, ask }) {
  return html`
    <section aria-labelledby="devices">
      <h2 id="devices">Devices</h2>
      ${devices === null && html`<ul class="devices" aria-hidden="true"><li class="device-card ghost-card"></li><li class="device-card ghost-card"></li></ul>`}
      ${devices?.length === 0 && html`
        <div class="empty">
          <p>No device was found when the service started: it takes renders, and they wait.</p>
          <p class="fact">Install an OpenCL driver (PoCL for CPUs, the maker’s for GPUs) and start the service again; <code>woodcock devices</code> lists what it sees.</p>
        </div>
      `}
      ${devices?.length > 0 && html`
        <ul class="devices">
          ${devices.map((device) => html`
            <${Device} key=${device.id} device=${device} job=${running.find(({ id }) => id === device.job)} ask=${ask} />
          `)}
        </ul>
      `}
    </section>
  `;
}

function Device({ device, job, ask }) {
  const { id, name, platform, driver, kind, compute_units: units, memory, lanes, speed, state, stability } = device;
  return html`
    <li class="device-card">
      <div class="line">
        <h3>${name}</h3>
        <${Badge} state=${stability === "running" ? "running" : COLOURS[state]} label=${stability === "running" ? "Being checked" : STATES[state]} />
      </div>
      <p class="fact">${[id, KINDS[kind] ?? kind, `${units} compute unit${units === 1 ? "" : "s"}`, bytes(memory)].join(" · ")}</p>
      <p class="fact">${`${platform}, driver ${driver}`}</p>
      <${Trouble} device=${device} />
      <dl class="table">
        <div>
          <dt>Now</dt>
          <dd><${Now} device=${device} job=${job} /></dd>
        </div>
        <div>
          <dt>Waiting</dt>
          <dd>${device.waiting === 0 ? "nothing" : `${count(device.waiting)} render${device.waiting === 1 ? "" : "s"}`}</dd>
        </div>
        <div>
          <dt>Speed</dt>
          <dd>${speed === null ? html`<span class="fact">not known before it has rendered</span>` : html`${rate(speed)} <span class="fact">when it last rendered</span>`}</dd>
        </div>
        <div>
          <dt>Lanes</dt>
          <dd>${lanes.length ? html`${lanes.join(", ")} <span class="fact">paths in lockstep</span>` : "none work"}</dd>
        </div>
        <div>
          <dt>Stability</dt>
          <dd>${state === "failed" ? "cannot be checked" : html`<${Trust} device=${device} />`}</dd>
        </div>
      </dl>
      ${state !== "failed" && html`<${Check} device=${device} ask=${ask} />`}
    </li>
  `;
}

const rate = (speed) =>
  speed >= 1e6 ? `${number(speed / 1e6)} million samples a second` : `${count(speed)} samples a second`;

function Now({ device, job }) {
  if (!device.job) return device.stability === "running" ? "its stability check" : html`<span class="fact">idle</span>`;
  return html`
    <a href=${`/renders/${encodeURIComponent(device.job)}`} data-route>${job ? title(job) : "a render"}</a>
    ${job && html`<span class="fact">${Math.floor(100 * job.fraction)} %</span><${Bar} job=${job} label=${`Progress of ${title(job)}`} />`}
  `;
}

// Why a device is not trusted, or cannot be used.
function Trouble({ device: { state, fault, failures } }) {
  if (state === "ready") return null;
  const lost = failures.filter((each) => each.startsWith("jobs, "));
  const [heading, about] =
    state === "failed"
      ? ["It cannot even build and run a program.", "It renders nothing until the service starts again and finds it well."]
      : lost.length
        ? ["It is in quarantine: renders were lost on it, one after the other.", "It renders only what asks for it by its id, until a check has passed."]
        : ["It failed its stability check.", "Its pictures may be wrong, so it renders only what asks for it by its id, until a check has passed."];
  return html`
    <div class="trouble">
      <p><b>${heading}</b> ${about}</p>
      <ul>${[fault, ...failures].filter(Boolean).map((says) => html`<li key=${says}>${says}</li>`)}</ul>
    </div>
  `;
}

const TRUST = {
  "not checked": "not checked; it is trusted until it fails",
  running: "being checked",
  passed: "passed",
  failed: "failed",
};

const Trust = ({ device: { stability, checked_at: at } }) => html`
  ${TRUST[stability]} ${at && html`<time class="fact" dateTime=${at} title=${moment(at)}>${stability === "running" ? "last " : ""}${ago(at, Date.now())}</time>`}
`;
