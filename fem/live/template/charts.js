// Load zone, orbit and spectrum: axes by uPlot, what moves by its drawing hooks.
const charts = (function () {
  const { theme } = drawing;
  const SOFT = () => theme.soft, RULE = () => theme.rule;
  const FONT = "12px system-ui, sans-serif";
  const AXIS = { stroke: SOFT, grid: { stroke: RULE, width: 1 }, ticks: { stroke: RULE }, values: plain, font: FONT, labelFont: FONT, labelSize: 18, labelGap: 2 };
  const ACROSS = { ...AXIS, size: 30 }; // room for its numbers
  const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";

  function power(value) {
    const exponent = Math.round(Math.log10(value));
    return "10" + (exponent < 0 ? "⁻" : "") + String(Math.abs(exponent)).replace(/\d/g, (digit) => RAISED[digit]);
  }

  // numbers of an axis with the decimals of its steps
  function plain(u, values, axis, space, step) {
    let decimals = 0;
    while (decimals < 9 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6) decimals++;
    return values.map((value) => value.toFixed(decimals).replace("-", "−"));
  }

  function plot(holder, options, data) {
    const made = new uPlot(
      { width: holder.clientWidth, height: holder.clientHeight, padding: [12, 12, 0, 0], legend: { show: false }, cursor: { show: false }, ...options },
      data, holder);
    return made;
  }

  function clipped(u, paint) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    paint(ctx, devicePixelRatio);
    ctx.restore();
  }

  function zone(holder) {
    const MOST = 4000;
    let past = [], now = [[], []], top = 1;
    const u = plot(holder, {
      scales: { x: { time: false, range: [-180, 180] }, y: { range: () => [0, top] } },
      axes: [
        { ...ACROSS, label: "angle from the load's direction, degrees", splits: () => [-180, -90, 0, 90, 180] },
        { ...AXIS, label: "force on the outer ring, N", size: 58 },
      ],
      series: [{}, { show: true, paths: () => null, points: { show: false } }],
      hooks: { draw: [(u) => clipped(u, paint)] },
    }, [[-180, 180], [0, 1]]);

    function paint(ctx, ratio) {
      ctx.fillStyle = theme.zone;
      for (const [angle, force] of past) dot(ctx, angle, force, 1.2 * ratio);
      ctx.strokeStyle = ctx.fillStyle = theme.deep;
      ctx.lineWidth = 1.5 * ratio;
      now[0].forEach((angle, j) => {
        const x = u.valToPos(angle, "x", true);
        ctx.beginPath();
        ctx.moveTo(x, u.valToPos(0, "y", true));
        ctx.lineTo(x, u.valToPos(now[1][j], "y", true));
        ctx.stroke();
        dot(ctx, angle, now[1][j], 4 * ratio);
      });
    }

    function dot(ctx, angle, force, size) {
      ctx.beginPath();
      ctx.arc(u.valToPos(angle, "x", true), u.valToPos(force, "y", true), size, 0, 2 * Math.PI);
      ctx.fill();
    }

    return {
      u,
      forget: () => { past = []; top = 1; },
      remember(frame) {
        const angle = frame.angle.map((value) => (value * 180) / Math.PI);
        past.push(...angle.map((value, j) => [value, frame.outer[j]]));
        past.splice(0, past.length - MOST);
        now = [angle, frame.outer];
        top = Math.max(top, drawing.niceAbove(1.02 * Math.max(...frame.outer, 1)));
      },
      draw: () => u.setData([[-180, 180], [0, 1]]),
    };
  }

  // pressure along rollers that tilt, on the unrolled inner raceway
  function pressure(holder) {
    let slices = [], length = 1, now = [[], []], top = 1;
    const u = plot(holder, {
      scales: { x: { time: false, range: [-180, 180] }, y: { range: () => [-0.5 * length, 0.5 * length] } },
      axes: [
        { ...ACROSS, label: "angle from the load's direction, degrees", splits: () => [-180, -90, 0, 90, 180] },
        { ...AXIS, label: "along the axis, mm", size: 58 },
      ],
      series: [{}, { show: true, paths: () => null, points: { show: false } }],
      hooks: { draw: [(u) => clipped(u, paint)] },
    }, [[-180, 180], [0, 0]]);

    function paint(ctx) {
      const wide = Math.abs(u.valToPos(0.4 * (360 / now[0].length), "x", true) - u.valToPos(-0.4 * (360 / now[0].length), "x", true));
      const edges = slices.map((z) => u.valToPos(z + (0.5 * length) / slices.length, "y", true));
      const high = Math.abs(u.valToPos(length / slices.length, "y", true) - u.valToPos(0, "y", true));
      now[0].forEach((angle, j) => {
        const left = u.valToPos(angle, "x", true) - 0.5 * wide;
        ctx.strokeStyle = theme.rule;
        ctx.strokeRect(left, u.bbox.top, wide, u.bbox.height);
        now[1][j].forEach((value, k) => {
          if (value <= 0) return;
          ctx.fillStyle = drawing.colour(value / top);
          ctx.fillRect(left, edges[k], wide, high + 0.5);
        });
      });
    }

    return {
      u,
      forget: (bearing) => { [slices, length, top, now] = [bearing.slices, bearing.length, 1, [[], []]]; },
      remember(frame) {
        const highest = Math.max(...frame.pressures.flat());
        now = [frame.angle.map((value) => (value * 180) / Math.PI), frame.pressures];
        top = Math.max(top, drawing.niceAbove(Math.max(highest, 1)));
        document.getElementById("pressure-high").textContent = top + " MPa";
        document.getElementById("pressure-now").textContent = highest.toFixed(0) + " MPa";
      },
      draw: () => u.setData([[-180, 180], [0, 0]]),
    };
  }

  function orbit(holder) {
    const MOST = 4000;
    let way = [[], []], middle = [0, 0], half = 1e-3;
    const u = plot(holder, {
      scales: {
        x: { time: false, range: (u) => (u.bbox.height ? [middle[0] - half * shapeOf(u), middle[0] + half * shapeOf(u)] : [-1, 1]) },
        y: { range: () => [middle[1] - half, middle[1] + half] },
      },
      axes: [{ ...ACROSS, label: "displacement of the hub in x, to the right, µm", space: 56 }, { ...AXIS, label: "displacement in y, up, µm", size: 62 }],
      series: [{}, { show: true, paths: () => null, points: { show: false } }],
      hooks: { draw: [(u) => clipped(u, paint)] },
    }, [[-1, 1], [0, 0]]);

    function shapeOf(u) {
      return Math.max(0.2, u.bbox.width / u.bbox.height);
    }

    function paint(ctx, scale) {
      const [x, y] = way, n = x.length;
      ctx.lineJoin = "round";
      ctx.lineWidth = 1.3 * scale;
      const pieces = 12;
      for (let k = 0; k < pieces; k++) {
        const from = Math.floor((n * k) / pieces), to = Math.min(n - 1, Math.floor((n * (k + 1)) / pieces));
        ctx.strokeStyle = theme.accent;
        ctx.globalAlpha = 0.12 + (0.88 * (k + 1)) / pieces;
        ctx.beginPath();
        for (let i = from; i <= to; i++) ctx.lineTo(u.valToPos(x[i], "x", true), u.valToPos(y[i], "y", true));
        ctx.stroke();
      }
      ctx.globalAlpha = 1;
      if (n === 0) return;
      ctx.fillStyle = theme.deep;
      ctx.beginPath();
      ctx.arc(u.valToPos(x[n - 1], "x", true), u.valToPos(y[n - 1], "y", true), 4 * scale, 0, 2 * Math.PI);
      ctx.fill();
    }

    function fit() {
      const low = way.map((values) => Math.min(...values)), high = way.map((values) => Math.max(...values));
      const wide = Math.max((high[0] - low[0]) / shapeOf(u), high[1] - low[1], 1e-3);
      const centre = low.map((value, i) => 0.5 * (value + high[i]));
      const out = Math.max(Math.abs(centre[0] - middle[0]) / shapeOf(u), Math.abs(centre[1] - middle[1])) + 0.5 * wide > half;
      if (out || wide < 0.4 * half) [middle, half] = [centre, 0.75 * wide];
    }

    return {
      u,
      forget: () => { way = [[], []]; half = 1e-3; },
      remember(frame) {
        way = way.map((values, i) => values.concat(frame.orbit[i]).slice(-MOST));
        if (way[0].length) fit();
      },
      draw: () => u.setData([[-1, 1], [0, 0]]),
    };
  }

  // frequencies by name, from low to high; names that would overlap go to a further row, or are left out
  function mark(u, lines, rows) {
    const { ctx, bbox } = u, ratio = devicePixelRatio;
    ctx.save();
    ctx.font = 11 * ratio + "px system-ui, sans-serif";
    ctx.textAlign = "center";
    const last = Array(rows).fill(-1e9);
    for (const line of lines) {
      const x = u.valToPos(line.frequency, "x", true);
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      ctx.strokeStyle = line.faint ? theme.rule : theme.soft;
      ctx.lineWidth = ratio;
      ctx.setLineDash([4 * ratio, 3 * ratio]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      const wide = ctx.measureText(line.name).width;
      const row = last.findIndex((end) => x - 0.5 * wide >= end + 4 * ratio);
      if (row < 0) continue;
      ctx.fillStyle = theme.soft;
      ctx.fillText(line.name, x, bbox.top - (6 + 12 * row) * ratio);
      last[row] = x + 0.5 * wide;
    }
    ctx.restore();
  }

  function spectrum(holder) {
    const DECADES = 5, NAMED = [20, 100, 500, 2e3, 1e4];
    let lines = [], data = [[20, 2e4], [null, null], [null, null]], top = 1;
    const decades = (u, axis, low, high) => {
      const found = [];
      for (let k = Math.ceil(Math.log10(low) - 1e-9); k <= Math.log10(high) + 1e-9; k++) found.push(Number("1e" + k));
      return found;
    };
    const u = plot(holder, {
      padding: [22, 12, 0, 0],
      scales: { x: { time: false, distr: 3, range: [20, 2e4] }, y: { distr: 3, range: () => [top * Math.pow(10, -DECADES), top] } },
      axes: [
        { ...ACROSS, label: "frequency, Hz", splits: () => [20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 2e4], filter: (u, splits) => splits,
          values: (u, values) => values.map((value) => (NAMED.includes(value) ? (value < 1e3 ? String(value) : value / 1e3 + "k") : "")) },
        { ...AXIS, label: "amplitude of acceleration, m/s²", size: 58, splits: decades, filter: (u, splits) => splits, values: (u, values) => values.map(power) },
      ],
      series: [{}, { stroke: () => theme.accent, width: 1.3, points: { show: false } }, { stroke: () => theme.load, width: 1.3, points: { show: false } }],
      hooks: { drawClear: [(u) => mark(u, lines, 1)] },
    }, data);

    return {
      u,
      forget(bearing) {
        const more = (line) => [2, 3, 4, 5].map((k) => ({ name: k + "×", frequency: k * line.frequency, faint: true }));
        const own = bearing.lines;
        lines = [...own, ...own.filter((line) => line.name === "BPFO").flatMap(more)];
        lines.sort((a, b) => a.frequency - b.frequency);
        top = 1e-3;
      },
      remember(frame) {
        if (frame.frequency.length === 0) {
          data = [[20, 2e4], [null, null], [null, null]];
          return;
        }
        data = [frame.frequency, ...frame.amplitude.map((axis) => axis.map((value) => value || null))];
        const highest = Math.max(...frame.amplitude.flat(), 1e-6);
        const wanted = Math.pow(10, Math.ceil(Math.log10(highest)));
        if (wanted > top || wanted < 0.05 * top) top = wanted;
      },
      draw: () => u.setData(data),
    };
  }

  function envelope(holder) {
    let lines = [], data = [[0, 1], [null, null]], end = 1, top = 1e-9;
    const u = plot(holder, {
      padding: [32, 12, 0, 0],
      scales: { x: { time: false, range: () => [0, end] }, y: { range: () => [0, top] } },
      axes: [{ ...ACROSS, label: "frequency, Hz" }, { ...AXIS, label: "amplitude of the envelope, g", size: 64 }],
      series: [{}, { stroke: () => theme.load, width: 1.3, points: { show: false } }],
      hooks: { drawClear: [(u) => mark(u, lines, 2)] },
    }, data);
    return {
      u,
      forget(bearing) {
        lines = [...bearing.faults].sort((a, b) => a.frequency - b.frequency);
        end = 2.3 * Math.max(...lines.map((line) => line.frequency), 1);
      },
      remember(frame) {
        const { bin, amplitude } = frame.envelope;
        data = amplitude.length ? [amplitude.map((value, i) => i * bin), amplitude] : [[0, end], [null, null]];
        const highest = 1.1 * Math.max(...amplitude, 1e-9); // the scale stays while values change, so that a line is seen to rise
        if (highest > top || highest < 0.2 * top) top = highest;
      },
      draw: () => u.setData(data),
    };
  }

  function all() {
    const holder = (name) => document.querySelector("#" + name + " .plot");
    const made = [zone(holder("zone")), orbit(holder("orbit")), spectrum(holder("spectrum")), envelope(holder("envelope"))];
    if (holder("pressure")) made.push(pressure(holder("pressure")));
    const resize = () => made.forEach(({ u }) => {
      const room = u.root.parentElement;
      if (room.clientWidth && (u.width !== room.clientWidth || u.height !== room.clientHeight)) u.setSize({ width: room.clientWidth, height: room.clientHeight });
    });
    window.addEventListener("resize", resize);
    return {
      forget: (bearing) => made.forEach((chart) => chart.forget(bearing)),
      remember: (frame) => made.forEach((chart) => chart.remember(frame)),
      draw: () => made.forEach((chart) => chart.draw()),
    };
  }

  return { all, plain };
})();
