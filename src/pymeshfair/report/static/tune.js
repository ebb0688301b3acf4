"use strict";
/* The page to tune on: controls on one side, the scan and the result on the other, and one socket to the server. */

const by = (id) => document.getElementById(id);
const socket = new WebSocket(`ws://${location.host}${location.pathname}socket`);
socket.binaryType = "arraybuffer";

const NO_NUMBER = "no number"; // stands for a text in a field for numbers that the browser does not tell
const state = {
  recipe: null, asked: 0, pending: 0, awaited: null, scan: null, result: null, told: null, kept: [], left: null, running: false,
  switching: false, scale: { diagonal: 1, edge: 1 },
};
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

function field(step, number, parameter) {
  const id = `step-${number}-${parameter.name}`, title = `${parameter.help} It takes ${parameter.allowed}.`.trim();
  const row = element("div", { class: "control", "data-parameter": parameter.name, title });
  const label = element("label", { for: id }, parameter.label);
  const changed = () => { row.dataset.text = text(); row.classList.remove("wrong"); ask(150); };
  let text, input, put = (value) => { input.value = value; };
  if (parameter.kind === "switch") {
    input = element("input", { type: "checkbox", id, checked: parameter.value === "true" });
    text = () => String(input.checked);
    put = (value) => { input.checked = value === "true"; };
    row.append(input, label);
  } else if (parameter.kind === "menu") {
    input = element("select", { id }, ...parameter.choices.map((word) => element("option", { selected: word === parameter.value }, word)));
    text = () => input.value;
    row.append(label, input);
  } else if (parameter.kind === "text") {
    input = element("input", { type: "text", id, value: parameter.value, placeholder: parameter.value === "" ? "found by the filter" : "as in the recipe", autocomplete: "off" });
    text = () => input.value;
    row.append(label, input);
  } else {
    const length = parameter.kind === "length", whole = parameter.kind === "whole";
    const step_ = whole ? 1 : (parameter.high - parameter.low) / 200;
    const slider = element("input", { type: "range", min: String(parameter.low), max: String(parameter.high), step: String(step_), id: `${id}-slider`, "aria-label": `${parameter.label}, slider` });
    input = element("input", { type: "number", id, step: whole ? "1" : "any", placeholder: parameter.value === "" ? "found" : parameter.value === parameter.automatic ? "auto" : "as in the recipe" });
    if (parameter.least !== null) input.min = String(parameter.least);
    if (parameter.most !== null) input.max = String(parameter.most);
    const unit = length ? element("select", { "aria-label": `${parameter.label}, unit` },
      ...[["edge", "mean edges"], ["%", "% of the diagonal"], ["", "mesh units"]].map(([value, words]) => element("option", { value }, words))) : null;
    const auto = parameter.automatic ? element("input", { type: "checkbox", "data-auto": "", "aria-label": `${parameter.label}, auto` }) : null;
    text = () => auto && auto.checked ? parameter.automatic : input.validity.badInput ? NO_NUMBER : input.value === "" ? parameter.value : input.value + (unit ? unit.value : "");
    const enable = () => { for (const part of [slider, input, ...(unit ? [unit] : [])]) part.disabled = Boolean(auto && auto.checked); };
    put = (value) => {
      if (auto) auto.checked = value === parameter.automatic;
      enable();
      if (auto && auto.checked) return;
      const parts = /^(.*?)(%|edge)?$/.exec(value);
      input.value = slider.value = parts[1];
      if (unit) unit.value = parts[2] || "";
    };
    slider.addEventListener("input", () => { input.value = String(Number(Number(slider.value).toPrecision(4))); changed(); });
    input.addEventListener("input", () => { slider.value = input.value; });
    row.append(label, slider, element("span", { class: "value" }, input, ...(unit ? [unit] : []),
      ...(auto ? [element("label", {}, auto, " auto")] : [])));
    if (unit) unit.addEventListener("change", changed);
    if (auto) input.addEventListener("change", () => { if (text() === parameter.automatic) row.put(parameter.automatic); });
    if (auto) auto.addEventListener("change", () => { enable(); if (!auto.checked && input.value === "") input.value = slider.value; changed(); });
    row.showTried = (tried) => { row.querySelector("svg")?.remove(); if (length && tried.length > 1) slider.before(curve(tried, parameter, unit.value)); };
  }
  input.setAttribute("aria-description", title);
  row.put = (value) => { put(value); row.dataset.text = value === NO_NUMBER ? text() : value; };
  row.put(parameter.value);
  row.dataset.first = row.dataset.text;
  input.addEventListener(parameter.kind === "switch" || parameter.kind === "menu" ? "change" : "input", changed);
  return row;
}

