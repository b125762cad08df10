// The pictures that are compared, in one of four ways. All have one view: what is zoomed or exposed in one is in the
// others, and nothing moves from one to the next.

import { useState } from "preact/hooks";
import { title } from "../format.js";
import { html } from "../html.js";
import { exposureShown } from "../viewer/appearance.js";
import { Canvas } from "../viewer/canvas.js";
import { rangeOf as foundIn } from "../viewer/statistics.js";
import { Legend } from "./legend.js";
import { useLoaded } from "./load.js";
import { channelOf, MAPS, rangeOf } from "./maps.js";
import { loadBeauty, loadMap } from "./pictures.js";
import { Split } from "./split.js";
import { Tools } from "./tools.js";
import { Under } from "./under.js";

export function Stage({ jobs, differences, state, change, view, onView }) {
  const { mode, shown, reference, split, map } = state;
  const [point, setPoint] = useState(null);
  const [fault, setFault] = useState(null);
  const loaded = useLoaded(jobs.map(({ id }) => id).join(), (signal) => Promise.all(jobs.map((job) => loadBeauty(job, signal))));
  const pictures = loaded.value;
  // What is held against the reference where two are looked at.
  const other = shown === reference ? (reference === 0 ? 1 : 0) : shown;
  const mapped = useMap(map, mode === "map" ? pictures : null, other, reference, jobs[other], differences[jobs[other].id]);
  const channel = mapped.data && channelOf(map, mapped.data, view.channel);
  const range = mapped.data && rangeOf(map, foundIn(mapped.data, channel, false));

  // One exposure for all: where none is chosen, the reference's.
  const seen = { ...view, map: "none", exposure: pictures ? exposureShown(view, pictures[reference]) : view.exposure };
  const moved = ({ zoom, x, y }) => onView({ ...view, zoom, x, y });
  const name = (place) => html`<span class="digit">${place + 1}</span> ${title(jobs[place])}`;
  const screen = (place) => html`
    <${Canvas} data=${pictures[place]} view=${seen} onView=${moved} onPoint=${setPoint} onFault=${setFault} label=${title(jobs[place])} />
  `;

  function content() {
    const problem = fault ?? loaded.problem?.message ?? (mode === "map" ? mapped.problem?.message : null);
    if (problem) return html`<p class="no-picture" role="alert">${problem}</p>`;
    if (!pictures) return html`<p class="no-picture" role="status">Loading the pictures…</p>`;
    if (mode === "flip") return html`${screen(shown)}<p class="caption" role="status">${name(shown)}</p>`;
    if (mode === "split") {
      return html`<${Split} at=${split} onAt=${(at) => change({ split: at })} left=${screen(reference)} right=${screen(other)} names=${[name(reference), name(other)]} />`;
    }
    if (mode === "side") return jobs.map((job, place) => html`<div class="pane" key=${job.id}>${screen(place)}<p class="caption">${name(place)}</p></div>`);
    if (!mapped.data) return html`<p class="no-picture" role="status">Comparing every pixel…</p>`;
    const looks = { ...view, map: MAPS[map].colours, log: false, channel, range };
    const label = `${MAPS[map].name}: ${title(jobs[other])} against ${title(jobs[reference])}`;
    return html`
      <${Canvas} data=${mapped.data} view=${looks} onView=${moved} onPoint=${setPoint} onFault=${setFault} label=${label} />
      <p class="caption">${name(other)} against ${name(reference)}</p>
    `;
  }

  return html`
    <section class="stages" aria-label="Pictures">
      <${Tools}
        jobs=${jobs}
        state=${state}
        other=${other}
        change=${change}
        view=${view}
        seen=${seen}
        onView=${onView}
        maps=${differences[jobs[other].id]?.difference?.maps}
        channels=${mapped.data?.channels ?? []}
        channel=${channel}
      />
      <div class=${`stage ${mode} of-${jobs.length}`} key=${mode}>${content()}</div>
      ${mode === "map" && html`<${Legend} map=${map} range=${range} />`}
      <${Under} point=${point} jobs=${jobs} pictures=${pictures} mapped=${mode === "map" && mapped.data ? { map, data: mapped.data } : null} />
    </section>
  `;
}

// {data, problem} of a map of the job against the reference; nothing is loaded without pictures. found: as useDifferences
// has it.
function useMap(map, pictures, other, reference, job, found) {
  const maps = pictures && found?.difference?.maps;
  const { value, problem } = useLoaded(maps?.[map] ?? null, (signal) => {
    const [mine, its] = [pictures[other].channels, pictures[reference].channels];
    return loadMap(job, found.difference, map, mine.length > its.length ? mine : its, signal);
  });
  const none = maps && !maps[map] ? { message: "There is no such map of these two: they share random numbers, or have no noise." } : null;
  return { data: value, problem: problem ?? found?.problem ?? none };
}
