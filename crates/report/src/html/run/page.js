"use strict";
// Plays the run in the picture of the line, and draws the timeline of the stations.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const byId = (id) => document.getElementById(id);
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const SVG = "http://www.w3.org/2000/svg";

  // ---- Columns of numbers -----------------------------------------------------------------

  // Decompresses a column and reads its numbers: seven bits in each byte, the lowest first.
  async function numbers(packed) {
    const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const raw = new Uint8Array(await new Response(stream).arrayBuffer());
    let at = 0;
    return () => {
      let value = 0;
      for (let scale = 1; ; scale *= 128) {
        const byte = raw[at++];
        value += (byte & 127) * scale;
        if (byte < 128) return value;
      }
    };
  }

  // By station: the times at which its state changes, and the states.
  async function readStates(column) {
    if (!column) return null;
    const next = await numbers(column.bytes);
    const times = new Float64Array(column.count);
    const states = new Uint8Array(column.count);
    let ticks = 0;
    for (let i = 0; i < column.count; i++) {
      const number = next();
      ticks += Math.floor(number / 8);
      times[i] = ticks * data.tick;
      states[i] = number % 8;
    }
    return { times, states };
  }

  // By place: the times at which it refused something.
  async function readTimes(column) {
    if (!column) return null;
    const next = await numbers(column.bytes);
    let ticks = 0;
    return Float64Array.from({ length: column.count }, () => (ticks += next()) * data.tick);
  }

  // By station: the percentages of the states in each bin of time after the last known change.
  async function readShares(column) {
    if (!column) return null;
    const next = await numbers(column.bytes);
    return Uint8Array.from({ length: column.count * data.stateNames.length }, next);
  }

  async function readMoves() {
    const { count, bytes } = data.moves;
    const next = await numbers(bytes);
    const moves = { times: new Float64Array(count), parts: new Float64Array(count), targets: new Int32Array(count), kinds: new Int16Array(count) };
    let ticks = 0;
    for (let i = 0; i < count; i++) {
      ticks += next();
      // Rounding does not move the last ones beyond the end.
      moves.times[i] = Math.min(ticks * data.tick, data.end);
      moves.parts[i] = next();
      const target = next();
      moves.targets[i] = Math.floor(target / 2);
      moves.kinds[i] = target % 2 ? next() : -1;
    }
    return moves;
  }

  // Index of the last entry that is not after the time; -1 if there is none.
  function last(times, time) {
    let low = 0, high = times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle + 1; else high = middle;
    }
    return low - 1;
  }

  // Places in ascending order, those less than a distance apart as one: first, last, and how many.
  function merged(places, distance) {
    const groups = [];
    for (const place of places) {
      const group = groups.at(-1);
      if (group && place - group[1] < distance) { group[1] = place; group[2]++; } else groups.push([place, place, 1]);
    }
    return groups;
  }

  // ---- Numbers for people -------------------------------------------------------------------

  const two = (n) => String(n).padStart(2, "0");
  const DAY = 86400;
  // The day on which a moment is, such as "Mon 5 Jan"; null for a line without a calendar.
  function dayOf(seconds) {
    if (!data.days) return null;
    const day = Math.floor(seconds / DAY);
    const name = ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"][(data.days.weekday + day) % 7];
    if (!data.days.date) return day < 7 ? name : `${name} week ${Math.floor(day / 7) + 1}`;
    const date = new Date(Date.parse(data.days.date) + day * DAY * 1000);
    return `${name} ${date.getUTCDate()} ${date.toLocaleString("en", { month: "short", timeZone: "UTC" })}`;
  }
  // A moment: "Mon 5 Jan 6:28:05", or only "6:28:05".
  function clock(seconds) {
    const digits = data.end < 600 ? 2 : 0;
    const scale = 10 ** digits;
    const all = Math.round(seconds * scale);
    const day = dayOf(all / scale);
    const whole = Math.floor(all / scale) % (day ? DAY : Infinity);
    const fraction = digits ? "." + String(all % scale).padStart(digits, "0") : "";
    return `${day ? `${day} ` : ""}${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}${fraction}`;
  }
  // A mark of an axis with marks this far apart: the day at midnight, and the time of the day between.
  function markText(seconds, step) {
    if (!data.days || step < 1) return clock(seconds);
    const ofDay = Math.round(seconds) % DAY;
    if (ofDay === 0) return dayOf(seconds);
    const text = `${Math.floor(ofDay / 3600)}:${two(Math.floor(ofDay / 60) % 60)}`;
    return step >= 60 ? text : `${text}:${two(ofDay % 60)}`;
  }
  // A duration with at most three units, such as "6 min 28 s".
  function span(seconds) {
    if (seconds < 59.95) {
      const [size, unit] = seconds > 0 && seconds < 0.0995 ? [0.001, "ms"] : [1, "s"];
      return `${Number((seconds / size).toPrecision(3)).toLocaleString("en")} ${unit}`;
    }
    const whole = seconds < DAY ? Math.round(seconds) : Math.round(seconds / 60) * 60;
    const units = [[Math.floor(whole / DAY), "d"], [Math.floor(whole / 3600) % 24, "h"], [Math.floor(whole / 60) % 60, "min"], [whole % 60, "s"]];
    return units.filter(([count]) => count > 0).map(([count, unit]) => `${count} ${unit}`).join(" ");
  }
  // The word for the state of a place.
  function word(node, name) {
    if (name === "idle") return data.nodes[node].isUnused ? "not used" : "off shift";
    return name === "setup" ? "being set up" : name;
  }

  // ---- The picture ---------------------------------------------------------------------------

  const ENDS = 3;
  const endNames = ["finished", "was rejected", "was joined to another part"];
  const picture = byId("line");
  const units = byId("units");
  const groups = [...picture.querySelectorAll(".node")];
  const boxes = groups.map((group) => {
    const [x, y] = group.getAttribute("transform").match(/-?[\d.]+/g).map(Number);
    const body = group.querySelector(".body");
    return { x, y, width: +body.getAttribute("width"), height: +body.getAttribute("height") };
  });
  const paths = new Map();
  for (const path of picture.querySelectorAll(".link")) {
    const [from, to] = data.links[+path.dataset.link];
    paths.set(from * data.nodes.length + to, path);
  }

  let moves, states, refusals, later = [];
  let time = 0;
  // Parts in the line: by number, where they are, since when, and from where they came.
  let there = new Map();
  // By place: number of parts that have left the line there, of those that have come from another
  // place, and of those that have gone on to one.
  let gone = [], taken = [], given = [];
  let applied = 0;
  const snapshots = [];
  const EVERY = 2000;

  function reset() {
    there = new Map();
    [gone, taken, given] = [0, 0, 0].map((none) => data.nodes.map(() => none));
    applied = 0;
  }

  function apply(index) {
    const target = moves.targets[index], part = moves.parts[index], now = moves.times[index];
    const known = there.get(part);
    if (target < ENDS) {
      if (known) gone[known.node] += target === 2 ? 0 : 1;
      there.delete(part);
    } else if (target < ENDS + data.nodes.length) {
      const node = target - ENDS;
      if (known) { given[known.node]++; taken[node]++; }
      const kind = moves.kinds[index] >= 0 ? moves.kinds[index] : known ? known.kind : 0;
      there.set(part, { node, kind, since: now, from: moves.kinds[index] >= 0 ? -1 : known ? known.node : -1, place: 0 });
    } else if (known) {
      there.set(part, { ...known, place: target - ENDS - data.nodes.length, from: -1 });
    }
  }

  // Brings the parts to where they are at this time.
  function seek(to) {
    const index = last(moves.times, to) + 1;
    if (index < applied) {
      const snapshot = snapshots[Math.min(Math.floor(index / EVERY), snapshots.length - 1)];
      there = new Map(snapshot.there);
      [gone, taken, given] = snapshot.numbers.map((numbers) => [...numbers]);
      applied = snapshot.applied;
    }
    while (applied < index) {
      if (applied % EVERY === 0 && applied / EVERY === snapshots.length) {
        snapshots.push({ there: new Map(there), numbers: [[...gone], [...taken], [...given]], applied });
      }
      apply(applied++);
    }
  }

  const pool = [];
  // Maximum number of parts that are drawn in a place that is no conveyor. The rest is a number.
  const MOST = 14;
  function draw() {
    seek(time);
    const here = data.nodes.map(() => []);
    for (const [number, part] of there) here[part.node].push({ number, ...part });
    // Parts move in no time: each is drawn where it is. A pale copy shows where it has come from.
    const slide = calm.matches || !playing ? 0 : 0.1 * rate();
    const shown = [];
    here.forEach((parts, node) => {
      const { kind, capacity, places, pitchSeconds, isStepped } = data.nodes[node];
      const box = boxes[node];
      const written = (number) => number.toLocaleString("en");
      const full = kind === "buffer" ? `${parts.length} of ${capacity}` : kind === "conveyor" ? `${parts.length} of ${places}`
        : kind.startsWith("sink") ? `${written(gone[node])} in` : kind === "source" ? `${written(given[node])} out`
        : kind === "store" ? `${written(taken[node])} in, ${written(given[node])} out` : parts.length > 1 ? `${parts.length} parts` : "";
      const text = groups[node].querySelector(".count");
      if (text.textContent !== full) text.textContent = full;
      const drawn = kind === "conveyor" || parts.length <= MOST ? parts.length : MOST - 4;
      const more = groups[node].querySelector(".more");
      const rest = drawn < parts.length ? `+${(parts.length - drawn).toLocaleString("en")}` : "";
      if (more.textContent !== rest) more.textContent = rest;
      // The oldest part is nearest to the end of its place.
      let ahead = Infinity;
      parts.forEach((part, index) => {
        if (index >= drawn) return;
        let x, y = box.y + box.height - 24;
        if (kind === "conveyor") {
          const steps = isStepped ? part.place : (time - part.since) / pitchSeconds;
          const position = Math.max(0, Math.min(steps, places - 1, ahead - 1));
          ahead = position;
          x = box.x + box.width * (position + 0.5) / places;
          y = box.y + box.height - 25;
        } else {
          const wide = box.width - 16 - 7 * rest.length;
          const room = Math.min(11, wide / Math.max(drawn, 1));
          x = box.x + 8 + wide / 2 + (drawn / 2 - index - 0.5) * room;
        }
        shown.push([part.kind, x, y, node]);
        const path = part.from >= 0 && time - part.since < slide && paths.get(part.from * data.nodes.length + node);
        if (path) {
          const at = path.getPointAtLength(path.getTotalLength() * (time - part.since) / slide);
          shown.push([part.kind, at.x, at.y, -1]);
        }
      });
    });
    while (pool.length < shown.length) {
      const use = document.createElementNS(SVG, "use");
      units.append(use);
      pool.push(use);
    }
    pool.forEach((use, index) => {
      const part = shown[index];
      use.setAttribute("display", part ? "inline" : "none");
      if (!part) return;
      use.setAttribute("class", part[3] < 0 ? "moving" : "");
      use.dataset.in = part[3];
      const href = `#part${part[0]}`;
      if (use.getAttribute("href") !== href) use.setAttribute("href", href);
      use.setAttribute("transform", `translate(${part[1].toFixed(1)} ${part[2].toFixed(1)})`);
    });
    states.forEach((column, node) => {
      if (!column) return;
      const index = last(column.times, time);
      const name = index < 0 ? "idle" : data.stateNames[column.states[index]];
      const wanted = `node station ${name}`;
      if (groups[node].getAttribute("class") !== wanted) groups[node].setAttribute("class", wanted);
    });
    byId("clock").textContent = clock(time);
    byId("time").value = 1000 * time / data.end;
    byId("time").setAttribute("aria-valuetext", clock(time));
    drawCursor();
  }

  // What a place does now, as a sentence.
  function describe(node) {
    const place = data.nodes[node];
    const parts = [...there].filter(([, part]) => part.node === node);
    const named = ([number, part]) => `${data.parts[part.kind]} ${number}`;
    const column = states[node];
    const refused = refusals[node] ? last(refusals[node], time) + 1 : 0;
    const refusedText = refused === 0 ? "" : ` It has refused ${refused === 1 ? "once" : `${refused.toLocaleString("en")} times`}, last at ${clock(refusals[node][refused - 1])}.`;
    if (column) {
      const index = last(column.times, time);
      const name = index < 0 ? "idle" : data.stateNames[column.states[index]];
      const since = index < 0 ? 0 : column.times[index];
      const with_ = parts.length ? `, with ${parts.slice(0, 3).map(named).join(", ")}` : "";
      return `${place.name} is ${word(node, name)} since ${clock(since)}${with_}.${refusedText}`;
    }
    const counted = (number) => `${number.toLocaleString("en")} ${number === 1 ? "part" : "parts"}`;
    if (place.kind.startsWith("sink")) return `${place.name} has taken ${counted(gone[node])} so far.`;
    if (place.kind === "source") return `${place.name} has delivered ${counted(given[node])} so far.`;
    if (place.kind === "store") return `${place.name} has delivered ${counted(given[node])} and taken ${counted(taken[node])} so far.`;
    const first = parts[0];
    const oldest = first ? `; ${named(first)} is there since ${clock(first[1].since)}` : "";
    return `${place.name} holds ${counted(parts.length)}${oldest}.${refusedText}`;
  }

  let pointed = -1;
  function point(node) {
    pointed = node;
    if (node >= 0) byId("status").textContent = describe(node);
  }
  groups.forEach((group, node) => {
    group.addEventListener("pointerenter", () => point(node));
    group.addEventListener("focus", () => point(node));
  });

  // ---- Playback ---------------------------------------------------------------------------------

  // Simulated seconds in a second.
  const rate = () => +byId("speed").value;
  const shownEnd = () => data.movesEnd ?? data.end;
  let playing = false, frame = 0;

  function setTime(to) {
    time = Math.max(0, Math.min(to, shownEnd()));
    draw();
    if (pointed >= 0 && !playing) point(pointed);
  }
  function play(on) {
    const was = playing;
    playing = on && (time < shownEnd() || (setTime(0), true));
    byId("play").textContent = playing ? "Pause" : "Play";
    byId("play").setAttribute("aria-pressed", String(playing));
    if (!playing) { if (was) draw(); if (pointed >= 0) point(pointed); return; }
    let before = performance.now();
    let stepped = before;
    const step = (now) => {
      if (!playing) return;
      const elapsed = Math.min(now - before, 200) / 1000;
      before = now;
      time = Math.min(time + elapsed * rate(), shownEnd());
      // With reduced motion, the picture changes once a second.
      if (!calm.matches || now - stepped > 1000 || time >= shownEnd()) { stepped = now; draw(); }
      if (time >= shownEnd()) { play(false); return; }
      frame = requestAnimationFrame(step);
    };
    cancelAnimationFrame(frame);
    frame = requestAnimationFrame(step);
  }
  function stepEvent(forward) {
    play(false);
    const index = last(moves.times, time);
    if (forward) { if (index + 1 < moves.times.length) setTime(moves.times[index + 1]); return; }
    let earlier = index;
    while (earlier >= 0 && moves.times[earlier] >= time) earlier--;
    setTime(earlier >= 0 ? moves.times[earlier] : 0);
  }
  function nextViolation() {
    play(false);
    const next = data.violations.find(([at]) => at > time) ?? data.violations[0];
    setTime(next[0]);
    point(next[1]);
  }

  function setUpControls() {
    const natural = data.end / 120;
    const speeds = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60, 120, 300, 600, 1800, 3600, 7200].filter((s) => s <= Math.max(natural * 20, 1));
    const best = speeds.reduce((a, b) => (Math.abs(Math.log(b / (natural / 4))) < Math.abs(Math.log(a / (natural / 4))) ? b : a));
    for (const speed of speeds) {
      const option = new Option(`${speed.toLocaleString("en")} × real time`, speed, false, speed === best);
      byId("speed").append(option);
    }
    byId("play").addEventListener("click", () => play(!playing));
    byId("back").addEventListener("click", () => stepEvent(false));
    byId("forward").addEventListener("click", () => stepEvent(true));
    byId("violation")?.addEventListener("click", nextViolation);
    byId("time").addEventListener("input", (event) => { const to = +event.target.value / 1000 * data.end; play(false); setTime(to); });
    for (const button of document.querySelectorAll(".jump")) {
      button.addEventListener("click", () => {
        play(false);
        setTime(+button.dataset.time);
        byId("line-section").scrollIntoView();
      });
    }
    if (data.violations.length) {
      const path = document.createElementNS(SVG, "path");
      const places = data.violations.map(([at]) => 1000 * at / data.end);
      path.setAttribute("d", merged(places, 6).map(([first, last]) => `M${(first - 1.5).toFixed(2)} 0H${(last + 1.5).toFixed(2)}V10H${(first - 1.5).toFixed(2)}Z`).join(""));
      byId("marks").append(path);
    }
    if (data.movesEnd !== null) {
      byId("cut").textContent = `The picture shows the first ${data.moves.count.toLocaleString("en")} movements, up to ${clock(data.movesEnd)}. All figures are of the whole run.`;
    }
  }

  // ---- The timeline -------------------------------------------------------------------------------

  const canvas = byId("gantt");
  const AXIS = 24;
  const FONT = "13px system-ui, sans-serif";
  // Height of a row: few rows are higher.
  let ROW = 26;
  let from = 0, to = 0, rows = [], left = 0, right = 0;
  let colours = {};

  function readColours() {
    const style = getComputedStyle(document.documentElement);
    const value = (name) => style.getPropertyValue(`--${name}`).trim();
    colours = { failed: value("failed"), ink: value("ink"), soft: value("soft"), rule: value("rule"), ground: value("ground"), accent: value("accent") };
    colours.states = data.stateNames.map(value);
    colours.hatches = data.stateNames.map((name) => hatch(name, value("hatch")));
  }
  // A pattern for wide pieces, by which states can be told apart without colours.
  function hatch(name, ink) {
    const lines = { blocked: [[0, 8, 8, 0]], failed: [[0, 0, 8, 8], [0, 8, 8, 0]], setup: [[2, 0, 2, 8], [6, 0, 6, 8]], starved: [[0, 4, 8, 4]] }[name];
    if (!lines) return null;
    const tile = document.createElement("canvas");
    tile.width = tile.height = 8;
    const pen = tile.getContext("2d");
    pen.strokeStyle = ink;
    pen.lineWidth = name === "starved" ? 0.7 : 1.2;
    for (const [a, b, c, d] of lines) { pen.beginPath(); pen.moveTo(a, b); pen.lineTo(c, d); pen.stroke(); }
    return pen.createPattern(tile, "repeat");
  }

  function marksOf(start, end, room) {
    const raw = (end - start) / Math.max(room / 110, 1);
    const steps = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 21600, 43200, 86400, 172800, 604800];
    let step = steps.find((s) => s >= raw);
    if (raw < 1) { const power = 10 ** Math.floor(Math.log10(raw)); step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= raw); }
    step ??= Math.ceil(raw / 604800) * 604800;
    const marks = [];
    for (let at = Math.ceil(start / step) * step; at <= end; at += step) marks.push(at);
    return { marks, step };
  }

  function drawTimeline() {
    if (!canvas) return;
    const width = canvas.clientWidth, height = rows.length * ROW + AXIS, ratio = devicePixelRatio || 1;
    canvas.style.height = `${height}px`;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.fillStyle = colours.ground;
    pen.fillRect(0, 0, width, height);
    pen.font = FONT;
    pen.textBaseline = "middle";
    [left, right] = data.margins.map((share) => share * width);
    const scale = (width - left - right) / (to - from);
    const x = (at) => left + (at - from) * scale;
    rows.forEach((node, row) => {
      const y = row * ROW + 2, tall = ROW - 4;
      pen.fillStyle = colours.ink;
      pen.textAlign = "right";
      pen.fillText(data.nodes[node].name, left - 8, y + tall / 2, left - 12);
      if (states[node]) drawRow(pen, states[node], x, y, tall);
      if (data.statesEnd !== null && data.statesEnd < to) drawLater(pen, later[node], Math.max(left, Math.round(x(data.statesEnd))), width - right, scale, y, tall);
      drawRefusals(pen, refusals[node], x, y);
    });
    pen.strokeStyle = colours.rule;
    pen.fillStyle = colours.soft;
    pen.textAlign = "center";
    const { marks, step } = marksOf(from, to, width - left - right);
    for (const at of marks) {
      pen.beginPath(); pen.moveTo(x(at), rows.length * ROW); pen.lineTo(x(at), rows.length * ROW + 5); pen.stroke();
      if (x(at) > left + 20 && x(at) < width - 30) pen.fillText(markText(at, step), x(at), rows.length * ROW + 15);
    }
    byId("window").textContent = `${clock(from)} to ${clock(to)}`;
    drawCursor();
  }

  // Draws the states of a station. Pieces narrower than a pixel are gathered: a column of pixels
  // shows the share of each state. Wide pieces begin and end at whole pixels, so that no ground is
  // seen between them.
  function drawRow(pen, column, x, y, tall) {
    const { times, states } = column;
    const end = Math.min(data.statesEnd ?? data.end, to);
    const shares = new Float64Array(8);
    let pixel = -1, used = 0;
    const flush = () => {
      let bottom = y + tall;
      for (let s = 0; used > 0 && s < colours.states.length; s++) {
        const part = tall * shares[s] / used;
        if (part === 0) continue;
        pen.fillStyle = colours.states[s];
        pen.fillRect(pixel, bottom - part, 1, part);
        bottom -= part;
      }
      shares.fill(0);
      used = 0;
    };
    for (let index = Math.max(0, last(times, from)); index < times.length && times[index] < end; index++) {
      const start = Math.max(times[index], from);
      const stop = Math.min(index + 1 < times.length ? times[index + 1] : end, end);
      if (stop <= start) continue;
      const a = x(start), b = x(stop), state = states[index];
      if (b - a >= 1.5) {
        flush();
        pixel = -1;
        const first = Math.round(a), wide = Math.round(b) - first;
        pen.fillStyle = colours.states[state];
        pen.fillRect(first, y, wide, tall);
        if (b - a >= 6 && colours.hatches[state]) { pen.fillStyle = colours.hatches[state]; pen.fillRect(first, y, wide, tall); }
        continue;
      }
      for (let at = Math.floor(a); at < b; at++) {
        if (at !== pixel) { flush(); pixel = at; }
        const share = Math.min(b, at + 1) - Math.max(a, at);
        shares[state] += share;
        used += share;
      }
    }
    flush();
  }

  // The shares of the states at a time after the last known change.
  function sharesAt(shares, at) {
    const count = data.stateNames.length, bins = shares.length / count;
    const bin = Math.max(0, Math.min(Math.floor(at / data.laterStates.width) - data.laterStates.first, bins - 1));
    return shares.subarray(bin * count, (bin + 1) * count);
  }
  // Draws them, for every pixel from a to b.
  function drawLater(pen, shares, a, b, scale, y, tall) {
    if (!shares) return;
    for (let pixel = a; pixel < b; pixel++) {
      const of = sharesAt(shares, from + (pixel + 0.5 - left) / scale);
      const all = of.reduce((sum, share) => sum + share, 0) || 1;
      let bottom = y + tall;
      of.forEach((share, state) => {
        if (share === 0) return;
        pen.fillStyle = colours.states[state];
        pen.fillRect(pixel, bottom - tall * share / all, 1, tall * share / all);
        bottom -= tall * share / all;
      });
    }
  }

  // A triangle at the top of the row for each refusal; a bar with their number for some that would
  // overlap.
  function drawRefusals(pen, times, x, y) {
    if (!times) return;
    const start = last(times, from) + (times[last(times, from)] === from ? 0 : 1);
    const seen = times.subarray(start, last(times, to) + 1);
    for (const [first, end, count] of merged([...seen].map(x), 11)) {
      pen.fillStyle = colours.failed;
      pen.strokeStyle = colours.ground;
      pen.beginPath();
      if (count === 1) {
        pen.moveTo(first - 4.5, y - 2);
        pen.lineTo(first + 4.5, y - 2);
        pen.lineTo(first, y + 7);
      } else {
        pen.rect(first - 4.5, y - 2, end - first + 9, 14);
      }
      pen.closePath();
      pen.fill();
      pen.stroke();
      const text = count.toLocaleString("en");
      pen.font = "bold 12px system-ui, sans-serif";
      if (count > 1 && pen.measureText(text).width < end - first + 3) {
        pen.fillStyle = colours.ground;
        pen.textAlign = "left";
        pen.fillText(text, first, y + 5.5);
      }
    }
    pen.font = FONT;
  }

  function drawCursor() {
    if (!canvas) return;
    const style = byId("cursor").style;
    const isSeen = rows.length > 0 && time >= from && time <= to;
    style.display = isSeen ? "block" : "none";
    if (!isSeen) return;
    style.left = `${left + (time - from) / (to - from) * (canvas.clientWidth - left - right)}px`;
    style.height = `${rows.length * ROW}px`;
  }

  function look(start, end) {
    const least = data.end * 1e-6, wide = Math.max(Math.min(end - start, data.end), least);
    from = Math.max(0, Math.min(start, data.end - wide));
    to = from + wide;
    drawTimeline();
  }
  function zoom(factor, around = (from + to) / 2) {
    look(around - (around - from) * factor, around + (to - around) * factor);
  }
  const timeAt = (event) => from + (event.offsetX - left) / (canvas.clientWidth - left - right) * (to - from);

  function setUpTimeline() {
    if (!canvas) return;
    rows = data.nodes.map((_, node) => node).filter((node) => states[node] || refusals[node]);
    ROW = Math.max(26, Math.min(44, Math.floor(240 / rows.length)));
    to = data.end;
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(event.deltaY > 0 ? 1.25 : 0.8, timeAt(event)); }, { passive: false });
    let drag = null;
    canvas.addEventListener("pointerdown", (event) => { drag = { x: event.offsetX, from, to, moved: false }; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointermove", (event) => {
      if (!drag) { canvas.title = hint(event); return; }
      const shift = (drag.x - event.offsetX) / (canvas.clientWidth - left - right) * (drag.to - drag.from);
      drag.moved ||= Math.abs(event.offsetX - drag.x) > 3;
      if (drag.moved) look(drag.from + shift, drag.to + shift);
    });
    canvas.addEventListener("pointerup", (event) => {
      if (drag && !drag.moved && event.offsetX > left && event.offsetX < canvas.clientWidth - right) { play(false); setTime(timeAt(event)); }
      drag = null;
    });
    canvas.addEventListener("keydown", (event) => {
      const width = to - from;
      const act = { "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => look(0, data.end),
        ArrowLeft: () => look(from - width / 5, to - width / 5), ArrowRight: () => look(from + width / 5, to + width / 5) }[event.key];
      if (act) { event.preventDefault(); act(); }
    });
    byId("zoom-in").addEventListener("click", () => zoom(0.5));
    byId("zoom-out").addEventListener("click", () => zoom(2));
    byId("zoom-all").addEventListener("click", () => look(0, data.end));
    addEventListener("resize", drawTimeline);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { readColours(); drawTimeline(); });
    drawTimeline();
  }
  function hint(event) {
    const node = rows[Math.floor(event.offsetY / ROW)];
    const at = timeAt(event);
    if (node === undefined || at < 0) return "";
    if (!states[node]) return `${data.nodes[node].name}: a mark is a refusal`;
    if (data.statesEnd !== null && at >= data.statesEnd) {
      const said = [...sharesAt(later[node], at)].map((share, state) => [share, word(node, data.stateNames[state])]).filter(([share]) => share > 0);
      return `${data.nodes[node].name}, in ${span(data.laterStates.width)}: ${said.map(([share, name]) => `${name} ${share} %`).join(", ")}`;
    }
    const { times, states: of } = states[node];
    const index = last(times, at);
    if (index < 0) return "";
    const end = index + 1 < times.length ? times[index + 1] : data.end;
    const name = data.stateNames[of[index]];
    return `${data.nodes[node].name}: ${word(node, name)} from ${clock(times[index])} for ${span(end - times[index])}`;
  }

  // ---- Start ------------------------------------------------------------------------------------

  async function begin() {
    [moves, states, refusals] = await Promise.all([readMoves(), Promise.all(data.states.map(readStates)), Promise.all(data.refusals.map(readTimes))]);
    if (data.laterStates) later = await Promise.all(data.laterStates.nodes.map(readShares));
    reset();
    snapshots.push({ there: new Map(), numbers: [[...gone], [...taken], [...given]], applied });
    readColours();
    setUpControls();
    setUpTimeline();
    setTime(0);
    document.documentElement.dataset.ready = "true";
  }
  begin().catch((error) => {
    byId("status").textContent = "This browser cannot play the run: it needs DecompressionStream, which all major browsers have since 2023. The tables and charts are complete.";
    console.error(error);
  });
})();