/* draws above the slider the error at held-out vertices for each detail size that was tried */
function curve(tried, parameter, unit) {
  const { diagonal, edge } = state.scale, factor = unit === "edge" ? 1 : unit === "%" ? 100 * edge / diagonal : edge;
  const points = tried.map(({ amount, error }) => [amount * factor, error]).sort((a, b) => a[0] - b[0]);
  const errors = points.map(([, error]) => error), low = Math.min(...errors), high = Math.max(...errors);
  const x = (v) => 8 + 284 * Math.max(0, Math.min(1, (v - parameter.low) / (parameter.high - parameter.low)));
  const y = (v) => 4 + 32 * (high - v) / (high - low || 1);
  const drawn = document.createElementNS("http://www.w3.org/2000/svg", "svg"), title = document.createElementNS(drawn.namespaceURI, "title");
  const [best] = points.reduce((a, b) => b[1] < a[1] ? b : a);
  title.textContent = `Error at vertices that the filter did not see, least at ${shortNumber(best)}: ` +
    points.map(([size, error]) => `${shortNumber(size)}: ${shortNumber(error)}`).join(", ");
  drawn.setAttribute("viewBox", "0 0 300 40");
  drawn.setAttribute("class", "curve");
  drawn.setAttribute("role", "img");
  const path = document.createElementNS(drawn.namespaceURI, "path"), dot = document.createElementNS(drawn.namespaceURI, "circle");
  path.setAttribute("d", "M" + points.filter(([size]) => size <= parameter.high).map(([size, error]) => `${x(size).toFixed(1)} ${y(error).toFixed(1)}`).join("L"));
  for (const [name, value] of [["cx", x(best)], ["cy", y(low)], ["r", 3]]) dot.setAttribute(name, String(value));
  drawn.append(title, path, dot);
  return drawn;
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
  const kept = remembered();
  if (kept && kept.recipe === recipe.key && kept.steps.length === recipe.steps.length) putSettings(kept.steps);
  by("recipe").value = recipe.key;
  by("recipe-name").value = `${recipe.name.replace(/^.*[\\/]/, "").replace(/\.mlx$/i, "")}_tuned.mlx`;
}

function settings() {
  return [...by("steps").children].map((item) => ({
    on: item.querySelector("[data-on]").checked,
    values: Object.fromEntries([...item.querySelectorAll("[data-parameter]")].map((row) => [row.dataset.parameter, row.dataset.text])),
  }));
}

/* what differs from the recipe, in words */
function changes() {
  return [...by("steps").children].flatMap((item) => item.querySelector("[data-on]").checked
    ? [...item.querySelectorAll("[data-parameter]")].filter((row) => row.dataset.text !== row.dataset.first).map((row) => `${row.dataset.parameter} ${row.dataset.text}`)
    : `without ${item.querySelector(".step").textContent.trim()}`).join(", ");
}

function putSettings(steps) {
  [...by("steps").children].forEach((item, number) => {
    item.querySelector("[data-on]").checked = steps[number].on;
    for (const row of item.querySelectorAll("[data-parameter]")) row.put(steps[number].values[row.dataset.parameter] ?? row.dataset.text);
  });
}

