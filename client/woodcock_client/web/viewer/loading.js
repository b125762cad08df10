// The layers of a job, anew as it is rendered.

import { useEffect, useRef, useState } from "preact/hooks";
import { getPixels, isActive, Problem } from "../api.js";
import { loadLayer, loadLayers } from "./layers.js";

const EVERY = 1000; // ms between two looks at whether there is a newer picture

// {list, data, problem}: the job's layers; the one of that name, or the first where there is none of that name; why
// there are none, null while they are on their way.
export function useLayers(job, name) {
  const [found, setFound] = useState({ list: null, data: null, problem: null });
  const now = useRef();
  now.current = job;

  useEffect(() => {
    if (!job.links.layers) return undefined;
    const abort = new AbortController();
    let timer;
    let last = null;

    async function look() {
      const job = now.current;
      const version = `${job.samples} ${job.state}`;
      let again = isActive(job);
      if (version !== last) {
        try {
          const list = await loadLayers(job, abort.signal);
          const layer = list.layers.find((each) => each.name === name) ?? list.layers[0];
          if (!layer) throw new Problem(0, "Nothing was kept of it yet.");
          const data = await loadLayer(list, layer, { samples: again ? undefined : job.samples, signal: abort.signal });
          const same = (before) => before?.name === data.name && before.samples === data.samples && again;
          setFound((before) => ({ list, data: same(before.data) ? before.data : data, problem: null }));
          last = version;
        } catch (problem) {
          if (problem.name === "AbortError") return;
          again ||= problem.status === 0;
          setFound((before) => ({ ...before, problem }));
        }
      }
      if (again && !abort.signal.aborted) timer = setTimeout(look, EVERY);
    }

    look();
    return () => {
      abort.abort();
      clearTimeout(timer);
    };
  }, [job.links.layers, name]);

  return found;
}

// What all layers hold in a rectangle of pixels; while it is on its way, what was found before. place: {x, y, width,
// height}, or null. version: anew when it changes.
export function usePixels(job, place, version) {
  const [found, setFound] = useState(null);
  const wanted = useRef();
  const busy = useRef(false);
  wanted.current = place && { ...place, version };
  const key = JSON.stringify(wanted.current);

  useEffect(() => {
    async function ask() {
      if (busy.current || !wanted.current) return;
      busy.current = true;
      const asked = wanted.current;
      try {
        const pixels = await getPixels(job, asked);
        if (wanted.current) setFound(pixels);
      } catch {
        setFound(null); // the page says elsewhere that the service is away
      }
      busy.current = false;
      // The pointer has moved on.
      if (wanted.current && JSON.stringify(wanted.current) !== JSON.stringify(asked)) ask();
    }
    if (place) ask();
    else setFound(null);
  }, [key]);

  return place ? found : null;
}
