// SPDX-License-Identifier: Apache-2.0
// Elements; text of runs goes in as text, never as markup.
const byId = (id) => document.getElementById(id);

const el = (tag, properties = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "style") element.style.cssText = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
};

const fillSelect = (select, values, chosen) => {
  select.replaceChildren(...values.map((value) => el("option", {value}, value)));
  if (chosen !== undefined && values.includes(chosen)) select.value = chosen;
};

const announce = (text) => { byId("announce").textContent = text; };

const copyText = async (text) => {
  try {
    await navigator.clipboard.writeText(text);
  } catch {  // pages that come over plain http have no clipboard
    const area = el("textarea", {style: "position:fixed;opacity:0"});
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
};

// A command with a button that copies it.
const commandLine = (text) => {
  const button = el("button", {type: "button", "aria-label": `Copy: ${text}`}, "Copy");
  button.addEventListener("click", async () => {
    await copyText(text);
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = "Copy"; }, 1500);
  });
  return el("div", {class: "command"}, el("code", {}, text), button);
};

const saveFile = (name, text, type = "text/plain") => {
  const link = el("a", {href: URL.createObjectURL(new Blob([text], {type})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
};
