"use strict";
/* The page to tune on: controls on one side, the scan and the result on the other, and one socket to the server. */

const by = (id) => document.getElementById(id);
const socket = new WebSocket(`ws://${location.host}${location.pathname}socket`);
socket.binaryType = "arraybuffer";

const state = { recipe: null, asked: 0, pending: 0, awaited: null, scan: null, result: null, kept: null, running: false };
let viewer = null;

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made && key !== "list" && typeof value !== "string") made[key] = value;
    else if (value !== null) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/* ----------------------------------------------------------------------------------------------------------------- controls */

function field(step, number, parameter) {
  const id = `step-${number}-${parameter.name}`, title = `${parameter.help} It takes ${parameter.allowed}.`.trim();
  const row = element("div", { class: "control", "data-parameter": parameter.name, title });
  const label = element("label", { for: id }, parameter.label);
  const changed = () => { row.dataset.text = text(); row.classList.remove("wrong"); ask(150); };
  let text, input;
  if (parameter.kind === "switch") {
    input = element("input", { type: "checkbox", id, checked: parameter.value === "true" });
    text = () => String(input.checked);
    row.append(input, label);
  } else if (parameter.kind === "menu") {
    input = element("select", { id }, ...parameter.choices.map((word) => element("option", { selected: word === parameter.value }, word)));
    text = () => input.value;
    row.append(label, input);
  } else if (parameter.kind === "text") {
    input = element("input", { type: "text", id, value: parameter.value, placeholder: "found by the filter", autocomplete: "off" });
    text = () => input.value;
    row.append(label, input);
  } else {
    const length = parameter.kind === "length", whole = parameter.kind === "whole";
    const parts = parameter.value === "auto" ? ["", "", "edge"] : /^(.*?)(%|edge)?$/.exec(parameter.value);
    const step_ = whole ? 1 : (parameter.high - parameter.low) / 200;
    const slider = element("input", { type: "range", min: String(parameter.low), max: String(parameter.high), step: String(step_), id: `${id}-slider`, "aria-label": `${parameter.label}, slider` });
    slider.value = parts[1];
    input = element("input", { type: "number", id, step: whole ? "1" : "any", value: parts[1], placeholder: parameter.automatic ? "auto" : "found" });
    if (parameter.least !== null) input.min = String(parameter.least);
    if (parameter.most !== null) input.max = String(parameter.most);
    const unit = length ? element("select", { "aria-label": `${parameter.label}, unit` },
      ...[["edge", "mean edges"], ["%", "% of the diagonal"], ["", "mesh units"]].map(([value, words]) => element("option", { value, selected: value === (parts[2] || "") }, words))) : null;
    text = () => input.value === "" ? (parameter.automatic ? "auto" : "") : input.value + (unit ? unit.value : "");
    slider.addEventListener("input", () => { input.value = String(Number(Number(slider.value).toPrecision(4))); changed(); });
    input.addEventListener("input", () => { slider.value = input.value; });
    row.append(label, slider, element("span", { class: "value" }, input, ...(unit ? [unit] : [])));
    if (parameter.automatic) {
      const automatic = element("button", { type: "button", title: "Let the filter choose it for the scan" }, "auto");
      automatic.addEventListener("click", () => { input.value = ""; changed(); });
      row.append(automatic);
    }
    if (unit) unit.addEventListener("change", changed);
  }
  input.addEventListener(parameter.kind === "switch" || parameter.kind === "menu" ? "change" : "input", changed);
  row.dataset.text = parameter.value;
  return row;
}

function showRecipe(recipe) {
  state.recipe = recipe.key;
  by("purpose").textContent = [recipe.purpose && `For: ${recipe.purpose}`, recipe.tune && `Tune: ${recipe.tune}`].filter(Boolean).join(" ");
  by("steps").replaceChildren(...recipe.steps.map((step, number) => {
    const on = element("input", { type: "checkbox", checked: true, "data-on": "" });
    on.addEventListener("change", () => ask(0));
    const shown = step.parameters.filter((p) => !p.advanced), more = step.parameters.filter((p) => p.advanced);
    const item = element("li", { "data-step": String(number) }, element("label", { class: "step", title: step.summary }, on, ` ${step.name}`),
      ...shown.map((p) => field(step, number, p)));
    if (more.length) item.append(element("details", {}, element("summary", {}, "More"), ...more.map((p) => field(step, number, p))));
    return item;
  }));
  by("recipe").value = recipe.key;
  by("recipe-name").value = `${recipe.name.replace(/^.*[\\/]/, "").replace(/\.mlx$/i, "")}_tuned.mlx`;
}

function settings() {
  return [...by("steps").children].map((item) => ({
    on: item.querySelector("[data-on]").checked,
    values: Object.fromEntries([...item.querySelectorAll("[data-parameter]")].map((row) => [row.dataset.parameter, row.dataset.text])),
  }));
}

function send(what, more = {}) {
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ do: what, recipe: state.recipe, steps: settings(), ...more }));
}

/* run with what is set now, after a short while without another change */
function ask(patience) {
  clearTimeout(state.pending);
  state.pending = setTimeout(() => {
    complain("");
    const whole = document.querySelector("input[name=whole]:checked").value === "whole";
    send("run", { asked: ++state.asked, whole });
  }, patience);
}

/* ------------------------------------------------------------------------------------------------------------------ results */

function complain(text) { by("problem").textContent = text; by("problem").hidden = !text; }

function running(on, words) {
  state.running = on;
  by("stop").disabled = !on;
  by("state").textContent = words;
  document.body.dataset.running = on ? "yes" : "no";
  by("progress").style.visibility = on ? "visible" : "hidden";
  if (!on) by("progress").value = 0;
}

