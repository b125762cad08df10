// What a comparison needs: jobs, their reports, their pictures, and how each differs from the reference.

import { useEffect, useState } from "preact/hooks";
import { getDifference, getJob, getReport } from "../api.js";

const RETRY = 3000; // ms before what could not be loaded is tried again

// The jobs of these ids: {jobs, reports, problem}; jobs is null until all are there. A report that cannot be had is null.
export function useJobs(ids) {
  const [loaded, setLoaded] = useState({ jobs: null, reports: [], problem: null });
  useEffect(() => {
    const abort = new AbortController();
    let timer;
    async function start() {
      try {
        const jobs = await Promise.all(ids.map((id) => getJob(id, abort.signal)));
        setLoaded({ jobs, reports: jobs.map(() => null), problem: null });
        const reports = await Promise.all(jobs.map((job) => job.links.report && getReport(job, abort.signal).catch(() => null)));
        if (!abort.signal.aborted) setLoaded({ jobs, reports, problem: null });
      } catch (problem) {
        if (problem.name === "AbortError") return;
        setLoaded((before) => ({ ...before, problem }));
        if (problem.status !== 404) timer = setTimeout(start, RETRY);
      }
    }
    start();
    return () => {
      abort.abort();
      clearTimeout(timer);
    };
  }, [ids.join()]);
  return loaded;
}

// By id of what is held against the reference: {difference, pending, problem}. FLIP takes longest and comes last; until
// then it is pending. jobs: in their order.
export function useDifferences(jobs, reference) {
  const [found, setFound] = useState({});
  const against = jobs[reference].id;
  useEffect(() => {
    setFound({});
    const abort = new AbortController();
    let timer;
    const others = jobs.filter(({ id }) => id !== against);
    const put = (id, values) => abort.signal.aborted || setFound((before) => ({ ...before, [id]: { ...before[id], ...values } }));
    async function ask({ id }, flip) {
      try {
        const difference = await getDifference(id, against, { flip }, abort.signal);
        put(id, { difference, pending: !flip, problem: null });
      } catch (problem) {
        if (problem.name === "AbortError") return;
        put(id, flip ? { pending: false } : { problem });
        if (problem.status === 0) throw problem;
      }
    }
    async function start() {
      try {
        for (const flip of [false, true]) for (const job of others) await ask(job, flip);
      } catch {
        timer = setTimeout(start, RETRY);
      }
    }
    start();
    return () => {
      abort.abort();
      clearTimeout(timer);
    };
  }, [jobs, against]);
  return found;
}

// What a function loads, anew for each key: {value, problem}; both null at first. Nothing is loaded for a key of null.
export function useLoaded(key, load) {
  const [loaded, setLoaded] = useState({ key: null, value: null, problem: null });
  useEffect(() => {
    if (key === null) return undefined;
    const abort = new AbortController();
    let timer;
    async function start() {
      try {
        const value = await load(abort.signal);
        if (!abort.signal.aborted) setLoaded({ key, value, problem: null });
      } catch (problem) {
        if (problem.name === "AbortError" || abort.signal.aborted) return;
        setLoaded({ key, value: null, problem });
        if (problem.status === 0) timer = setTimeout(start, RETRY);
      }
    }
    start();
    return () => {
      abort.abort();
      clearTimeout(timer);
    };
  }, [key]);
  return loaded.key === key ? loaded : { value: null, problem: null };
}