/* keeps the settings of this tab and this scan when the page is loaded again */
function remember() {
  try { sessionStorage.setItem(location.pathname, JSON.stringify({ recipe: state.recipe, steps: settings() })); } catch { /* a frame in a notebook may have no storage */ }
}
function remembered() {
  try { return JSON.parse(sessionStorage.getItem(location.pathname)); } catch { return null; }
}

function send(what, more = {}) {
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ do: what, recipe: state.recipe, steps: settings(), ...more }));
  else if (state.ended) complain(state.ended);
}

/* runs with the current settings, after a short time without changes */
function ask(patience) {
  clearTimeout(state.pending);
  stale(true);
  remember();
  state.pending = setTimeout(() => {
    state.pending = 0;
    complain("");
    state.sent = { recipe: state.recipe, steps: settings(), changed: changes() };
    send("run", { asked: ++state.asked });
  }, patience);
}

function complain(text) { by("problem").textContent = text; by("problem").hidden = !text; }

/* whether the shown result has other settings than the controls */
function stale(so) { document.querySelector(".result").classList.toggle("stale", so && Boolean(state.result)); }

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
  state.told = told;
  const columns = told.distance ? ["", "scan", "result"] : ["", "scan"];
  const made = [];
  if (told.distance) made.push(table("How far apart", told.distance[0], told.distance.slice(1)));
  if (told.lines) made.push(element("ul", {}, ...told.lines.map((text) => element("li", {}, text))));
  made.push(table("What the meshes are like", columns, told.measures));
  for (const text of told.warnings || []) made.push(element("p", { class: "hint" }, `Warning: ${text}`));
  by("numbers").replaceChildren(...made);
}

/* one scene of meshes that arrived one by one; their colours share the limits of the newest result */
function showScene() {
  const { scan, result, left } = state;
  const shown = [scan, result, left && left.scene].map((scene) => scene && scene.meshes[0]);
  if (shown[2]) shown[2] = { ...shown[2], name: left.name };
  const colorings = { ...scan.colorings, ...(left && left.scene.colorings), ...(result || scan).colorings };
  if (scan.colorings.curvature) colorings.curvature = { ...scan.colorings.curvature, label: colorings.curvature.label };
  viewer?.show({ ...scan, colorings, meshes: shown.map((mesh) => mesh || { ...scan.meshes[0], name: "no result yet" }) });
}

async function receive(told, scene) {
  if (told.is === "scan") {
    Object.assign(state, { scan: scene, result: null, left: null });
    stale(false);
    showLeft("0 1");
    showNumbers(told);
    if (!state.switching && !state.asked) ask(0);
  } else if (told.asked === state.asked) {
    state.result = scene;
    showScene();
    stale(state.pending !== 0);
    by("keep").disabled = false;
    if (told.is === "result") {
      Object.assign(state, { seconds: told.seconds, warnings: told.warnings, made: state.sent, told: null });
      running(true, `mesh there after ${told.seconds.toFixed(1)} s, numbers to come`);
      [...by("steps").querySelectorAll("li[data-step]")].filter((item) => item.querySelector("[data-on]").checked).forEach((item, k) => {
        for (const row of item.querySelectorAll("[data-parameter=detail_size]")) row.showTried(told.tried[k] || []);
      });
      by("numbers").classList.add("awaited");
      document.body.dataset.shown = String(told.asked);
    } else {
      showNumbers({ ...told, warnings: [...state.warnings, ...told.warnings] });
      by("numbers").classList.remove("awaited");
      running(false, `done in ${state.seconds.toFixed(1)} s, numbers ${told.seconds.toFixed(1)} s later`);
      document.body.dataset.measured = String(told.asked);
    }
  }
}

function showLeft(views) {
  const choice = document.querySelector(`input[value='${views}']`);
  choice.disabled = false;
  choice.checked = true;
  showScene();
  choice.dispatchEvent(new Event("change", { bubbles: true }));
}

