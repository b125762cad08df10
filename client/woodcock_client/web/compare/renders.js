// The renders that are compared: what each took, and what it would take to be as good as the reference, or in its time.

import { duration, number, percent, samples, title } from "../format.js";
import { html } from "../html.js";

// 1 / (variance × seconds), which samples do not change; null without noise.
const efficiency = (report) => report?.efficiency ?? null;

export const Renders = ({ jobs, reports, reference, shown, onReference, onShown }) => html`
  <section class="compared">
    <h2>Renders</h2>
    <ul>
      ${jobs.map((job, place) => html`
        <li key=${job.id} class=${place === shown ? "shown" : ""}>
          <h3>
            <button type="button" class="digit" aria-label=${`Show ${place + 1}, ${title(job)}`} aria-pressed=${String(place === shown)} onClick=${() => onShown(place)}>${place + 1}</button>
            <a href=${`/renders/${encodeURIComponent(job.id)}`} data-route>${title(job)}</a>
          </h3>
          <p class="fact">${facts(job).join(" · ")}</p>
          <p class="fact">${place === reference ? "" : ratio(efficiency(reports[place]), efficiency(reports[reference]))}</p>
          <label class="fact"><input type="radio" name="reference" checked=${place === reference} onChange=${() => onReference(place)} /> Reference</label>
        </li>
      `)}
    </ul>
  </section>
`;

function facts(job) {
  const said = [samples(job.samples), duration(job.seconds)];
  if (job.relative_rmse !== null) said.push(`±${percent(job.relative_rmse)}`);
  return said;
}

// How the two compare at equal time, and at equal error: variance × time is what it is however long one renders.
export function ratio(mine, its) {
  if (mine === null || its === null) return "";
  const times = mine / its;
  const [more, factor] = times >= 1 ? ["less", times] : ["more", 1 / times];
  if (factor < 1.005) return "As efficient as the reference.";
  return (
    `${number(times)} × the reference’s efficiency: in equal time ${number(Math.sqrt(factor))} × ${more} error, ` +
    `for equal error ${number(factor)} × ${more} time.`
  );
}
