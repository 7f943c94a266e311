// SPDX-License-Identifier: Apache-2.0
// What the scenario lets one change in flight: numbers by sliders, what has choices by buttons.
const changes = new Map();  // by key: {value, show(value)}
const kSendPeriod_ms = 150;  // of one key that is turned and turned

const showChanged = (key, value) => {
  const change = changes.get(key);
  if (!change) return;
  change.value = value;
  change.show(value);
};
// What was refused goes back to what holds.
const showAllAsTheyAre = () => changes.forEach((change) => change.show(change.value));

// The newest wish, not more often than a period.
const senderOf = (key) => {
  let wanted, timer = null;
  return (value) => {
    wanted = value;
    timer ??= setTimeout(() => {
      timer = null;
      live.say({op: "change", key, value: wanted});
    }, kSendPeriod_ms);
  };
};

// A number of 1, 2 or 5 and zeros: a hundredth of the span or so.
const stepOf = (span) => {
  const power = 10 ** Math.floor(Math.log10(span / 100));
  return power * ([5, 2].find((each) => each * power <= span / 100) ?? 1);
};
const numberControl = ({key, min, max}, label, send) => {
  const bounds = {min: min ?? undefined, max: max ?? undefined};
  const field = el("input", {type: "number", step: "any", "aria-label": label, ...bounds});
  const slider = hasNumber(min) && hasNumber(max) && max > min
    ? el("input", {type: "range", step: stepOf(max - min), "aria-label": `${label}, slider`, ...bounds}) : null;
  slider?.addEventListener("input", () => {
    field.value = slider.value;
    send(Number(slider.value));
  });
  field.addEventListener("change", () => {
    if (field.value !== "") return send(Number(field.value));
    showAllAsTheyAre();
    refusedInFlight("that is no number", field.closest(".change").dataset.key);
  });
  const unit = unitOf(key)[1];
  return {
    element: [slider, field, unit ? el("span", {class: "unit"}, unit) : null],
    show(value) {
      field.value = value;
      if (slider) slider.value = value;
    },
  };
};
const listControl = (changeable, label, send) => {
  let values = changeable.value;
  const names = values.length === 3 ? ["north", "east", "down"] : values.map((_, i) => String(i + 1));
  const fields = values.map((_, i) => numberControl({key: "", min: changeable.min, max: changeable.max}, `${label}, ${names[i]}`,
    (value) => send(values = values.map((old, k) => (k === i ? value : old)))));
  return {
    element: fields.map(({element}) => element[1]).concat(el("span", {class: "unit"}, unitOf(changeable.key)[1])),
    show(value) {
      values = value;
      fields.forEach((field, i) => field.show(value[i]));
    },
  };
};

// In words: a fault is "gps off" or "motor 1 wrong, loss 0.2", no fault "none".
const wordsOf = (value) => {
  if (Array.isArray(value)) return value.length ? value.map(wordsOf).join("; ") : "none";
  if (value && typeof value === "object") {
    const {component, instance, type, ...more} = value;
    return [[component, instance, type].filter((word) => word !== undefined).map(wordsOf).join(" "),
      ...Object.entries(more).map(([name, of]) => `${plainName(name)} ${hasNumber(of) ? withUnit(of, name) : wordsOf(of)}`)]
      .filter(Boolean).join(", ");
  }
  return value === true ? "yes" : value === false ? "no" : String(value);
};
const choiceControl = ({choices}, label, send) => {
  const buttons = choices.map((choice) => ({choice: JSON.stringify(choice),
    button: el("button", {type: "button", onclick: () => send(choice)}, wordsOf(choice))}));
  return {
    element: buttons.map(({button}) => button),
    show(value) {
      buttons.forEach(({choice, button}) => button.setAttribute("aria-pressed", String(choice === JSON.stringify(value))));
    },
  };
};
const textControl = (_, label, send) => {
  const field = el("input", {type: "text", "aria-label": label, onchange: () => send(field.value)});
  return {element: [field], show(value) { field.value = value; }};
};
const controlOf = ({value, choices}) => (choices?.length ? choiceControl : hasNumber(value) ? numberControl
  : Array.isArray(value) && value.length && value.every(hasNumber) ? listControl : textControl);

const fillChanges = (changeable) => {
  changes.clear();
  byId("live-changes").replaceChildren(...changeable.map((each) => {
    const label = each.meaning ? each.meaning[0].toUpperCase() + each.meaning.slice(1) : each.key;
    const {element, show} = controlOf(each)(each, label, senderOf(each.key));
    changes.set(each.key, {value: each.value, show});
    show(each.value);
    return el("div", {class: "change", role: "group", "aria-label": label, "data-key": each.key},
      el("div", {class: "what"}, label, el("code", {}, each.key)), el("div", {class: "how"}, element));
  }), el("p", {class: "note"}, "What is changed stands in the scenario.yaml of the run, which flies it again."));
};
