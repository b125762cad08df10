// What is asked for again and again while somebody looks.

import { useEffect, useState } from "preact/hooks";

// {value, problem, ask} of load(signal), asked for every so many ms while the page can be seen. value: the newest answer,
// null before the first; problem: why there is no newer one; ask: at once.
export function usePoll(load, every) {
  const [known, setKnown] = useState({ value: null, problem: null });
  const [turn, setTurn] = useState(0);

  useEffect(() => {
    const abort = new AbortController();
    let timer;

    async function look() {
      clearTimeout(timer);
      if (document.hidden) return;
      try {
        const value = await load(abort.signal);
        setKnown({ value, problem: null });
      } catch (problem) {
        if (abort.signal.aborted) return;
        setKnown(({ value }) => ({ value, problem }));
      }
      clearTimeout(timer); // another look may have begun meanwhile
      if (!abort.signal.aborted) timer = setTimeout(look, every);
    }

    const onVisibility = () => document.hidden || look();
    document.addEventListener("visibilitychange", onVisibility);
    look();
    return () => {
      abort.abort();
      clearTimeout(timer);
      document.removeEventListener("visibilitychange", onVisibility);
    };
  }, [turn]);
  return { ...known, ask: () => setTurn((n) => n + 1) };
}
