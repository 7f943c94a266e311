// SPDX-License-Identifier: Apache-2.0
// Light or dark: as the reader's system prefers, or as is chosen here. Paper is light.
const theme = {
  chosen: null, listeners: [], preferred: matchMedia("(prefers-color-scheme: dark)"),

  get dark() { return theme.chosen === null ? theme.preferred.matches : theme.chosen === "dark"; },
  toggle() {
    theme.chosen = theme.dark ? "light" : "dark";
    try {
      localStorage.setItem("kestrel-theme", theme.chosen);
    } catch {}  // a page that may keep nothing
    theme.apply();
  },
  // fn() when what is drawn must be drawn in other colours.
  onChange(fn) { theme.listeners.push(fn); },
  apply(paper = false) {
    document.documentElement.dataset.theme = theme.dark && !paper ? "dark" : "light";
    theme.listeners.forEach((fn) => fn());
  },
};
try {
  theme.chosen = localStorage.getItem("kestrel-theme");
} catch {}
theme.preferred.addEventListener("change", () => theme.apply());
addEventListener("beforeprint", () => theme.apply(true));
addEventListener("afterprint", () => theme.apply());
theme.apply();
byId("theme")?.addEventListener("click", theme.toggle);
