// A dry run in plain words: whether it can be rendered, how long that takes, and what it needs.

import { bytes, count, duration, percent } from "../format.js";
import { html } from "../html.js";

// Seconds that one render takes with all devices that can, null if that is not known.
export function secondsOf({ contract, devices }) {
  if (contract.kind === "seconds") return contract.seconds;
  const rates = devices.filter(({ fits, seconds }) => fits && seconds > 0).map(({ seconds }) => 1 / seconds);
  return rates.length > 0 ? 1 / rates.reduce((a, b) => a + b) : null;
}

// renders: how many of them are meant; old: is it of what was written before?
export function Estimate({ check, renders, old }) {
  const { devices, memory, program } = check;
  const seconds = secondsOf(check);
  const able = devices.filter(({ fits }) => fits !== false);
  return html`
    <div class="estimate" role="status">
      ${old && html`<p>Of the scene as it was before:</p>`}
      <p class="total">
        ${able.length === 0 ? "No device can render this." : seconds === null ? "How long it takes is not known." : total(seconds, renders)}
      </p>
      ${devices.map((device) => html`<p key=${device.id}><strong>${device.id}</strong> ${forecast(device)}</p>`)}
      ${memory && html`<p>Takes ${bytes(memory.device)} on the device${memory.host > 0 ? `, ${bytes(memory.host)} of the service’s memory` : ""}.</p>`}
      ${program && html`<p>${compiled(program)}</p>`}
      ${program && html`<p>Made of ${Object.values(program.kinds).flat().map((kind) => kind.replaceAll("_", " ")).join(", ")}.</p>`}
    </div>
  `;
}

const total = (seconds, renders) =>
  renders > 1 ? `${count(renders)} renders, together about ${duration(renders * seconds)}` : `About ${duration(seconds)}`;

function forecast({ fits, reason, seconds, low, high, error, says }) {
  if (fits === false) return `cannot render it: ${reason}`;
  const alone = seconds === null ? "can render it" : `alone: ${duration(seconds)}${interval(low, high)}`;
  const wrong = error === null ? "" : `; error then about ${percent(error)}`;
  return `${alone}${wrong}. ${says}`;
}

const interval = (low, high) =>
  low === null ? "" : high === null ? `, ${duration(low)} at least` : `, most likely ${duration(low)} to ${duration(high)}`;

function compiled({ source_lines: lines, left_out: left, built }) {
  const without = Object.values(left).reduce((a, b) => a + b, 0);
  const rest = without > 0 ? `; ${count(without)} lines that it does not need are left out` : "";
  return `Its program has ${count(lines)} lines${rest}. ${built ? "It was built before." : "It is built now, and kept."}`;
}
