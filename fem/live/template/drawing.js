// The bearing's cross-section on a canvas. World: mm, x right, y up, the middle of the outer ring at 0.
const drawing = (function () {
  const scheme = matchMedia("(prefers-color-scheme: dark)");
  const theme = {}; // colours of live.css
  const SHOWN = 0.12; // of a roller's radius: how far the largest displacement is drawn
  const NICE = [1, 2, 5];
  const BINS = 240; // of the load zone around the outer ring
  const SHARE = 0.12; // of a frame in the zone shown, which is a mean of the last ones
  const FADING = 0.99; // of the largest force, a frame: colours come back after a blow
  const LADDER = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];
  const MOST = 1e4; // magnification: beyond, nanometres would be shown as if they mattered

  function readTheme() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ["ink", "soft", "rule", "accent", "load", "steel", "edge", "hub", "fault", "zone", "deep", "mark", "cage"])
      theme[name] = style.getPropertyValue("--" + name).trim();
    theme.ramp = style.getPropertyValue("--ramp").split(",").map((text) => [1, 3, 5].map((at) => parseInt(text.trim().slice(at, at + 2), 16)));
  }
  readTheme();
  scheme.addEventListener("change", readTheme);

  function niceBelow(value) {
    const decade = Math.pow(10, Math.floor(Math.log10(value)));
    return Math.max(...NICE.filter((n) => n * decade <= value * 1.000001)) * decade;
  }

  function niceAbove(value) {
    const decade = Math.pow(10, Math.floor(Math.log10(value)));
    return LADDER.find((n) => n * decade >= value * 0.999999) * decade;
  }

  function colour(share) {
    const at = Math.min(Math.max(share, 0), 1) * (theme.ramp.length - 1);
    const k = Math.min(Math.floor(at), theme.ramp.length - 2);
    const mixed = theme.ramp[k].map((low, i) => Math.round(low + (at - k) * (theme.ramp[k + 1][i] - low)));
    return "rgb(" + mixed.join(",") + ")";
  }

  function over(canvas) {
    const zone = new Float32Array(BINS);
    let strongest = 1e-9, furthest = 1e-9, top = 1e-9, frames = 0;

    function forget() {
      frames = 0;
      strongest = furthest = top = 1e-9;
    }

    function remember(bearing, frame) {
      if (frame.bars) [furthest, top] = [1e-9, frame.top];
      strongest = frame.bars ? frame.top : Math.max(FADING * strongest, ...frame.outer, ...frame.inner);
      if (strongest > top || strongest < 0.4 * top) top = niceAbove(strongest);
      const gap = 500 * Math.abs(bearing.outer - bearing.inner - 2 * bearing.roller);
      furthest = Math.max(furthest, gap, Math.hypot(...frame.hub), ...frame.rise.map(Math.abs));
      const share = Math.max(SHARE, 1 / ++frames);
      for (const [i, force] of around(frame).entries()) zone[i] += share * (force - zone[i]);
    }

    // forces on the outer ring over the whole circle, from the load on, straight from roller to roller
    function around(frame) {
      const rollers = frame.angle.map((angle, j) => [((angle / (2 * Math.PI) + 1) % 1) * BINS, frame.outer[j]]);
      rollers.sort((a, b) => a[0] - b[0]);
      const [first, last] = [rollers[0], rollers[rollers.length - 1]];
      const ends = [[last[0] - BINS, last[1]], ...rollers, [first[0] + BINS, first[1]]];
      const found = new Float32Array(BINS);
      for (let k = 0, i = 0; i < BINS; i++) {
        while (ends[k + 1][0] < i) k++;
        const [[a, low], [b, high]] = [ends[k], ends[k + 1]];
        found[i] = low + (high - low) * Math.min(1, (i - a) / Math.max(b - a, 1e-9));
      }
      return found;
    }

    function draw(bearing, frame) {
      const ratio = window.devicePixelRatio || 1;
      const width = canvas.clientWidth, height = canvas.clientHeight;
      if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
      }
      const c = canvas.getContext("2d");
      const room = 1.26 * bearing.outside;
      const pixel = (2 * room) / Math.min(width, height); // mm
      c.setTransform(1, 0, 0, 1, 0, 0);
      c.clearRect(0, 0, canvas.width, canvas.height);
      c.setTransform(ratio / pixel, 0, 0, -ratio / pixel, (width * ratio) / 2, (height * ratio) / 2);
      const magnified = Math.min(MOST, niceBelow((1e3 * SHOWN * bearing.roller) / furthest));
      const mm = magnified * 1e-3;
      const gap = 0.5 * magnified * (bearing.outer - bearing.inner - 2 * bearing.roller);
      const pitch = 0.5 * (bearing.inner + bearing.outer);
      const shape = { outer: pitch + bearing.roller + gap, inner: pitch - bearing.roller - gap, pitch, mm, pixel, top };
      if (frame.bars) drawBars(c, bearing, frame, shape);
      else drawZone(c, bearing, shape);
      drawOuterRing(c, bearing, shape);
      drawInnerRing(c, bearing, frame, shape);
      if (frame.cage !== null) drawCage(c, bearing, frame, shape);
      frame.angle.forEach((angle, j) => drawRoller(c, bearing, frame, shape, j));
      drawSpalls(c, bearing, frame, shape);
      drawLoad(c, bearing, frame, shape);
      return { magnified, top };
    }

    function drawZone(c, bearing, shape) {
      const base = 1.015 * bearing.outside, reach = 0.22 * bearing.outside;
      c.beginPath();
      for (let i = 0; i <= BINS; i++) {
        const angle = (2 * Math.PI * i) / BINS - Math.PI / 2;
        const radius = base + reach * Math.min(1, zone[i % BINS] / shape.top);
        c.lineTo(radius * Math.cos(angle), radius * Math.sin(angle));
      }
      c.arc(0, 0, base, -Math.PI / 2, (-5 * Math.PI) / 2, true);
      c.fillStyle = theme.zone;
      c.fill();
    }

    // load of each element of a bearing at rest
    function drawBars(c, bearing, frame, shape) {
      const base = 1.015 * bearing.outside, reach = 0.22 * bearing.outside;
      const wide = 0.7 * Math.min(0.5, Math.PI / frame.angle.length);
      frame.angle.forEach((from, j) => {
        if (frame.outer[j] <= 0) return;
        const angle = from - Math.PI / 2, share = Math.min(1, frame.outer[j] / shape.top), end = base + reach * share;
        c.beginPath();
        c.arc(0, 0, base, angle - wide, angle + wide);
        c.arc(0, 0, end, angle + wide, angle - wide, true);
        c.fillStyle = colour(share);
        c.fill();
      });
    }

    function annulus(c, x, y, inside, outside, fill, line) {
      c.beginPath();
      c.arc(x, y, outside, 0, 2 * Math.PI);
      c.arc(x, y, inside, 0, 2 * Math.PI, true);
      c.fillStyle = fill;
      c.fill("evenodd");
      for (const radius of [inside, outside]) {
        c.beginPath();
        c.arc(x, y, radius, 0, 2 * Math.PI);
        c.strokeStyle = line;
        c.stroke();
      }
    }

    function drawOuterRing(c, bearing, shape) {
      c.lineWidth = 1.2 * shape.pixel;
      annulus(c, 0, 0, shape.outer, bearing.outside, theme.steel, theme.edge);
    }

    function drawInnerRing(c, bearing, frame, shape) {
      const x = frame.hub[0] * shape.mm, y = frame.hub[1] * shape.mm;
      annulus(c, x, y, bearing.bore, shape.inner, theme.steel, theme.edge);
      annulus(c, x, y, 0, bearing.bore, theme.hub, theme.edge);
      c.save();
      c.translate(x, y);
      c.rotate(frame.shaft);
      c.fillStyle = theme.edge; // the shaft's key shows how it turns
      const key = 0.16 * bearing.bore;
      c.fillRect(bearing.bore - key, -key, 2 * key, 2 * key);
      c.restore();
    }

    // bars between the pockets
    function drawCage(c, bearing, frame, shape) {
      const pitch = shape.pitch, wide = 0.34 * bearing.roller, apart = (2 * Math.PI) / bearing.pockets;
      const half = Math.asin((bearing.roller + 0.5 * bearing.play) / pitch);
      c.fillStyle = theme.cage;
      for (let j = 0; j < bearing.pockets; j++) {
        const from = frame.cage + j * apart + half, to = frame.cage + (j + 1) * apart - half;
        c.beginPath();
        c.arc(0, 0, pitch + wide, from, to);
        c.arc(0, 0, pitch - wide, to, from, true);
        c.fill();
      }
    }

    function drawRoller(c, bearing, frame, shape, j) {
      const angle = frame.angle[j] - Math.PI / 2;
      const from = shape.pitch + frame.rise[j] * shape.mm;
      c.save();
      c.translate(from * Math.cos(angle), from * Math.sin(angle));
      c.beginPath();
      c.arc(0, 0, bearing.roller, 0, 2 * Math.PI);
      const load = Math.max(frame.inner[j], frame.outer[j]);
      c.fillStyle = colour(load / shape.top);
      c.fill();
      c.strokeStyle = theme.edge;
      c.stroke();
      c.rotate(frame.turn[j]);
      c.beginPath();
      c.moveTo(0.35 * bearing.roller, 0);
      c.lineTo(0.85 * bearing.roller, 0);
      c.strokeStyle = theme.mark;
      c.lineWidth = 2 * shape.pixel;
      c.stroke();
      c.lineWidth = 1.2 * shape.pixel;
      c.restore();
    }

    function drawSpalls(c, bearing, frame, shape) {
      for (const spall of bearing.spalls) {
        c.save();
        let radius = shape.outer, side = 1, angle = spall.angle;
        if (spall.body === "inner_ring") {
          c.translate(frame.hub[0] * shape.mm, frame.hub[1] * shape.mm);
          [radius, side, angle] = [shape.inner, -1, angle + frame.shaft];
        } else if (spall.body === "outer_ring") {
          angle += frame.ring;
        } else if (spall.body === "roller") {
          const place = frame.angle[spall.roller] - Math.PI / 2;
          const from = shape.pitch + frame.rise[spall.roller] * shape.mm;
          c.translate(from * Math.cos(place), from * Math.sin(place));
          [radius, side, angle] = [bearing.roller, -1, angle + frame.turn[spall.roller]];
        }
        const half = Math.max(spall.half, (2 * shape.pixel) / radius), deep = 0.07 * bearing.roller + 2 * shape.pixel;
        c.beginPath();
        c.arc(0, 0, radius, angle - half, angle + half);
        c.arc(0, 0, radius + side * deep, angle + half, angle - half, true);
        c.fillStyle = theme.fault;
        c.fill();
        const inside = spall.body === "inner_ring" ? bearing.bore : bearing.outside;
        if (spall.body !== "roller") write(c, shape, "spall", 0.5 * (radius + inside) + side * 1.5 * shape.pixel, angle, theme.fault, 12);
        c.restore();
      }
    }

    function write(c, shape, text, radius, angle, fill, size) {
      c.save();
      c.translate(radius * Math.cos(angle), radius * Math.sin(angle));
      c.scale(shape.pixel, -shape.pixel);
      c.font = "600 " + size + "px system-ui, sans-serif";
      c.textAlign = "center";
      c.textBaseline = "middle";
      c.fillStyle = fill;
      c.fillText(text, 0, 0);
      c.restore();
    }

    function arrow(c, shape, x, y, dx, dy) {
      const long = Math.hypot(dx, dy) || 1, head = 9 * shape.pixel;
      const ux = dx / long, uy = dy / long;
      c.lineTo(x, y);
      c.stroke();
      c.beginPath();
      c.moveTo(x + ux * head, y + uy * head);
      c.lineTo(x - uy * 0.55 * head, y + ux * 0.55 * head);
      c.lineTo(x + uy * 0.55 * head, y - ux * 0.55 * head);
      c.fill();
    }

    function drawLoad(c, bearing, frame, shape) {
      const x = frame.hub[0] * shape.mm, y = frame.hub[1] * shape.mm, bore = bearing.bore;
      c.save();
      c.translate(x, y);
      c.strokeStyle = c.fillStyle = theme.deep;
      c.lineWidth = 3 * shape.pixel;
      if (bearing.values.radial_load_N > 0) {
        c.beginPath();
        c.moveTo(0, 0);
        arrow(c, shape, 0, -0.4 * bore, 0, -1);
      }
      c.beginPath();
      c.arc(0, 0, 2.5 * shape.pixel, 0, 2 * Math.PI);
      c.fill();
      const speed = bearing.values.speed_rpm;
      if (speed !== 0) {
        const way = Math.sign(speed), end = Math.PI / 2 + way * 0.75, radius = 0.78 * bore;
        c.strokeStyle = c.fillStyle = theme.accent;
        c.beginPath();
        c.arc(0, 0, radius, Math.PI / 2 - way * 0.75, end, way < 0);
        arrow(c, shape, radius * Math.cos(end), radius * Math.sin(end), -way * Math.sin(end), way * Math.cos(end));
      }
      const size = Math.max(10, Math.min(14, (0.24 * bore) / shape.pixel));
      write(c, shape, speed + " rpm", 0.27 * bore, Math.PI / 2, theme.accent, size);
      const below = Math.max(0.66 * bore, 0.4 * bore + (9 + 0.6 * size) * shape.pixel);
      write(c, shape, bearing.values.radial_load_N + " N", below, -Math.PI / 2, theme.deep, size);
      const axial = bearing.values.axial_load_N; // out of the plane, or into it
      if (axial) write(c, shape, (axial > 0 ? "⊙ " : "⊗ ") + Math.abs(axial) + " N", 0.55 * bore, 0, theme.deep, size);
      c.restore();
    }

    return { draw, forget, remember };
  }

  return { over, niceAbove, colour, theme };
})();
