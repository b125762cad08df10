// Where cards lie: as many columns as fit, rows of one height, and which of them are near the window. Pixels.

const CARD = 240; // least width of one, where there is room for it
const LINES = 8 + 2 * 22; // below the picture
const AROUND = 2; // rows that are kept beyond either edge of the window

// Of a wall that is so wide. narrow: on a phone, where two columns fit by being smaller.
export function geometry(width, narrow) {
  const [across, down] = narrow ? [10, 16] : [16, 20];
  const columns = narrow ? 2 : Math.max(1, Math.floor((width + across) / (CARD + across)));
  const stage = Math.round((0.75 * (width - (columns - 1) * across)) / columns);
  return { width, columns, across, down, stage, row: stage + LINES, step: stage + LINES + down };
}

// Which of so many cards are kept, from `first` up to but not `last`, and which is the first that is wholly in view.
// above: how much of the wall is above the window.
export function near({ columns, step }, count, above, height) {
  const rows = Math.ceil(count / columns);
  const clamped = (row) => Math.min(rows, Math.max(0, row)) * columns;
  return {
    first: Math.min(clamped(Math.floor(above / step) - AROUND), Math.max(0, rows - 1) * columns),
    last: Math.min(count, clamped(Math.ceil((above + height) / step) + AROUND)),
    top: Math.min(Math.max(0, count - 1), clamped(Math.ceil(above / step))),
  };
}
