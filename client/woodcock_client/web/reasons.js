// Why renders fail, in plain words: what happened, and what can be done about it.

const REASONS = [
  {
    of: /^The process that renders on \S+ died/,
    says: "A device’s process died again and again",
    help: "It took too much memory, or its driver crashed. Try a smaller picture or coarser grids; if other scenes fail on it too, check the device’s stability.",
  },
  {
    of: /did not end .* within .* killed/,
    says: "A device did not come back in time",
    help: "Its driver hangs, or the work was too large for it. Try it on another device; if that helps, check this one’s stability.",
  },
  {
    of: /^The renderer stopped unexpectedly/,
    says: "The renderer broke off by a fault of its own",
    help: "That should not happen. The server’s log tells where; the scene is worth reporting.",
  },
  {
    of: /memory|MEM_OBJECT_ALLOCATION|OUT_OF_RESOURCES/i,
    says: "There was not enough memory",
    help: "Store grids more coarsely, make the picture smaller, or ask for a device that has more.",
  },
  {
    of: /did not build|BUILD_PROGRAM|compile/i,
    says: "A device could not build the scene’s program",
    help: "Its compiler refused it. Another device may take it; a newer driver may, too.",
  },
  {
    of: /Open Image Denoise/,
    says: "The denoiser is missing or failed",
    help: "Leave the layer “denoised” out of the scene, or have the service’s host install woodcock[denoise].",
  },
  {
    of: /a reference must|the reference of a picture/,
    says: "The picture cannot be held against its reference",
    help: "Choose a reference of the same size, in colour where the scene is.",
  },
  {
    of: /sha256:[0-9a-f]{64}/,
    says: "A file that the scene names cannot be used",
    help: "Look at what is said of it, mend the file, upload it anew and submit the scene with it.",
  },
];

const OTHER = { says: "The scene cannot be rendered as it is", help: "What is said of it names the place; mend it there and submit the scene anew." };

const UNKNOWN = { says: "No reason was given", help: "The server’s log may tell." };

// {says, help} of a failed job's error
export const reasonOf = (error) => (error ? (REASONS.find(({ of }) => of.test(error)) ?? OTHER) : UNKNOWN);

// Jobs by reason, in the order in which each reason comes first: [{reason, jobs}].
export function byReason(jobs) {
  const found = new Map();
  for (const job of jobs) {
    const reason = reasonOf(job.error);
    found.set(reason, [...(found.get(reason) ?? []), job]);
  }
  return [...found].map(([reason, those]) => ({ reason, jobs: those }));
}