function keep() {
  const rows = state.told && state.told.distance ? state.told.distance.slice(1) : [], rms = rows.find(([words]) => words.startsWith("root mean square"));
  const kept = { ...state.made, name: `kept ${state.kept.length + 1}`, scene: state.result };
  state.kept.push(kept);
  const show = element("button", { type: "button" }, "Show left"), back = element("button", { type: "button" }, "Back to it");
  show.addEventListener("click", () => { state.left = kept; showLeft("2 1"); });
  back.addEventListener("click", () => {
    if (state.recipe !== kept.recipe) {
      state.returning = kept;
      send("recipe", { recipe: kept.recipe });
    } else { putSettings(kept.steps); ask(0); }
  });
  by("kept").append(element("li", {}, `${kept.name}: ${kept.changed || "as the recipe says"}${rms ? `; root mean square distance ${rms[1]}` : ""} `, show, " ", back));
  state.left = kept;
  showLeft("2 1");
}

const answers = {
  welcome(told) {
    by("recipe").replaceChildren(...told.recipes.map(({ name, title }) => element("option", { value: name, title }, name)));
    by("folder").textContent = `Files are written to ${told.folder}.`;
    state.scale = { diagonal: told.diagonal, edge: told.mean_edge };
    by("about").textContent = `${told.vertices.toLocaleString("en")} vertices. ` +
      (told.has_part ? "Parameters are tried on a part of the scan; lengths are those of the whole. " : "") + told.warnings.join(" ");
    by("output-name").value = told.scan.replace(/(\.[^.]*)?$/, "_clean$1");
  },
  recipe(told) {
    const kept = state.scan ? null : remembered();
    showRecipe(told);
    state.switching = Boolean(kept && kept.recipe !== told.key);
    if (state.returning) { putSettings(state.returning.steps); state.returning = null; }
    if (state.scan) ask(0);
    else if (state.switching) send("recipe", { recipe: kept.recipe });
  },
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
  failed(told) {
    if (told.run === state.current) running(false, "failed");
    if (!told.run || told.run === state.current) complain(told.message);
  },
  problem(told) {
    if (!state.running || (told.asked && state.current !== 0)) running(false, "not run");
    complain(told.message);
    if ("step" in told) by("steps").children[told.step]?.querySelector(`[data-parameter="${CSS.escape(told.parameter)}"]`)?.classList.add("wrong");
  },
  saved(told) { by("state").textContent = `saved: ${told.path}`; },
  finished(told) { running(state.running && told.run !== state.current, [`written: ${told.files.join(", ")}`, ...told.warnings].join(". Warning: ")); },
  ended(told) { state.ended = told.message; complain(told.message); },
};

socket.addEventListener("message", async ({ data }) => {
  if (typeof data === "string") {
    const told = JSON.parse(data);
    if (["scan", "result", "numbers"].includes(told.is)) state.awaited = told;
    else answers[told.is]?.(told);
  } else {
    const told = state.awaited;
    try { await receive(told, await readMessage(data)); } catch (error) { complain(error.message); }
  }
});
socket.addEventListener("close", () => { running(false, state.ended ? "another page has taken over" : "the server is gone; start pymeshfair tune again"); });

by("recipe").addEventListener("change", () => send("recipe", { recipe: by("recipe").value }));
by("again").addEventListener("click", () => ask(0));
by("stop").addEventListener("click", () => { clearTimeout(state.pending); send("stop"); });
by("settings").addEventListener("submit", (event) => event.preventDefault());
by("save").addEventListener("click", () => { complain(""); send("save", { name: by("recipe-name").value, note: by("note").value, replace: by("replace").checked }); });
by("finish").addEventListener("click", () => { complain(""); send("finish", { name: by("output-name").value, replace: by("replace").checked }); });
by("keep").addEventListener("click", keep);

try {
  viewer = new Viewer(by("viewer"));
  connect(viewer, by("switches"));
} catch (error) { document.querySelector(".stage").replaceChildren(element("p", { class: "problem" }, error.message)); }
