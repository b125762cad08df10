// What the wall can be narrowed by: a part of the name, and what jobs there are of each sort.

import { useEffect, useRef, useState } from "preact/hooks";
import { countJobs } from "../api.js";
import { count, STATES } from "../format.js";
import { html } from "../html.js";
import { go } from "../navigation.js";
import { addressOf, filterOf, narrowed } from "./filter.js";

const TYPED = 250; // ms after the last letter
const OLD = 5000; // ms after which counts are asked for anew by who comes to a menu
const ACTIVE = ["queued", "running", "cancelling"];

export function Filters({ filter }) {
  const [counts, refresh] = useCounts();
  const query = new URLSearchParams(filter);
  // By the address as it is now: two menus may be turned to before the page is drawn anew.
  const narrow = (word, values) => go(addressOf(narrowed(filterOf(new URLSearchParams(location.search)), word, values)), { replace: true });
  const tags = query.getAll("tag");
  return html`
    <form class="filters" role="search" aria-label="Renders" onSubmit=${(event) => event.preventDefault()} onFocusIn=${refresh}>
      <${Text} text=${query.get("text") ?? ""} onText=${(text) => narrow("text", [text])} />
      <${Menu} label="State" none="Any state" value=${query.getAll("state").join()} options=${states(counts?.states)}
        onPick=${(value) => narrow("state", value.split(","))} />
      <${Menu} label="Tag" none=${tags.length > 0 ? "Another tag" : "Any tag"} value="" options=${offered(counts?.tags, tags)}
        onPick=${(value) => narrow("tag", [...tags, value])} />
      <${Menu} label="Device" none="Any device" value=${query.get("device") ?? ""} options=${offered(counts?.devices)}
        onPick=${(value) => narrow("device", [value])} />
      <${Menu} label="Estimator" none="Any estimator" value=${query.get("integrator") ?? ""} options=${offered(counts?.integrators)}
        onPick=${(value) => narrow("integrator", [value])} />
      ${tags.map((tag) => html`
        <button key=${tag} type="button" class="chip" aria-label=${`Without the tag ${tag}`} onClick=${() => narrow("tag", tags.filter((each) => each !== tag))}>
          ${tag} <span aria-hidden="true">×</span>
        </button>
      `)}
      ${filter && html`<button type="button" class="plain" onClick=${() => go("/", { replace: true })}>Clear</button>`}
    </form>
  `;
}

// null until they are known; where they cannot be had the menus are empty, and the wall says why.
function useCounts() {
  const [counts, setCounts] = useState(null);
  const asked = useRef(-Infinity);
  const refresh = () => {
    if (performance.now() - asked.current < OLD) return;
    asked.current = performance.now();
    countJobs().then(setCounts, () => (asked.current = -Infinity));
  };
  useEffect(refresh, []);
  return [counts, refresh];
}

// As [value, name, number of jobs].
const offered = (counts = {}, without = []) =>
  Object.entries(counts).filter(([value]) => !without.includes(value)).map(([value, number]) => [value, value, number]);

function states(counts) {
  if (!counts) return [];
  const some = Object.keys(STATES).map((state) => [state, STATES[state], counts[state]]);
  const active = ACTIVE.reduce((sum, state) => sum + counts[state], 0);
  return [[ACTIVE.join(), "In progress", active], ...some].filter(([, , number]) => number > 0);
}

function Menu({ label, none, value, options, onPick }) {
  const known = options.some(([each]) => each === value);
  return html`
    <select aria-label=${label} value=${value} class=${value ? "set" : ""} onChange=${(event) => onPick(event.currentTarget.value)}>
      <option value="">${none}</option>
      ${value && !known && html`<option value=${value}>${value.split(",").map((each) => STATES[each] ?? each).join(", ")}</option>`}
      ${options.map(([each, name, number]) => html`<option key=${each} value=${each}>${`${name} (${count(number)})`}</option>`)}
    </select>
  `;
}

// What is typed goes into the address a moment later; what comes from there goes into the field.
function Text({ text, onText }) {
  const field = useRef();
  const told = useRef(text);
  const timer = useRef();
  const tell = useRef();
  tell.current = onText;
  useEffect(() => () => clearTimeout(timer.current), []);
  useEffect(() => {
    if (text !== told.current) field.current.value = told.current = text;
  }, [text]);
  const onInput = () => {
    clearTimeout(timer.current);
    timer.current = setTimeout(() => tell.current((told.current = field.current.value.trim())), TYPED);
  };
  return html`<input ref=${field} type="search" aria-label="Search names" placeholder="Search names" maxlength="200" defaultValue=${text} onInput=${onInput} />`;
}
