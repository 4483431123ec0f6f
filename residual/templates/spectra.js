// The spectra of both errors, drawn by uPlot: drag to zoom, double-click for the whole band, or use the buttons.
(function () {
  const data = JSON.parse(document.getElementById("spectra-data").textContent);
  const holder = document.getElementById("spectra-plot");
  const band = [data.frequency[0], data.frequency[data.frequency.length - 1]];
  const raised = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  let logarithmic = true;
  let plot = null;

  // places 1 to 9 of every decade in sight
  function places(u, axis, low, high) {
    const found = [];
    for (let decade = Math.floor(Math.log10(low)); decade <= Math.log10(high); decade++) {
      for (let k = 1; k < 10; k++) found.push(Number(k + "e" + decade));
    }
    return found.filter((value) => value >= low && value <= high);
  }

  // powers of ten have a name; where few are in sight, others too
  function names(u, values) {
    const first = values.map((value) => value.toExponential()[0]);
    const decades = first.filter((digit) => digit === "1").length;
    return values.map((value, i) => {
      if (decades > 2) return first[i] === "1" ? power(value) : "";
      return decades === 0 || "125".includes(first[i]) ? short(value) : "";
    });
  }

  function power(value) {
    const exponent = Math.round(Math.log10(value));
    const digits = String(Math.abs(exponent)).replace(/\d/g, (digit) => raised[digit]);
    return "10" + (exponent < 0 ? "⁻" : "") + digits;
  }

  function short(value) {
    return value == null ? "–" : value.toPrecision(4).replace(/\.?0+(e|$)/, "$1").replace("e", "·10^").replace("-", "−");
  }

  function markLines(u) {
    const { ctx, bbox } = u;
    const ratio = devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top - 16 * ratio, bbox.width, bbox.height + 16 * ratio);
    ctx.clip();
    ctx.font = 12 * ratio + "px system-ui, sans-serif";
    ctx.textAlign = "center";
    const named = [];
    for (const line of data.lines) {
      const x = u.valToPos(line.frequency, "x", true);
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      ctx.strokeStyle = ctx.fillStyle = line.colour;
      ctx.lineWidth = ratio;
      ctx.setLineDash(line.name.includes("×") ? [ratio, 3 * ratio] : [5 * ratio, 3 * ratio]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      const half = 0.5 * ctx.measureText(line.name).width + 2 * ratio;
      if (named.every((other) => Math.abs(other.x - x) > other.half + half)) {
        ctx.fillText(line.name, x, bbox.top - 4 * ratio);
        named.push({ x, half });
      }
    }
    ctx.restore();
  }

  function draw(from, to) {
    const width = holder.clientWidth;
    if (plot) plot.destroy();
    const kind = logarithmic ? 3 : 1;
    const ticks = logarithmic ? { splits: places, filter: (u, splits) => splits, values: names } : { values: (u, values) => values.map(short) };
    const axis = { stroke: "#57606a", grid: { stroke: "#e3e3e3", width: 1 }, ticks: { stroke: "#d8dee4" } };
    plot = new uPlot({
      width, height: Math.max(260, Math.min(420, 0.6 * width)), padding: [18, 8, 0, 0],
      scales: { x: { time: false, distr: kind, range: (u, low, high) => [low, high] }, y: { distr: kind } },
      axes: [
        { ...axis, ...ticks, label: "frequency, Hz" },
        { ...axis, ...ticks, label: "PSD, " + data.unit, size: 62 },
      ],
      series: [
        { label: "Hz", value: (u, value) => short(value) },
        { label: data.names[0], stroke: "#0072b2", width: 1, value: (u, value) => short(value) },
        { label: data.names[1], stroke: "#d55e00", width: 1, value: (u, value) => short(value) },
      ],
      cursor: { drag: { x: true, y: false } },
      hooks: { draw: [markLines] },
    }, [data.frequency, data.x, data.y], holder);
    plot.setScale("x", { min: from, max: to });
  }

  // on a logarithmic axis "twice as near" is meant in octaves
  const to = (value) => (logarithmic ? Math.log(value) : value);
  const back = (value) => (logarithmic ? Math.exp(value) : value);

  function look(change) {
    const [low, high] = change(to(plot.scales.x.min), to(plot.scales.x.max));
    show(back(low), back(high));
  }

  function show(low, high) {
    const from = Math.max(low, band[0]);
    const end = Math.min(high, band[1]);
    const inside = data.frequency.filter((frequency) => frequency >= from && frequency <= end).length;
    if (inside > 2) plot.setScale("x", { min: from, max: end });
  }

  const actions = {
    whole: () => show(band[0], band[1]),
    paper: () => show(band[0], Math.max(300, data.frequency[3])),
    in: () => look((a, b) => [a + 0.25 * (b - a), b - 0.25 * (b - a)]),
    out: () => look((a, b) => [a - 0.5 * (b - a), b + 0.5 * (b - a)]),
    left: () => look((a, b) => [a - 0.3 * (b - a), Math.max(b - 0.3 * (b - a), to(band[0]))]),
    right: () => look((a, b) => [Math.min(a + 0.3 * (b - a), to(band[1])), b + 0.3 * (b - a)]),
    csv: () => {
      const rows = data.frequency.map((frequency, i) => [frequency, data.x[i], data.y[i]].join(","));
      const head = ["frequency_Hz", ...data.names.map((name) => "psd_" + name)].join(",");
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([head + "\n" + rows.join("\n") + "\n"], { type: "text/csv" }));
      link.download = "spectra.csv";
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    },
    axes: () => {
      const { min, max } = plot.scales.x;
      logarithmic = !logarithmic;
      draw(min, max);
    },
  };
  for (const button of document.querySelectorAll("#spectra button")) {
    button.addEventListener("click", actions[button.dataset.action]);
  }
  const resize = () => plot.setSize({ width: holder.clientWidth, height: plot.height });
  window.addEventListener("resize", resize);
  window.matchMedia("print").addEventListener("change", resize);
  draw(band[0], band[1]);
  window.spectra = { range: () => [plot.scales.x.min, plot.scales.x.max] };
})();
