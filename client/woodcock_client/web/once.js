// What a button asks the service for: once, however often it is pressed and whatever gets lost on the way.

import { useRef, useState } from "preact/hooks";

const newKey = () => [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");

// {busy, problem, run}. act(key, ...): a call that is made under the key, an Idempotency-Key; it stays the same until the
// service has answered.
export function useOnce(act) {
  const [busy, setBusy] = useState(false);
  const [problem, setProblem] = useState(null);
  const key = useRef(null);
  const running = useRef(false);

  async function run(...values) {
    if (running.current) return;
    running.current = true;
    key.current ??= newKey();
    setBusy(true);
    setProblem(null);
    try {
      await act(key.current, ...values);
      key.current = null;
    } catch (caught) {
      if (caught.status !== 0) key.current = null; // nobody knows what became of a request without an answer
      setProblem(caught);
    }
    running.current = false;
    setBusy(false);
  }

  return { busy, problem, run };
}
