// What the service has against a request, asked as it is written.

import { useEffect, useState } from "preact/hooks";
import { validateJob } from "../api.js";

const PAUSE = 350; // ms without a change
const RETRY = 3000; // ms when there is no answer

const UNKNOWN = { faults: [], problem: null, checked: false };

// {faults: [{field, message}], problem: a sentence, or null; checked: does that hold for what is written now?}
// request: null while there is none; files: whose ids it may name
export function useValidation(request, files) {
  const [found, setFound] = useState(UNKNOWN);
  const body = JSON.stringify(request);
  useEffect(() => {
    setFound((before) => ({ ...before, checked: false }));
    if (request === null) return undefined;
    const abort = new AbortController();
    let timer = setTimeout(ask, PAUSE);
    async function ask() {
      try {
        await validateJob(request, abort.signal);
        setFound({ faults: [], problem: null, checked: true });
      } catch (error) {
        if (error.name === "AbortError") return;
        const faults = error.errors ?? [];
        setFound({ faults, problem: faults.length > 0 ? null : error.message, checked: true });
        if (error.status === 0) timer = setTimeout(ask, RETRY);
      }
    }
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [body, files]);
  return found;
}
