// The fleet: what there is to render on and how it is, what waits, what failed and why, and what the service keeps.

import { useEffect } from "preact/hooks";
import { countJobs, getHealth, getRetention, jobsThatAre, listDevices } from "../api.js";
import { html } from "../html.js";
import { usePoll } from "../poll.js";
import { Notice, Offline } from "../states.js";
import { Devices } from "./devices.js";
import { Failures } from "./failures.js";
import { Queue } from "./queue.js";
import { Storage } from "./storage.js";

// ms between two looks
const OFTEN = 2000;
const NOW_AND_THEN = 10_000;
const RARELY = 60_000;

const FAILED = 100; // of the newest that failed, how many are looked at

export function Fleet() {
  const devices = usePoll(listDevices, OFTEN);
  const running = usePoll((signal) => jobsThatAre("running", 50, signal), OFTEN);
  const counts = usePoll(countJobs, OFTEN);
  const failed = usePoll((signal) => jobsThatAre("failed", FAILED, signal), NOW_AND_THEN);
  const retention = usePoll(getRetention, RARELY);
  const health = usePoll(getHealth, RARELY);

  useEffect(() => {
    document.title = "Fleet · Woodcock";
    scrollTo(0, 0);
  }, []);

  if (!devices.value && devices.problem) {
    const away = devices.problem.status === 0;
    return html`
      <${Notice}
        title=${away ? "The service does not answer" : "The fleet cannot be shown"}
        action=${html`<button type="button" onClick=${devices.ask}>Try again</button>`}
      >
        <p>${away ? "It may be starting, stopped, or out of reach of this computer. This page keeps trying." : devices.problem.message}</p>
      <//>
    `;
  }
  const away = [devices, running, counts, failed, retention].some(({ value, problem }) => value && problem);
  return html`
    <${Offline} when=${away} />
    <div class="heading">
      <h1>Fleet</h1>
      <span class="fact" role=${devices.value ? null : "status"}>${devices.value ? said(devices.value.items) : "Loading…"}</span>
      <span class="fact version">${health.value ? `Woodcock ${health.value.version}` : ""}</span>
    </div>
    <div class="fleet">
      <${Queue} counts=${counts} />
      <${Devices} devices=${devices.value?.items ?? null} running=${running.value?.items ?? []} ask=${devices.ask} />
      <${Failures} failed=${failed} most=${FAILED} />
      <${Storage} retention=${retention} />
    </div>
  `;
}

function said(devices) {
  const ready = devices.filter(({ state }) => state === "ready").length;
  return `${ready} of ${devices.length} device${devices.length === 1 ? "" : "s"} ready`;
}
