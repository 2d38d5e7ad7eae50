"use strict";
// Faults are counted where a test can read them.
addEventListener("error", () => {
  const root = document.documentElement;
  root.dataset.errors = Number(root.dataset.errors || 0) + 1;
});
