// The files that the service has, and those on their way to it.

import { useEffect, useRef, useState } from "preact/hooks";
import { listVolumes, uploadVolume } from "../api.js";

// {volumes: newest first, null until they are known; next: cursor of older ones; problem: why they are not known;
// sending: [{key, name, share, problem}]; more, add, drop}
export function useUploads() {
  const [listed, setListed] = useState({ volumes: null, next: null, problem: null });
  const [sending, setSending] = useState([]);
  const count = useRef(0);
  const abort = useRef(new AbortController());

  const update = (key, values) =>
    setSending((before) => before.map((one) => (one.key === key ? { ...one, ...values } : one)));
  const drop = (key) => setSending((before) => before.filter((one) => one.key !== key));
  const known = (fresh) =>
    setListed((before) => {
      const ids = new Set(fresh.map(({ id }) => id));
      return { ...before, volumes: [...fresh, ...(before.volumes ?? []).filter(({ id }) => !ids.has(id))] };
    });

  async function more() {
    try {
      const { items, next } = await listVolumes(listed.next, abort.current.signal);
      setListed((before) => {
        const ids = new Set(before.volumes?.map(({ id }) => id));
        return { volumes: [...(before.volumes ?? []), ...items.filter(({ id }) => !ids.has(id))], next, problem: null };
      });
    } catch (problem) {
      if (problem.name !== "AbortError") setListed((before) => ({ ...before, problem }));
    }
  }

  // Sends a file; resolves to what it is, or to null if that failed, which is shown.
  async function add(file) {
    const key = count.current++;
    setSending((before) => [...before, { key, name: file.name, share: 0, problem: null }]);
    try {
      const volume = await uploadVolume(file, (share) => update(key, { share }), abort.current.signal);
      known([volume]);
      drop(key);
      return volume;
    } catch (problem) {
      update(key, { problem });
      return null;
    }
  }

  useEffect(() => {
    more();
    return () => abort.current.abort();
  }, []);
  return { ...listed, sending, more, add, drop };
}

// Whether files are being dragged over the page; onFiles gets those that are dropped anywhere on it.
export function useDrop(onFiles) {
  const [over, setOver] = useState(false);
  const drop = useRef(onFiles);
  drop.current = onFiles;
  useEffect(() => {
    const hasFiles = (event) => event.dataTransfer?.types.includes("Files");
    // Before the editor sees them, which would take a file's text for its own
    const listen = (name, act) => {
      const on = (event) => {
        if (!hasFiles(event)) return;
        event.preventDefault();
        event.stopPropagation();
        act(event);
      };
      addEventListener(name, on, { capture: true });
      return () => removeEventListener(name, on, { capture: true });
    };
    const stops = [
      listen("dragover", () => setOver(true)),
      listen("dragleave", (event) => event.relatedTarget === null && setOver(false)),
      listen("drop", (event) => {
        setOver(false);
        drop.current([...event.dataTransfer.files]);
      }),
    ];
    return () => stops.forEach((stop) => stop());
  }, []);
  return over;
}
