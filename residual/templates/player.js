// The bearing in motion: rollers by their load, the hub's displacement enlarged, its path at the right.
(function () {
  const data = JSON.parse(document.getElementById("player-data").textContent);
  const canvas = document.getElementById("player-canvas");
  const place = document.getElementById("player-place");
  const button = document.getElementById("player-play");
  const state = document.getElementById("player-state");
  const frames = data.time.length;
  const most = Math.max(1e-9, ...data.force.map((row) => Math.max(...row)));
  const [bore, inner, outer, outside] = data.rings;
  const [pathX, pathY] = data.path;
  const low = [Math.min(...pathX), Math.min(...pathY)];
  const high = [Math.max(...pathX), Math.max(...pathY)];
  const farthest = Math.max(1e-6, ...pathX.map((x, i) => Math.hypot(x, pathY[i])));
  const enlarged = (0.35 * data.roller) / (1e-3 * farthest); // the hub moves by a third of a roller's radius
  const perSecond = 40; // frames
  let frame = 0;
  let playing = false;
  let before = 0;
  place.max = frames - 1;

  function size() {
    const ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = Math.round(Math.min(0.62 * width, 380));
    canvas.style.height = height + "px";
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    return [width, height, ratio];
  }

  function draw() {
    const [width, height, ratio] = size();
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const left = 0.58 * width;
    drawBearing(ctx, 0.5 * left, 0.5 * height, Math.min(0.5 * left, 0.5 * height) / (1.04 * outside));
    drawPath(ctx, left + 8, 20, width - left - 16, height - 56);
    const loads = data.force[frame];
    const [hubX, hubY] = data.hub.map((row) => row[frame].toFixed(3).replace("-", "−"));
    const largest = Math.max(...loads);
    state.textContent =
      data.time[frame].toFixed(2) + " ms: hub x " + hubX + " µm, y " + hubY + " µm; largest load " +
      largest.toPrecision(4) + " N on roller " + loads.indexOf(largest);
    place.value = frame;
  }

  function circle(ctx, x, y, r) {
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
  }

  function ring(ctx, x, y, small, large) {
    for (const [radius, colour] of [[large, "#dfe5ea"], [small, "#fff"]]) {
      circle(ctx, x, y, radius);
      ctx.fillStyle = colour;
      ctx.fill();
      ctx.strokeStyle = "#7b8794";
      ctx.stroke();
    }
  }

  function drawBearing(ctx, x, y, scale) {
    ctx.lineWidth = 1;
    ring(ctx, x, y, scale * outer, scale * outside);
    const hubX = x + scale * enlarged * 1e-3 * data.hub[0][frame];
    const hubY = y - scale * enlarged * 1e-3 * data.hub[1][frame];
    ring(ctx, hubX, hubY, scale * bore, scale * inner);
    const turn = data.turn[frame];
    ctx.beginPath(); // a mark that turns with the shaft
    ctx.moveTo(hubX + scale * bore * Math.cos(turn), hubY - scale * bore * Math.sin(turn));
    ctx.lineTo(hubX + 0.96 * scale * inner * Math.cos(turn), hubY - 0.96 * scale * inner * Math.sin(turn));
    ctx.lineWidth = 3;
    ctx.strokeStyle = "#1b1f24";
    ctx.stroke();
    const pitch = 0.5 * (inner + outer);
    data.angle[frame].forEach((angle, j) => {
      const share = data.force[frame][j] / most;
      const [rollerX, rollerY] = [x + scale * pitch * Math.cos(angle), y - scale * pitch * Math.sin(angle)];
      circle(ctx, rollerX, rollerY, 0.97 * scale * data.roller);
      ctx.fillStyle = share > 0 ? "hsl(205, 80%, " + (88 - 50 * share) + "%)" : "#fff";
      ctx.fill();
      ctx.lineWidth = 1;
      ctx.strokeStyle = "#4a5561";
      ctx.stroke();
      if (j === 0) {
        circle(ctx, rollerX, rollerY, 2);
        ctx.fillStyle = "#1b1f24";
        ctx.fill();
      }
      if (share > 0) {
        const from = inner - 1e-9;
        const to = inner - 0.9 * (inner - bore) * share - 0.15 * bore * share;
        ctx.beginPath(); // the load, inward from its contact
        ctx.moveTo(x + scale * from * Math.cos(angle), y - scale * from * Math.sin(angle));
        ctx.lineTo(x + scale * to * Math.cos(angle), y - scale * to * Math.sin(angle));
        ctx.lineWidth = Math.max(2, 0.22 * scale * data.roller);
        ctx.strokeStyle = "#d55e00";
        ctx.stroke();
      }
    });
    const [loadX, loadY] = [data.load[0][frame], -data.load[1][frame]];
    const load = Math.hypot(loadX, loadY); // of the largest
    if (load > 0.02) {
      const [tipX, tipY] = [hubX + 0.7 * scale * bore * loadX, hubY + 0.7 * scale * bore * loadY];
      const [alongX, alongY] = [loadX / load, loadY / load];
      ctx.beginPath();
      ctx.moveTo(hubX, hubY);
      ctx.lineTo(tipX, tipY);
      ctx.moveTo(tipX - 7 * alongX + 5 * alongY, tipY - 7 * alongY - 5 * alongX);
      ctx.lineTo(tipX, tipY);
      ctx.lineTo(tipX - 7 * alongX - 5 * alongY, tipY - 7 * alongY + 5 * alongX);
      ctx.lineWidth = 2;
      ctx.strokeStyle = "#1b1f24";
      ctx.stroke();
    }
  }

  function drawPath(ctx, x, y, width, height) {
    const reach = 1.1 * Math.max(high[0] - low[0], high[1] - low[1], 1e-6);
    const scale = Math.min(width, height) / reach;
    const toX = (value) => x + 0.5 * width + scale * (value - 0.5 * (low[0] + high[0]));
    const toY = (value) => y + 0.5 * height - scale * (value - 0.5 * (low[1] + high[1]));
    ctx.beginPath();
    pathX.forEach((value, i) => (i ? ctx.lineTo(toX(value), toY(pathY[i])) : ctx.moveTo(toX(value), toY(pathY[i]))));
    ctx.lineWidth = 0.7;
    ctx.strokeStyle = "#7fb3d5";
    ctx.stroke();
    circle(ctx, toX(data.hub[0][frame]), toY(data.hub[1][frame]), 4.5);
    ctx.fillStyle = "#d55e00";
    ctx.fill();
    const step = 10 ** Math.floor(Math.log10(0.5 * reach));
    const length = [5, 2, 1].map((k) => k * step).find((value) => value <= 0.5 * reach) || step;
    ctx.beginPath(); // how long that is
    ctx.moveTo(x + 0.5 * (width - scale * length), y + height + 12);
    ctx.lineTo(x + 0.5 * (width + scale * length), y + height + 12);
    ctx.lineWidth = 2;
    ctx.strokeStyle = "#57606a";
    ctx.stroke();
    ctx.fillStyle = "#57606a";
    ctx.font = "12px system-ui, sans-serif";
    ctx.textAlign = "center";
    ctx.fillText(length < 0.1 ? Number((1e3 * length).toPrecision(3)) + " nm" : Number(length.toPrecision(3)) + " µm", x + 0.5 * width, y + height + 28);
    ctx.fillText("path of the hub", x + 0.5 * width, 12);
  }

  function show(at) {
    frame = Math.max(0, Math.min(frames - 1, Math.round(at)));
    draw();
  }

  function step(now) {
    if (!playing) return;
    if (now - before >= 1000 / perSecond) {
      before = now;
      show((frame + 1) % frames);
    }
    requestAnimationFrame(step);
  }

  function play(on) {
    playing = on;
    button.textContent = on ? "pause" : "play";
    if (on) requestAnimationFrame(step);
  }

  button.addEventListener("click", () => play(!playing));
  place.addEventListener("input", () => {
    play(false);
    show(Number(place.value));
  });
  window.addEventListener("resize", draw);
  draw();
  window.player = { frame: () => frame, playing: () => playing, show };
})();
