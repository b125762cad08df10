// What a render is called and how it is queued.

import { html } from "../html.js";

const KINDS = { cpu: "any CPU", gpu: "any GPU", accelerator: "any accelerator" };

// The id of the control of a request's field: of `tags[0]` that of the tags.
export const controlOf = (field) => `job-${field.match(/^\w+/)?.[0]}`;

export function Fields({ draft, devices, onChange }) {
  const kinds = [...new Set(devices.map(({ kind }) => kind))];
  const input = (key, label, more) => html`
    <label class="field">
      ${label}
      <input id=${controlOf(key)} value=${draft[key]} onInput=${(event) => onChange({ [key]: event.target.value })} ...${more} />
    </label>
  `;
  return html`
    <div class="fields">
      ${input("name", "Name", { maxlength: 200 })}
      ${input("tags", "Tags, with commas", {})}
      <label class="field">
        Device
        <select id=${controlOf("device")} value=${draft.device} onChange=${(event) => onChange({ device: event.target.value })}>
          <option value="any">all that are trusted</option>
          ${kinds.map((kind) => html`<option key=${kind} value=${kind}>${KINDS[kind]}</option>`)}
          ${devices.map(({ id, name }) => html`<option key=${id} value=${id}>${id}: ${name}</option>`)}
        </select>
      </label>
      ${input("priority", "Priority", { type: "number", min: -100, max: 100, step: 1 })}
      <label class="choice">
        <input id=${controlOf("pinned")} type="checkbox" checked=${draft.pinned} onChange=${(event) => onChange({ pinned: event.target.checked })} />
        Pinned: not deleted for age or room
      </label>
    </div>
  `;
}
