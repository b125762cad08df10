// Noise or bias? The answer in a sentence, for each render that is held against the reference.

import { title } from "../format.js";
import { html } from "../html.js";

const SIGNS = { same: "=", noise: "✓", bias: "≠", unclear: "?" };

// A verdict begins with its one word.
function Answer({ verdict: { kind, says } }) {
  const [word, rest] = says.split(/:\s(.*)/s);
  return html`<p><strong><span aria-hidden="true">${SIGNS[kind]}</span> ${word}</strong>${rest.replace(/^./, (first) => first.toUpperCase())}</p>`;
}

// compared: as in numbers.js
export const Verdicts = ({ compared }) => html`
  <section class="verdicts" aria-live="polite">
    <h2>Noise or bias?</h2>
    <ul>
      ${compared.map(({ job, place, difference, problem }) => html`
        <li key=${job.id} class=${difference?.verdict.kind ?? ""}>
          ${compared.length > 1 && html`<h3><span class="digit">${place + 1}</span> ${title(job)}</h3>`}
          ${problem && html`<p>${problem.message}</p>`}
          ${!problem && !difference && html`<p class="fact">Comparing every pixel…</p>`}
          ${difference && html`<${Answer} verdict=${difference.verdict} />`}
          ${difference?.verdict.shared && html`<p class="fact">Both use the same random numbers, for they have the same seed: their noise is partly the same, and variances do not tell how far they should differ. There are no z-scores.</p>`}
        </li>
      `)}
    </ul>
  </section>
`;
