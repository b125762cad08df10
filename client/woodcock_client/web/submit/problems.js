// What is wrong with what is written, beneath it; each line leads to its place.

import { html } from "../html.js";
import { isOfScene } from "./faults.js";

// wrong: what keeps the text from being JSON, null if it is; found: as useValidation() says; onJump(fault)
export function Problems({ wrong, found, onJump }) {
  const faults = wrong ? [{ field: "", message: wrong.message }] : found.faults;
  return html`
    <div class="problems">
      <p class="fact" role="status">${verdict(wrong, found)}</p>
      <ul>
        ${faults.map((fault) => html`
          <li key=${fault.field + fault.message}>
            <button type="button" onClick=${() => onJump(fault)}>
              ${fault.field && html`<code>${isOfScene(fault) ? fault.field.slice("scene.".length) || "scene" : fault.field}</code>`} ${fault.message}
            </button>
          </li>
        `)}
      </ul>
    </div>
  `;
}

function verdict(wrong, { faults, problem, checked }) {
  if (wrong) return "One fault.";
  if (problem) return `It could not be checked: ${problem}`;
  if (faults.length > 0) return faults.length === 1 ? "One fault." : `${faults.length} faults.`;
  return checked ? "This can be rendered." : "Being checked…";
}
