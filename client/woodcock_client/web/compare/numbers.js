// How far each render is from the reference, in numbers: a row for each measure, with its formula and what it means.

import { number, percent, title } from "../format.js";
import { html } from "../html.js";

const share = (x) => (typeof x === "number" ? percent(x) : "–");
const known = (x) => (typeof x === "number" ? number(x) : "–");

// of: from a difference (differences/schemas.py) to text
export const MEASURES = [
  {
    name: "MSE",
    formula: "⟨(I − R)²⟩ − ⟨var R⟩",
    says: "Mean square error, in radiance squared, without the reference’s own noise. 0 is equal; twice the samples halve what of it is noise.",
    of: (d) => known(d.mse),
  },
  {
    name: "of which noise",
    formula: "⟨var I⟩",
    says: "What the render’s own samples say of its variance. An MSE well above it is bias.",
    of: (d) => known(d.noise),
  },
  {
    name: "relMSE",
    formula: "⟨((I − R)² − var R) / (R² + ε)⟩, ε = 0.01 ⟨R⟩²",
    says: "Relative to the reference, so that dark parts count as much as bright ones. 0.01 is an error of a tenth.",
    of: (d) => known(d.rel_mse),
  },
  {
    name: "SMAPE",
    formula: "⟨|I − R| / (|I| + |R|)⟩",
    says: "From 0, equal, to 100 %. No single bright pixel decides it; the noise of both counts.",
    of: (d) => share(d.smape),
  },
  {
    name: "FLIP",
    formula: "⟨HDR-FLIP(I, R)⟩, Andersson et al. 2021",
    says: "What an eye sees that flips between the two, from 0, nothing, to 1. Noise that is seen counts.",
    of: (d, pending) => (pending ? "…" : known(d.flip)),
  },
  {
    name: "Bias",
    formula: "⟨I − R⟩ ± √Σ(σ²I + σ²R) / pixels",
    says: "How much brighter the whole is, over the reference’s mean, with its standard error. Noise is within two of these 19 times in 20.",
    of: (d) => bias(d),
  },
  {
    name: "Mean z²",
    formula: "⟨z²⟩, z = (I − R) / √(var I + var R)",
    says: "1 where variances explain every difference; a little more with few samples. More is bias.",
    of: ({ verdict: { scatter } }) => (scatter ? `${number(scatter.mean_square)} ± ${number(scatter.error)}` : "–"),
  },
  {
    name: "Beyond 2σ",
    formula: "share of |z| > 2",
    says: "4.55 % of noise.",
    of: ({ verdict: { scatter } }) => share(scatter?.beyond_2),
  },
  {
    name: "Beyond 3σ",
    formula: "share of |z| > 3",
    says: "0.27 % of noise; with few samples more, for their variances are uncertain.",
    of: ({ verdict: { scatter } }) => share(scatter?.beyond_3),
  },
];

function bias({ bias: off, reference_mean: mean, verdict: { bias_error: error } }) {
  const written = mean > 0 ? (x) => number((100 * x) / mean) : number;
  const unit = mean > 0 ? " %" : "";
  const sign = off > 0 ? "+" : off < 0 ? "−" : "";
  const size = `${sign}${written(Math.abs(off))}`;
  return typeof error === "number" ? `${size} ± ${written(error)}${unit}` : `${size}${unit}`;
}

// compared: [{job, place, difference, pending, problem}], those held against the reference
export const Numbers = ({ compared, reference }) => html`
  <section class="measures">
    <h2 id="measures">How far from ${title(reference)}</h2>
    <div class="wide" role="region" aria-labelledby="measures" tabindex="0">
      <table>
        <thead>
          <tr>
            <th scope="col">Measure</th>
            ${compared.map(({ job, place }) => html`<th scope="col" class="figure" key=${job.id}><span class="digit">${place + 1}</span> ${title(job)}</th>`)}
            <th scope="col" class="says">What it means</th>
          </tr>
        </thead>
        <tbody>
          ${MEASURES.map(({ name, formula, says, of }) => html`
            <tr key=${name}>
              <th scope="row">${name}<span class="formula">${formula}</span></th>
              ${compared.map(({ job, difference, pending }) => html`
                <td class="figure" key=${job.id}>${difference ? of(difference, pending) : "…"}</td>
              `)}
              <td class="says">${says}</td>
            </tr>
          `)}
        </tbody>
      </table>
    </div>
    <p class="explain">
      I is the render, R the reference, var the estimated variance of a pixel, ⟨ ⟩ the mean over pixels with channels
      weighted by luminance.
    </p>
  </section>
`;
