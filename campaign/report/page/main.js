// SPDX-License-Identifier: Apache-2.0
const setUpFiles = () => {
  const text = (title, name, content) => (content ? [
    el("details", {}, el("summary", {}, title),
      el("div", {class: "actions"},
        el("button", {type: "button", onclick: () => saveFile(name, content, "text/yaml")}, `Save as ${name}`),
        el("button", {type: "button", onclick: () => copyText(content)}, "Copy")),
      el("pre", {tabindex: 0}, content))] : []);
  byId("provenance").append(
    el("p", {}, "Results: ", el("code", {}, data.results_file)),
    ...text("The campaign’s file", `${data.name}.yaml`, data.plan_text),
    ...text("The scenario without what varies", `${data.name}_scenario.yaml`, data.scenario_text));
};

const setUpSections = () => {
  const shown = [...document.querySelectorAll("main section")].filter((section) => !section.hidden);
  const links = shown.map((section) => el("a", {href: `#${section.id}`}, section.dataset.nav));
  byId("sections").append(...links);
  const observer = new IntersectionObserver((entries) => {
    for (const {target, isIntersecting} of entries)
      links[shown.indexOf(target)].classList.toggle("here", isIntersecting);
  }, {rootMargin: "-20% 0px -70% 0px"});
  shown.forEach((section) => observer.observe(section));
};

drawHeading();
drawShare();
drawOutcomes();
drawThresholds();
drawAgain();
setUpTuning();
setUpDistributions();
setUpScatter();
setUpEffects();
setUpTouchdown();
setUpTrajectories();
setUpWorst();
setUpTable();
setUpFiles();
setUpSections();
setUpRunPanel();

theme.onChange(drawAllAgain);  // charts are pictures, and on paper in its colours
