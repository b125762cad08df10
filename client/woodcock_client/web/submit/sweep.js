// Which fields a sweep varies, and over which values.

import { count } from "../format.js";
import { html } from "../html.js";
import { AXIS } from "./axes.js";

const HOW = { list: "these values", linear: "in even steps", log: "in even ratios" };

// paths: of the scene's numbers; sweep: as sweepOf() says
export function Sweep({ axes, paths, sweep, onAxes }) {
  const change = (index, values) => onAxes(axes.map((axis, at) => (at === index ? { ...axis, ...values } : axis)));
  return html`
    <section aria-labelledby="sweep">
      <h2 id="sweep">Sweep</h2>
      ${axes.length === 0 && html`<p class="fact">Renders the scene at every combination of values of some of its fields.</p>`}
      <datalist id="paths">${paths.map((path) => html`<option key=${path} value=${path} />`)}</datalist>
      ${axes.map((axis, index) => html`
        <${Axis}
          key=${index}
          number=${index + 1}
          axis=${axis}
          several=${axes.length > 1}
          onChange=${(values) => change(index, values)}
          onRemove=${() => onAxes(axes.filter((_, at) => at !== index))}
        />
      `)}
      <button type="button" onClick=${() => onAxes([...axes, AXIS])}>Vary ${axes.length > 0 ? "another" : "a"} field</button>
      <p class="said" role="status">${axes.length === 0 ? "" : sweep.fault ?? (sweep.count === 1 ? "1 render" : `${count(sweep.count)} renders`)}</p>
    </section>
  `;
}

function Axis({ number, axis, several, onChange, onRemove }) {
  const text = (key, label, more) => html`
    <label class="field">
      ${label}
      <input value=${axis[key]} onInput=${(event) => onChange({ [key]: event.target.value })} ...${more} />
    </label>
  `;
  return html`
    <fieldset class="varied">
      <legend>Field ${number}</legend>
      ${text("path", "Path", { list: "paths", placeholder: "volumes[0].sigma_t", spellcheck: false, autocomplete: "off" })}
      <label class="field">
        Takes
        <select value=${axis.how} onChange=${(event) => onChange({ how: event.target.value })}>
          ${Object.entries(HOW).map(([how, name]) => html`<option key=${how} value=${how}>${name}</option>`)}
        </select>
      </label>
      ${axis.how === "list"
        ? text("list", "Values", { placeholder: "1, 2, 4", spellcheck: false, autocomplete: "off" })
        : html`
            <div class="three">
              ${text("from", "From", { inputmode: "decimal" })} ${text("to", "To", { inputmode: "decimal" })}
              ${text("steps", "Steps", { inputmode: "numeric" })}
            </div>
          `}
      <div class="line">
        <label hidden=${!several}><input type="checkbox" checked=${axis.zipped} onChange=${(event) => onChange({ zipped: event.target.checked })} /> goes together with others so marked</label>
        <button type="button" aria-label=${`Remove field ${number}`} onClick=${onRemove}>Remove</button>
      </div>
    </fieldset>
  `;
}
