// Tabs, and the ratings of one of them: each wish is answered once, of many only the last.
const ratings = (function () {
  const $ = (id) => document.getElementById(id);
  const tabs = [$("motion-tab"), $("ratings-tab")], inputs = [...document.querySelectorAll("[data-load]")];
  const canvas = drawing.over($("section"));
  let send = () => {}, wish = {}, found = null, top = 1e-9, address = null, half = null; // the box in which a number is half written
  const isShown = () => !$("ratings").hidden;

  function element(name, text, parts = {}) {
    return Object.assign(document.createElement(name), { textContent: text, ...parts });
  }

  function ask() {
    wish.bearing = $("designation").value.trim();
    send({ rate: wish });
  }

  function rating(answers) {
    found = answers;
    document.querySelector("#ratings").classList.remove("stale");
    say("");
    for (const input of inputs) {
      const key = input.dataset.load;
      if (input.type === "range") [input.min, input.max, input.step] = found.ends[key];
      if (!input.matches("[type=range]:active") && input !== half) input.value = Number(found.values[key].toFixed(6));
    }
    $("tiles").replaceChildren(...found.tiles.map(([meaning, value]) => pair(meaning, element("dd", value))));
    list();
    $("warned").replaceChildren(...found.warnings.map((sentence) => element("li", "⚠ " + sentence)));
    $("warned").hidden = found.warnings.length === 0;
    $("took").textContent = "Computed in " + found.ms.toFixed(0) + " ms.";
    if (address) URL.revokeObjectURL(address);
    address = $("save-rated").href = URL.createObjectURL(new Blob([found.toml], { type: "application/toml" }));
    $("save-rated").download = found.name + ".toml";
    draw();
  }

  // the sentence of a refusal: answers stay those of the values before
  function say(sentence) {
    $("unrated").textContent = sentence && sentence + "\nThe answers are those of the previous values.";
    $("unrated").hidden = !sentence;
    for (const id of ["tiles", "blocks"]) $(id).classList.toggle("stale", Boolean(sentence));
  }

  function pair(meaning, value) {
    const both = element("div", "");
    both.append(element("dt", meaning), value);
    return both;
  }

  function list() {
    const all = $("reasons").checked, blocks = Object.entries(found.blocks).map(([name, lines]) => block(name, lines.map(line)));
    const missing = Object.entries(found.missing).map(([reason, meanings]) => pair(meanings, element("dd", reason)));
    if (all && missing.length) blocks.push(block("not computed", missing));
    $("blocks").replaceChildren($("picture"), ...blocks);

    function line([meaning, value, source, text]) {
      const cell = element("dd", value, { className: value.includes("\n") ? "matrix" : "" });
      if (all) cell.append(element("small", source, { title: text }));
      return pair(meaning, cell);
    }
  }

  function block(name, lines) {
    const section = element("section", "", { className: "card " + name.replaceAll(" ", "-") }), table = element("dl", "");
    table.append(...lines);
    section.append(element("h2", name), table);
    return section;
  }

  function draw() {
    const at = found && found.picture;
    $("picture").hidden = !at;
    if (!at || !isShown()) return;
    const largest = Math.max(...at.load, 1e-9), zeros = at.load.map(() => 0);
    if (largest > top || largest < 0.3 * top) top = drawing.niceAbove(largest);
    const bearing = { ...at, spalls: [], values: found.values };
    const frame = { ...at, inner: at.load, outer: at.load, turn: zeros, shaft: Math.PI, ring: 0, cage: null, bars: true, top };
    canvas.remember(bearing, frame);
    const { magnified } = canvas.draw(bearing, frame);
    const loaded = at.load.filter((load) => load > 0.01 * largest).length;
    $("section-says").textContent = `Largest ${Number(largest.toPrecision(4))} N, ${loaded} of ${at.load.length} under load. ` +
      `Displacements × ${magnified}.`;
  }

  function show() {
    const chosen = location.hash === "#ratings" ? 1 : 0;
    tabs.forEach((tab, i) => {
      tab.setAttribute("aria-selected", String(i === chosen));
      tab.tabIndex = i === chosen ? 0 : -1;
      $(tab.getAttribute("aria-controls")).hidden = i !== chosen;
    });
    window.dispatchEvent(new Event("resize")); // of charts that were hidden
    if (chosen === 1) ask();
    else send({ frame: true });
  }

  tabs.forEach((tab, i) => {
    tab.addEventListener("click", () => { location.hash = tab.getAttribute("aria-controls"); });
    tab.addEventListener("keydown", (event) => {
      const to = { ArrowLeft: 1 - i, ArrowRight: 1 - i, Home: 0, End: 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      tabs[to].focus();
      tabs[to].click();
    });
  });
  window.addEventListener("hashchange", show);
  window.addEventListener("resize", draw);
  for (const input of inputs) {
    if (input.type === "number") input.addEventListener("input", () => { half = input; });
    input.addEventListener(input.type === "number" ? "change" : "input", () => {
      half = null;
      if (input.value === "") delete wish[input.dataset.load];
      else wish[input.dataset.load] = Number(input.value);
      ask();
    });
  }
  $("designation").addEventListener("change", () => {
    delete wish.clearance_um; // which is another bearing's own
    ask();
  });
  $("unchanged").addEventListener("click", () => {
    wish = {};
    $("designation").value = $("designation").dataset.given;
    ask();
  });
  $("reasons").addEventListener("change", list);

  function begin(sender) {
    send = sender;
    show();
  }

  return { begin, hear: { rating, unrated: say }, isShown, found: () => found };
})();