function table(caption, headers, rows) {
  const line = (cells, head) => element("tr", {}, ...cells.map((cell, k) => head ? element("th", { scope: "col" }, cell)
    : k ? element("td", { class: "number" }, cell) : element("th", { scope: "row" }, cell)));
  return element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": caption }, element("table", {}, element("caption", {}, caption),
    element("thead", {}, line(headers, true)), element("tbody", {}, ...rows.map((row) => line(row, false)))));
}

function showNumbers(told) {
  const columns = told.distance ? ["", "scan", "result"] : ["", "scan"];
  const made = [];
  if (told.distance) made.push(table("How far apart", told.distance[0], told.distance.slice(1)));
  if (told.lines) made.push(element("ul", {}, ...told.lines.map((text) => element("li", {}, text))));
  made.push(table("What the meshes are like", columns, told.measures));
  for (const text of told.warnings || []) made.push(element("p", { class: "hint" }, `Warning: ${text}`));
  by("numbers").replaceChildren(...made);
}

/* one scene of meshes that came one by one: their colours share the limits of the newest result */
function showScene() {
  const { scan, result, kept } = state;
  const shown = [scan, result, kept].map((scene) => scene && scene.meshes[0]);
  if (shown[2]) shown[2] = { ...shown[2], name: "kept result" };
  const colorings = { ...scan.colorings, ...(result || scan).colorings };
  if (scan.colorings.curvature) colorings.curvature = scan.colorings.curvature;
  viewer.show({ ...scan, colorings, meshes: shown.map((mesh) => mesh || { ...scan.meshes[0], name: "no result yet" }) });
}

async function receive(told, scene) {
  if (told.is === "scan") {
    Object.assign(state, { scan: scene, result: null, kept: null });
    showScene();
    showNumbers(told);
    if (!state.asked) ask(0);
  } else if (told.asked === state.asked) {
    state.result = scene;
    showScene();
    showNumbers(told);
    by("keep").disabled = false;
    running(false, `done in ${told.seconds.toFixed(1)} s`);
    document.body.dataset.shown = String(told.asked);
  }
}

const answers = {
  welcome(told) {
    by("recipe").replaceChildren(...told.recipes.map(({ name, title }) => element("option", { value: name, title }, name)));
    by("folder").textContent = `Files are written to ${told.folder}.`;
    by("extent").hidden = !told.has_part;
    by("about").textContent = `${told.vertices.toLocaleString("en")} vertices. ` +
      (told.has_part ? "Parameters are tried on a part of the scan first; lengths are those of the whole. " : "") + told.warnings.join(" ");
    by("output-name").value = told.scan.replace(/(\.[^.]*)?$/, "_clean$1");
  },
  recipe(told) { showRecipe(told); if (state.scan) ask(0); },
  opening(told) { by("state").textContent = `reading ${told.whole ? "the whole scan" : "the scan"}`; },
  begun(told) { state.current = told.run; running(true, told.run ? "running" : "running on the whole scan"); document.body.dataset.begun = String(told.asked ?? 0); },
  event(told) {
    if (told.run !== state.current || !state.running) return;
    if (told.event === "StepStarted") by("state").textContent = `step ${told.index} of ${told.total}: ${told.filter}`;
    if (told.event === "StepProgress") by("progress").value = told.fraction;
    if (told.event === "StepStarted" || told.event === "StepFinished") by("progress").value = told.event === "StepFinished" ? 1 : 0;
    if (told.event === "PhaseStarted") by("state").textContent = told.phase;
  },
  cancelled(told) {
    document.body.dataset.cancelled = String(Number(document.body.dataset.cancelled || 0) + 1);
    if (told.run === state.current) running(false, "stopped");
  },
  failed(told) { if (told.run === state.current) { running(false, "failed"); complain(told.message); } },
  problem(told) {
    running(false, "not run");
    complain(told.message);
    if ("step" in told) by("steps").children[told.step]?.querySelector(`[data-parameter="${CSS.escape(told.parameter)}"]`)?.classList.add("wrong");
  },
  saved(told) { by("state").textContent = `saved: ${told.path}`; },
  finished(told) { running(false, `written: ${told.files.join(", ")}`); },
  ended(told) { complain(told.message); },
};

socket.addEventListener("message", async ({ data }) => {
  if (typeof data === "string") {
    const told = JSON.parse(data);
    if (told.is === "scan" || told.is === "result") state.awaited = told;
    else answers[told.is]?.(told);
  } else {
    const told = state.awaited;
    try { await receive(told, await readMessage(data)); } catch (error) { complain(error.message); }
  }
});
socket.addEventListener("close", () => { running(false, "the server is gone; start pymeshfair tune again"); });

by("recipe").addEventListener("change", () => send("recipe", { recipe: by("recipe").value }));
by("again").addEventListener("click", () => ask(0));
by("stop").addEventListener("click", () => { clearTimeout(state.pending); send("stop"); });
by("extent").addEventListener("change", () => ask(0));
by("settings").addEventListener("submit", (event) => event.preventDefault());
by("save").addEventListener("click", () => { complain(""); send("save", { name: by("recipe-name").value, note: by("note").value, replace: by("replace").checked }); });
by("finish").addEventListener("click", () => { complain(""); send("finish", { name: by("output-name").value, replace: by("replace").checked }); });
by("keep").addEventListener("click", () => {
  state.kept = state.result;
  const choice = document.querySelector("input[value='2 1']");
  choice.disabled = false;
  choice.checked = true;
  showScene();
  choice.dispatchEvent(new Event("change", { bubbles: true }));
});

try {
  viewer = new Viewer(by("viewer"));
  connect(viewer, by("switches"));
} catch (error) { complain(error.message); }
