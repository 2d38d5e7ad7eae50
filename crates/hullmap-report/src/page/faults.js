"use strict";
// Counts errors where a test can read them.
addEventListener("error", () => {
  const root = document.documentElement;
  root.dataset.errors = Number(root.dataset.errors || 0) + 1;
});
