// Where the keyboard's focus goes when something opens and closes.

import { useLayoutEffect, useRef } from "preact/hooks";

// A ref for the button that opens something: it has the focus again once that is closed.
export function useReturn(open) {
  const button = useRef();
  const was = useRef(false);
  useLayoutEffect(() => {
    if (was.current && !open) button.current?.focus();
    was.current = open;
  }, [open]);
  return button;
}

// A ref for what has the focus as soon as it is there; a field's text is selected.
export function useFocus() {
  const element = useRef();
  useLayoutEffect(() => {
    element.current.focus();
    element.current.select?.();
  }, []);
  return element;
}
