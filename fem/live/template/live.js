// Messages, controls and readings. The page asks for each frame once it has drawn the last, so none can pile up.
(function () {
  const $ = (id) => document.getElementById(id);
  const slowness = $("slowness");
  const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000].filter(
    (value) => value >= Number(slowness.dataset.fastest) && value <= Number(slowness.dataset.slowest));
  const RATE_FRAMES = 20;
  const BLUR = 1; // turns of the rollers a second on the page: from there on 20 frames a second mislead
  const canvas = drawing.over($("bearing")), plots = charts.all();
  const socket = new WebSocket("ws://" + location.host + location.pathname + "live");
  let bearing = null, chosen = null, frame = null, pace = null, address = null, drawn = [], due = false;
  let half = null; // the box in which a number is half written
  const send = (wish) => socket.readyState === WebSocket.OPEN && socket.send(JSON.stringify(wish));
  slowness.max = FACTORS.length - 1;

  const hear = {
    bearing(facts) {
      bearing = facts;
      canvas.forget();
      plots.forget(bearing);
      showValues((input) => !input.matches("[type=range]:active") && input !== half); // not what is being dragged or written
      $("restarts").textContent = "Every change restarts the run, from " + (bearing.start === "rest" ? "rest." : "its new steady state.");
      $("timestep").textContent = round(bearing.step, 3) + " µs";
      $("lines").textContent = bearing.lines.map((line) => line.name + ": " + line.meaning).join("; ") + ".";
      if (address) URL.revokeObjectURL(address);
      address = $("save").href = URL.createObjectURL(new Blob([bearing.toml], { type: "application/toml" }));
    },
    frame(found) {
      frame = found;
      if (!due) requestAnimationFrame(show);
      due = true;
    },
    pace(found) {
      pace = found;
      $("play").textContent = pace.playing ? "Pause" : "Play";
      $("play").setAttribute("aria-pressed", String(pace.playing));
      const at = FACTORS.findIndex((value) => value >= pace.slowness);
      if (!slowness.matches(":active")) slowness.value = at < 0 ? FACTORS.length - 1 : at;
      tellPace(null);
    },
    refused(sentence) {
      say("refused", sentence);
      if (sentence) showValues(() => true);
    },
    telling: (sentence) => say("telling", sentence),
    ...ratings.hear,
  };

  socket.addEventListener("message", (event) => {
    for (const [kind, content] of Object.entries(JSON.parse(event.data))) hear[kind](content);
  });
  socket.addEventListener("open", () => ratings.begin(send));
  socket.addEventListener("close", () => {
    say("ended", "The program or the connection has ended. Start run-live again and open its new address.");
    $("play").disabled = $("step").disabled = true;
  });

  function show() {
    due = false;
    if (ratings.isShown()) return;
    canvas.remember(bearing, frame);
    plots.remember(frame);
    const { magnified, top } = canvas.draw(bearing, frame);
    plots.draw();
    read(magnified, top);
    drawn = [...drawn, performance.now()].slice(-RATE_FRAMES);
    window.live.frames += 1;
    send({ frame: true });
  }

  function read(magnified, top) {
    const largest = Math.max(...frame.outer, ...frame.inner);
    const rate = drawn.length > 1 ? (1e3 * (drawn.length - 1)) / (drawn[drawn.length - 1] - drawn[0]) : 0;
    $("magnified").textContent = "displacements and clearance × " + magnified;
    $("ramp-high").textContent = top + " N";
    $("time").textContent = frame.time.toFixed(2) + " ms";
    $("turned").textContent = ((Math.abs(bearing.values.speed_rpm) / 6e4) * frame.time).toFixed(2) + " turns";
    $("off").textContent = Math.hypot(...frame.hub).toFixed(2) + " µm";
    $("largest").textContent = largest.toFixed(0) + " N";
    $("loaded").textContent = frame.outer.filter((force, j) => Math.max(force, frame.inner[j]) > 0.01 * largest).length + " of " + bearing.rollers;
    $("balance").textContent = percent(frame.imbalance);
    $("balance").classList.toggle("bad", !frame.balanced);
    $("rate").textContent = pace.playing ? rate.toFixed(0) : "–";
    $("record").textContent = frame.frequency.length ? "over the last " + frame.record.toFixed(0) + " ms, in bins of " + round(1e3 / frame.record, 2) + " Hz" : "(after about 3 ms)";
    const risen = Object.entries(frame.envelope.lines).map(([name, value]) => name + " " + round(value, 2) + " g");
    $("risen").textContent = risen.length ? "Now: " + risen.join(", ") + "." : "(after eight rollers have passed)";
    tellPace(frame.slowness);
    const cautions = frame.cautions.map((sentence) => Object.assign(document.createElement("li"), { textContent: "⚠ " + sentence }));
    if (cautions.map((each) => each.textContent).join() !== [...$("cautions").children].map((each) => each.textContent).join()) $("cautions").replaceChildren(...cautions);
    $("cautions").hidden = cautions.length === 0;
  }

  function tellPace(reached) {
    const factor = reached === null ? pace.slowness : reached;
    $("factor").textContent = factor < 1.15 ? "real time" : "1/" + round(factor, factor < 10 ? 2 : 3);
    const shown = 1e3 / factor;
    let text = "One second here is " + (shown < 1 ? round(1e3 * shown, 2) + " µs" : round(shown, 3) + " ms") + " of the bearing.";
    if (turning() / factor > BLUR) text += " Too fast for the eye: snapshots are shown.";
    if (factor > 1.15 * pace.slowness) text += " Asked for " + (pace.slowness === 1 ? "real time" : "1/" + pace.slowness) + ": this is the fastest this machine computes.";
    if (!pace.playing) text = "Paused. Step advances by a twentieth of a second at 1/" + pace.slowness + ".";
    $("pace").textContent = text;
  }

  // turns of the set of rollers a second
  function turning() {
    const cage = bearing ? bearing.lines.find((line) => line.name === "FTF") : null;
    return cage ? cage.frequency : 0;
  }

  function say(id, sentence) {
    $(id).textContent = sentence;
    $(id).hidden = !sentence;
  }

  function round(value, digits) {
    return String(Number(value.toPrecision(digits)));
  }

  function percent(share) {
    return share < 1e-6 ? "< 0.0001 %" : round(100 * share, 2) + " %";
  }

  function showValues(which) {
    chosen = { ...bearing.values };
    for (const input of [...document.querySelectorAll("[data-key]")].filter(which)) input.value = chosen[input.dataset.key];
    for (const input of document.querySelectorAll("[data-needs]")) input.disabled = !chosen[input.dataset.needs];
  }

  function change(key, value) {
    chosen[key] = value;
    send({ values: chosen });
  }

  for (const input of document.querySelectorAll("[data-key]")) {
    const typed = input.type === "number";
    if (typed) input.addEventListener("input", () => { half = input; });
    input.addEventListener(typed ? "change" : "input", () => {
      half = null;
      if (input.value === "") {
        input.value = bearing.values[input.dataset.key];
        return;
      }
      change(input.dataset.key, Number(input.value));
    });
  }
  const factor = () => FACTORS[Number(slowness.value)];
  slowness.addEventListener("input", () => send({ pace: { slowness: factor(), playing: pace.playing } }));
  $("play").addEventListener("click", () => send({ pace: { slowness: pace.slowness, playing: !pace.playing } }));
  $("step").addEventListener("click", () => send({ pace: { slowness: pace.slowness, playing: false }, step: true }));
  $("reset").addEventListener("click", () => send({ values: bearing.given }));
  window.live = { frames: 0, send, frame: () => frame, bearing: () => bearing };
})();
