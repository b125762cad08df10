// Turns every flip-book of the page by its buttons, and the first by digits; 0 lays all frames out side by side.
// Without this all frames are shown.

for (const [index, book] of document.querySelectorAll(".book").entries()) {
  const buttons = [...book.querySelectorAll("button")];
  const frames = [...book.querySelectorAll(".frames > *")];
  const all = frames.length; // the last button's
  const show = (at) => {
    buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(i === at)));
    frames.forEach((frame, i) => frame.classList.toggle("shown", i === at || at === all));
    book.classList.toggle("turning", at !== all);
  };
  buttons.forEach((button, i) => button.addEventListener("click", () => show(i)));
  if (index === 0) {
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || !/^[0-9]$/.test(event.key)) return;
      const at = event.key === "0" ? all : Number(event.key) - 1;
      if (at < all || event.key === "0") show(at);
    });
  }
  book.classList.add("live");
  show(0);
}
