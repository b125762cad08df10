// One render as it is now, up to its end, and what is known of the devices.

import { useEffect, useState } from "preact/hooks";
import { followJob, getJob, getReport, isActive, listDevices } from "../api.js";

const RETRY = 3000; // ms before a page that could not be loaded tries again

// {job, report, devices, problem, away, onChange}. report: null before there is one, {problem, again} where it cannot be
// had; onChange: told what the page itself has made of the job.
export function useRender(id) {
  const [job, setJob] = useState(null);
  const [report, setReport] = useState(null);
  const [devices, setDevices] = useState([]);
  const [problem, setProblem] = useState(null);
  const [away, setAway] = useState(false);
  // An answer from before the job's end may come after it.
  const onChange = (changed) =>
    setJob((job) => (job && !isActive(job) && isActive(changed) ? job : { ...job, ...changed }));

  useEffect(() => {
    const abort = new AbortController();
    let stop = () => {};
    let timer;
    const ignore = () => {}; // the page does without

    async function start() {
      try {
        const loaded = await getJob(id, abort.signal);
        if (abort.signal.aborted) return undefined;
        setJob(loaded);
        setProblem(null);
        const finish = (done) => {
          if (!done.links.report) return;
          setReport(null);
          getReport(done, abort.signal).then(setReport, (problem) =>
            abort.signal.aborted || setReport({ problem, again: () => finish(done) }));
        };
        if (!isActive(loaded)) return finish(loaded);
        let latest = loaded;
        stop = followJob(loaded, {
          onJob: (summary) => onChange((latest = { ...latest, ...summary })),
          onEnd: () => finish(latest),
          onLost: setAway,
        });
      } catch (error) {
        if (error.name === "AbortError") return undefined;
        setProblem(error);
        if (error.status !== 404) timer = setTimeout(start, RETRY);
      }
      return undefined;
    }

    start();
    listDevices(abort.signal).then(({ items }) => setDevices(items), ignore);
    return () => {
      abort.abort();
      clearTimeout(timer);
      stop();
    };
  }, [id]);
  return { job, report, devices, problem, away, onChange };
}
