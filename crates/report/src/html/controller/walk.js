// Walks through a controller: the reader's moves, its answers, and why a move is refused.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { own, others } = data;
  const byId = (id) => document.getElementById(id);
  const make = (tag, text, className) => {
    const element = document.createElement(tag);
    if (text !== undefined) element.textContent = text;
    if (className) element.className = className;
    return element;
  };
  // A formula as code, in which no line ends within a sign such as "->".
  const code = (text) => {
    const element = make("code");
    text.split(/(<->|->|<=|>=|!=)/).forEach((piece, index) => element.append(index % 2 ? make("span", piece, "sign") : piece));
    return element;
  };
  // All values are BigInt, because numbers are exact only up to 2^53. The data has larger ones as text.
  const exact = (expression) => {
    if (!Array.isArray(expression)) return BigInt(expression);
    const [operator, ...operands] = expression;
    return [operator, ...(["now", "next"].includes(operator) ? operands : operands.map(exact))];
  };
  const variables = data.variables.map((variable) => ({ ...variable, low: BigInt(variable.low), high: BigInt(variable.high) }));
  const rules = data.rules.map((rule) => ({ ...rule, holds: exact(rule.holds) }));
  const definitions = data.definitions.map((defined) => (defined.value === undefined ? defined : { ...defined, value: exact(defined.value) }));
  const worded = ({ labels, unit }, value) => {
    const text = labels && labels.length ? labels[Number(value)] : String(value);
    return unit ? `${text} ${unit}` : text;
  };
  const shown = (index, value) => worded(variables[index], value);
  const list = (indices, values) => indices.filter((index) => !variables[index].hidden)
    .map((index) => `${variables[index].name} = ${shown(index, values[index])}`).join(", ");

  // The value of an expression. A quotient is rounded down.
  const truth = (holds) => (holds ? 1n : 0n);
  const quotient = (a, b) => a / b - truth(a % b !== 0n && a < 0n !== b < 0n);
  const operators = {
    not: (a) => truth(!a), neg: (a) => -a, abs: (a) => (a < 0n ? -a : a),
    and: (a, b) => truth(a && b), or: (a, b) => truth(a || b), "->": (a, b) => truth(!a || b),
    "=": (a, b) => truth(a === b), "!=": (a, b) => truth(a !== b),
    "<": (a, b) => truth(a < b), "<=": (a, b) => truth(a <= b), ">": (a, b) => truth(a > b), ">=": (a, b) => truth(a >= b),
    "+": (a, b) => a + b, "-": (a, b) => a - b, "*": (a, b) => a * b,
    div: quotient, mod: (a, b) => a - b * quotient(a, b), min: (a, b) => (a < b ? a : b), max: (a, b) => (a > b ? a : b),
  };
  const value = (expression, now, next) => {
    if (typeof expression === "bigint") return expression;
    const [operator, ...operands] = expression;
    if (operator === "now") return now[operands[0]];
    if (operator === "next") return next[operands[0]];
    if (operator === "if") return value(value(operands[0], now, next) ? operands[1] : operands[2], now, next);
    return operators[operator](...operands.map((operand) => value(operand, now, next)));
  };
  // The rules of one side that a step breaks, after the step before it if there is one.
  const broken = (isOwn, before, step) => rules.filter((rule) => {
    if (rule.own !== isOwn) return false;
    if (rule.when === "first") return !before && !value(rule.holds, step);
    if (rule.when === "later") return before && !value(rule.holds, before, step);
    return !value(rule.holds, step);
  });

  // A controller with listed states: its position is a state, or null before step 0.
  const ofMachine = (machine) => {
    const read = (list) => list.map(([cubes, values, to, condition]) => [
      cubes.map((cube) => cube.map(([input, low, high]) => [input, BigInt(low), BigInt(high)])), values.map(BigInt), to, condition]);
    const [initial, states] = [read(machine.initial), machine.states.map(read)];
    return {
      start: null,
      transitions: (position) => (position === null ? initial : states[position]),
      first(position) {
        const [first] = this.transitions(position);
        return first && first[1];
      },
      answer(position, moved) {
        const holds = ([cubes]) => cubes.some((cube) => cube.every(([input, low, high]) => low <= moved[input] && moved[input] <= high));
        const taken = this.transitions(position).find(holds);
        return taken && { values: taken[1], position: taken[2] };
      },
      name: (position) => (position === null ? "start" : `S${position}`),
    };
  };

  // A controller as functions of bits: its position is the signals and the goal. Signal 2k is a bit now, and 2k + 1 the same bit next.
  const ofFunctions = (functions) => {
    const { inputs, outputs, goals, nodes } = functions;
    const holds = (edge, signals) => {
      let negated = edge & 1;
      while (edge > 1) {
        const [signal, high, low] = nodes[(edge >> 1) - 1];
        edge = signals[signal] ? high : low;
        negated ^= edge & 1;
      }
      return negated === 1;
    };
    const low = (port) => BigInt(port.domain.type === "range" ? port.domain.low : 0);
    const write = (signals, ports, values) => ports.forEach((port, index) => {
      let code = values[index] - low(port);
      for (const signal of [...port.signals].reverse()) {
        signals[signal + 1] = code % 2n === 1n;
        code /= 2n;
      }
    });
    const compute = (goal, signals) => {
      let roots = functions.first_outputs;
      if (goal !== null) {
        const { modes } = goals[goal];
        roots = (modes.find((mode) => holds(mode.when, signals)) || modes[modes.length - 1]).outputs;
      }
      for (const [signal, edge] of roots) signals[signal] = holds(edge, signals);
      return outputs.map((port) => low(port) + port.signals.reduce((code, signal) => 2n * code + truth(signals[signal + 1]), 0n));
    };
    const pairs = [...inputs, ...outputs].reduce((sum, port) => sum + port.signals.length, 0);
    return {
      start: { signals: Array(2 * pairs).fill(false), goal: null },
      first: ({ signals, goal }) => compute(goal, [...signals]),
      answer({ signals, goal }, moved) {
        const next = [...signals];
        write(next, inputs, moved);
        const assumed = goal === null ? functions.first_assumed : functions.assumed;
        if (assumed.some((rule) => !holds(rule.holds, next))) return undefined;
        const values = compute(goal, next);
        let pursued = goal === null ? 0 : goal;
        if (goal !== null && holds(goals[goal].reached, next)) pursued = (goal + 1) % goals.length;
        for (let bit = 0; bit < next.length; bit += 2) next[bit] = next[bit + 1];
        return { values, position: { signals: next, goal: pursued } };
      },
      name: ({ goal }) => (goal === null ? "start" : `goal ${goal + 1} of ${goals.length}`),
    };
  };
  const opponent = data.machine ? ofMachine(data.machine) : ofFunctions(data.functions);

  const positions = [opponent.start];
  const steps = [];
  const last = (array) => array[array.length - 1];

  // A field for each variable of a side, with its value.
  const fields = (parent, indices, prefix, changed) => {
    const read = {};
    for (const index of indices.filter((index) => !variables[index].hidden)) {
      const { name, low, high, labels } = variables[index];
      const field = make("div", undefined, "field");
      const label = make("label", name);
      label.htmlFor = `${prefix}${index}`;
      let input;
      const isBool = labels && labels[0] === "false" && labels[1] === "true" && labels.length === 2;
      if (isBool) {
        input = make("input");
        input.type = "checkbox";
        read[index] = { get: () => truth(input.checked), set: (value) => (input.checked = value !== 0n) };
      } else if (labels || high - low < 60n) {
        input = make("select");
        for (let option = low; option <= high; option++) input.append(new Option(shown(index, option), option));
        read[index] = { get: () => BigInt(input.value), set: (value) => (input.value = value) };
      } else {
        input = make("input");
        // A field for numbers compares its value with the limits as a rounded number.
        const isRounded = [low, high].some((limit) => !Number.isSafeInteger(Number(limit)));
        Object.assign(input, isRounded ? { type: "text", inputMode: "numeric" } : { type: "number", min: low, max: high, step: 1 });
        Object.assign(input, { value: low, required: true });
        const written = () => input.value.trim();
        read[index] = { get: () => (/^-?[0-9]+$/.test(written()) ? BigInt(written()) : null), set: (value) => (input.value = value) };
      }
      input.id = `${prefix}${index}`;
      input.addEventListener("input", changed);
      field.append(label, input);
      parent.append(field);
    }
    return read;
  };

  // All values of a step: the reader's, and the opponent's.
  const whole = (moved, values) => {
    const step = Array(variables.length).fill(0n);
    own.forEach((index, place) => (step[index] = moved[place]));
    others.forEach((index, place) => (step[index] = values[place]));
    return step;
  };
  // The definitions that a text mentions, also within others.
  const mentioned = (text) => {
    const used = new Set();
    const add = (text) => {
      const words = new Set(text.match(/[\p{L}_][\p{L}\p{N}_]*/gu));
      for (const defined of definitions.filter((defined) => !used.has(defined) && words.has(defined.name.split("(")[0]))) {
        used.add(defined);
        add(defined.text);
      }
    };
    add(text);
    return [...used];
  };
  const mentionsNext = (expression) => Array.isArray(expression) && (expression[0] === "next" || expression.some(mentionsNext));
  // The value of a definition: before the step and with it, if the rule is about both.
  const valueOf = ({ value: expression, ...defined }, rule, before, step) => {
    if (expression === undefined) return "";
    const at = (now, next) => worded(defined, value(expression, now, next));
    if (mentionsNext(expression)) return before ? `was ${at(before, step)} from the step before to this one` : "";
    return rule.when === "later" && before ? `was ${at(before)} in the step before, would be ${at(step)} now` : `would be ${at(step)} now`;
  };
  const ruleList = (found, before, step) => {
    const items = make("ul");
    for (const rule of found) {
      const item = make("li");
      item.append(make("strong", `${rule.kind} ${rule.name}`), ": ", code(rule.text), ` (${rule.place})`);
      const used = mentioned(rule.text);
      if (used.length) {
        const list = make("ul", undefined, "definitions");
        for (const defined of used) {
          const entry = make("li");
          entry.append(make("code", defined.name), ", defined as ", code(defined.text), ` (${defined.place}) `, valueOf(defined, rule, before, step));
          list.append(entry);
        }
        item.append(list);
      }
      items.append(item);
    }
    return items;
  };

  const moveFields = fields(byId("own"), own, "own", () => preview());
  const otherFields = fields(byId("others"), others, "other", () => why());
  const chosen = () => own.map((index) => (moveFields[index] ? moveFields[index].get() : 0n));
  const choose = (moved) => own.forEach((index, place) => moveFields[index] && moveFields[index].set(moved[place]));

  // What comes of a move: the opponent's answer, or the rules that the move breaks.
  const consider = (moved) => {
    const outside = own.find((index, place) => !(moved[place] !== null && variables[index].low <= moved[place] && moved[place] <= variables[index].high));
    if (outside !== undefined) return { text: `${variables[outside].name} has no such value.` };
    const before = last(steps);
    const answer = opponent.answer(last(positions), moved);
    if (answer) {
      const step = whole(moved, answer.values);
      const found = broken(true, before, step);
      return found.length ? { found, step } : { answer, step };
    }
    const first = data.movesFirst ? opponent.first(last(positions)) : undefined;
    const step = whole(moved, first || others.map((index) => variables[index].low));
    const found = broken(true, before, step);
    return found.length ? { found, step } : { text: `The ${data.opponent} has no answer: the ${data.reader} cannot go on from here.` };
  };

  // Shows what the move that is chosen would lead to.
  function preview() {
    const { found, text, answer, step } = consider(chosen());
    const status = byId("status");
    status.replaceChildren();
    if (answer) {
      status.append(make("p", `This move is legal. Answer: ${list(others, step) || "nothing"}; then ${opponent.name(answer.position)}.`));
      return;
    }
    const box = make("div", undefined, "refused");
    box.append(make("p", text || (found.length === 1 ? "This move is refused: it breaks this rule." : "This move is refused: it breaks these rules.")));
    if (found) box.append(ruleList(found, last(steps), step));
    status.append(box);
  }

  // Shows the rules that another answer to the last move would break.
  function why() {
    const target = byId("why");
    target.replaceChildren();
    if (steps.length === 0) {
      target.append(make("p", "Make a step first."));
      return;
    }
    const step = [...last(steps)];
    others.forEach((index) => { if (otherFields[index]) step[index] = otherFields[index].get() ?? step[index]; });
    if (step.every((value, index) => value === last(steps)[index])) {
      target.append(make("p", "This is what it did."));
      return;
    }
    const found = broken(false, steps[steps.length - 2], step);
    if (found.length) target.append(make("p", "This answer would break:"), ruleList(found, steps[steps.length - 2], step));
    else target.append(make("p", `No rule for this step forbids it. The ${data.opponent} has chosen another answer, to reach its goals and to keep the rules in later steps.`));
  }

  function update() {
    const position = last(positions);
    byId("now").textContent = steps.length ? `After step ${steps.length - 1}: ${opponent.name(position)}` : "Before step 0";
    byId("undo").disabled = byId("reset").disabled = steps.length === 0;
    const answer = byId("answer");
    answer.replaceChildren();
    const entry = (name, text, isChanged) => answer.append(make("dt", name), make("dd", text, isChanged ? "changed" : ""));
    if (steps.length) {
      const [step, before] = [last(steps), steps[steps.length - 2]];
      for (const index of others.filter((index) => !variables[index].hidden)) {
        entry(variables[index].name, shown(index, step[index]), before && before[index] !== step[index]);
        otherFields[index].set(step[index]);
      }
    }
    const first = data.movesFirst ? opponent.first(position) : undefined;
    if (first) entry("next", list(others, whole(own.map(() => 0n), first)), false);

    const history = make("table");
    const head = make("tr");
    for (const name of ["Step", `Your move (${data.reader})`, `Answer (${data.opponent})`, "Then"]) {
      const cell = make("th", name);
      cell.scope = "col";
      head.append(cell);
    }
    history.append(head);
    steps.forEach((step, number) => {
      const row = make("tr");
      const name = make("th", String(number));
      name.scope = "row";
      row.append(name, make("td", list(own, step)), make("td", list(others, step)), make("td", opponent.name(positions[number + 1])));
      history.append(row);
    });
    byId("history").replaceChildren(history);
    byId("history").scrollTop = byId("history").scrollHeight;
    choices(position);
    mark(position);
    preview();
    why();
  }

  // A legal move within one of the cubes: the chosen values, changed as little as necessary, or else others, found by trying. If none is found,
  // the first, which is then refused with its reason.
  function within(cubes) {
    const clamped = (cube, moved) => {
      for (const [input, low, high] of cube) moved[input] = operators.min(operators.max(moved[input] ?? low, low), high);
      return moved;
    };
    for (const cube of cubes) {
      const moved = clamped(cube, chosen());
      if (consider(moved).answer) return moved;
    }
    for (let attempt = 0; attempt < 500; attempt++) {
      const moved = clamped(cubes[attempt % cubes.length], anything());
      if (consider(moved).answer) return moved;
    }
    return clamped(cubes[0], chosen());
  }

  // Random values of the reader's variables.
  const anything = () => own.map((index) => {
    const { low, high } = variables[index];
    let offset = 0n;
    for (let bits = high - low; bits > 0n; bits >>= 32n) offset = (offset << 32n) + BigInt(Math.floor(Math.random() * 2 ** 32));
    return low + (offset % (high - low + 1n));
  });

  // The transitions from here; one can be taken with the chosen values, changed as little as necessary.
  function choices(position) {
    const target = byId("choices");
    if (!target) return;
    const rows = make("table");
    const head = make("tr");
    for (const name of ["Condition", "Answer", "Then", "Move"]) {
      const cell = make("th", name);
      cell.scope = "col";
      head.append(cell);
    }
    rows.append(head);
    opponent.transitions(position).slice(0, 200).forEach(([cubes, values, to, condition], number) => {
      const row = make("tr");
      const name = make("th");
      name.scope = "row";
      name.append(code(condition));
      const cell = make("td");
      const moved = within(cubes);
      const { answer, found } = consider(moved);
      if (answer) {
        const button = make("button", "Take");
        button.type = "button";
        button.setAttribute("aria-label", `Take move ${number + 1}`);
        button.addEventListener("click", () => {
          choose(moved);
          go();
        });
        cell.append(button);
      } else {
        cell.textContent = found ? `not now: ${found.map((rule) => rule.name).join(", ")}` : "not now";
      }
      row.append(name, make("td", list(others, whole(own.map(() => 0n), values))), make("td", opponent.name(to)), cell);
      rows.append(row);
    });
    target.replaceChildren(rows);
  }

  // Marks the state in the drawing, if it shows each state.
  const boxes = document.querySelectorAll("#diagram .state");
  function mark(position) {
    if (!data.machine || boxes.length !== data.machine.states.length) return;
    boxes.forEach((box, state) => box.classList.toggle("current", state === position));
    follow();
  }

  // The size of the state diagram, in proportion to the one in which it was drawn.
  const diagram = byId("diagram");
  const drawing = diagram && diagram.querySelector("svg");
  const drawn = drawing && Number(drawing.getAttribute("width"));
  let scale = 1;
  const high = drawing && Number(drawing.getAttribute("height"));
  const wide = () => Math.min(1, (diagram.clientWidth - 4) / drawn);
  const entire = () => Math.min(wide(), (0.8 * globalThis.innerHeight - 24) / high);
  function resize(wanted) {
    scale = Math.min(4, Math.max(0.1, wanted));
    drawing.style.width = `${drawn * scale}px`;
    drawing.style.height = "auto";
    byId("scale").textContent = `${Math.round(100 * scale)} %`;
    follow();
  }
  // Moves the diagram, and not the page, so that the current state is in its middle.
  function follow() {
    const box = diagram.querySelector(".state.current");
    if (!box) return;
    const [inside, outside] = [box.getBoundingClientRect(), diagram.getBoundingClientRect()];
    diagram.scrollLeft += inside.left + inside.width / 2 - (outside.left + outside.width / 2);
    diagram.scrollTop += inside.top + inside.height / 2 - (outside.top + outside.height / 2);
  }
  if (drawing) {
    const sizes = { "+": () => scale * 1.25, "=": () => scale * 1.25, "-": () => scale / 1.25, 0: entire, w: wide, 1: () => 1 };
    for (const [id, key] of [["larger", "+"], ["smaller", "-"], ["whole", "0"], ["wide", "w"], ["natural", "1"]]) {
      byId(id).addEventListener("click", () => resize(sizes[key]()));
    }
    diagram.addEventListener("keydown", (event) => {
      if (!sizes[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      resize(sizes[event.key]());
    });
    resize(1);
  }

  function go() {
    const { answer, step } = consider(chosen());
    if (!answer) return preview();
    steps.push(step);
    positions.push(answer.position);
    update();
  }

  byId("moves").addEventListener("submit", (event) => {
    event.preventDefault();
    go();
  });
  byId("undo").addEventListener("click", () => {
    choose(own.map((index) => last(steps)[index]));
    steps.pop();
    positions.pop();
    update();
  });
  byId("reset").addEventListener("click", () => {
    steps.length = 0;
    positions.length = 1;
    update();
  });
  byId("random").addEventListener("click", () => {
    // A move that the rules allow is found by trying.
    for (let attempt = 0; attempt < 2000; attempt++) {
      const moved = anything();
      if (consider(moved).answer) {
        choose(moved);
        return go();
      }
    }
    byId("status").replaceChildren(make("p", "No legal move was found by chance: choose one."));
  });
  choose(own.map((index) => variables[index].low));
  update();
  document.documentElement.dataset.ready = "";
})();
