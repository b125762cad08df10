// A job's preview. A newer version replaces the shown one only once it is decoded, so a refining picture never flashes.

import { useEffect, useRef, useState } from "preact/hooks";
import { html } from "./html.js";

// The address of a picture as it is now: each count of samples is another one, and the end is, for the last samples are
// counted before their picture is there.
const versionOf = (link, job) => link && `${link}?state=${job.state}&samples=${job.samples}`;

const decoded = (address) => {
  const image = new Image();
  image.src = address;
  return image.decode().then(() => true, () => false);
};

// link: to the preview, or the thumbnail; every: ms between two versions at least
export function Picture({ job, link = job.links.preview, every, lazy = false }) {
  const wanted = versionOf(link, job);
  const [shown, setShown] = useState(wanted);
  const [broken, setBroken] = useState(false);
  const [busy, setBusy] = useState(false);
  const tried = useRef(wanted);
  const mounted = useRef(true);
  useEffect(() => () => (mounted.current = false), []);

  useEffect(() => {
    if (!wanted || wanted === tried.current || busy) return;
    tried.current = wanted;
    setBusy(true);
    decoded(wanted).then((good) => {
      if (!mounted.current) return;
      if (good) {
        setShown(wanted);
        setBroken(false);
      }
      setTimeout(() => mounted.current && setBusy(false), every);
    });
  }, [wanted, busy]);

  if (!shown || broken) {
    const waiting = job.state === "failed" || job.state === "cancelled" ? "No picture" : "No samples yet";
    return html`<span class="no-picture">${broken ? "The preview cannot be shown" : waiting}</span>`;
  }
  return html`<img
    src=${shown}
    alt=${`Preview of ${job.name || "an untitled render"}`}
    width=${job.width}
    height=${job.height}
    loading=${lazy ? "lazy" : "eager"}
    decoding="async"
    onError=${() => setBroken(true)}
  />`;
}
