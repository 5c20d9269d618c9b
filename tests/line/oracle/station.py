"""Stations: joining, setup, service, failures and shifts."""

from functools import partial

from places import Place
from streams import Durations


class Mode:
    """A failure mode, by seconds of work, by the calendar, or by the number of parts."""

    def __init__(self, station, node):
        self.by, self.restarts = node["by"], node["restarts"]
        suffix = "." + node["name"] if node["name"] else ""
        self.repair = Durations(node["repair"], station.stream("repairs", suffix))
        if self.by == "parts":
            self.every = self.left = node["between"]
        else:
            self.between = Durations(node["between"], station.stream("failures", suffix))
            self.left = self.between.draw() if self.by == "work" else None


class Station(Place):
    def __init__(self, line, node):
        super().__init__(line, node)
        self.times = {
            kind: Durations(time, self.stream("service", "." + kind))
            for kind, time in node["times"].items()
        }
        self.setup = node["setup"] and Durations(node["setup"], self.stream("setup"))
        self.defects = self.stream("defects")
        self.modes = [Mode(self, mode) for mode in node["failures"]]
        self.bill = line.bills.get(node["joins"], [])
        self.joined = {kind: [] for _, kind in self.bill}
        self.state = "free"  # then "setup", "service" and "done"
        self.work = None  # the part in work
        self.last = None  # the type of the part before
        self.left = self.whole = 0.0  # seconds of the setup or service
        self.timer = 0  # only the last timer counts
        self.runs_since = None
        self.begun_at = 0.0
        self.down, self.down_next = None, []
        self.overtime = False
        self.calendar = node["shifts"]
        self.on_shift = not self.calendar or self.calendar[0][0] <= 0.0 and self.calendar[0][1]
        for when, works, finishes in self.calendar:
            if when > 0.0:
                line.at_shift(when, partial(self.change_shift, works, finishes))

    def begin_run(self):
        for mode in self.modes:
            self.plan_failure(mode)

    def load(self):
        return sum(map(len, self.joined.values())) + (self.work is not None)

    def is_free(self):
        return self.state == "free" and self.on_shift and not self.down

    def lacks(self, kind):
        return any(of == kind and len(self.joined[of]) < count for count, of in self.bill)

    def takes(self, part):
        if self.bill:
            return self.lacks(part.kind)
        return self.is_free() and part.kind in self.times

    def arrive(self, part):
        self.log("Arrived", part)
        if self.bill:
            self.joined[part.kind].append(part)
            self.line.look(self)
        else:
            self.begin(part)

    def join(self):
        """Joins, if all components are there."""
        if not self.bill or not self.is_free() or any(map(self.lacks, self.joined)):
            return
        gone = [part for _, kind in self.bill for part in self.joined[kind]]
        first = {kind: self.joined[kind][0] for kind in self.joined}
        self.joined = {kind: [] for kind in self.joined}
        part = self.line.make(self.node["joins"], first)
        part.entered = True
        for component in gone:
            self.log("Consumed", component)
        # The content of the components stays counted.
        self.line.in_line[part.kind] += 1
        self.log("Entered", part)
        self.begin(part)
        self.line.look(self)

    def begin(self, part):
        changed = self.last is not None and self.last != part.kind
        self.last, self.work, self.begun_at = part.kind, part, self.line.now
        seconds = self.setup.draw() if changed and self.setup else 0.0
        if seconds > 0.0:
            self.log("SetupStarted", part)
            self.start("setup", seconds)
        else:
            self.serve()

    def serve(self):
        self.log("Started", self.work)
        self.start("service", self.times[self.work.kind].draw())

    def start(self, state, seconds):
        self.state, self.left, self.whole = state, seconds, seconds
        self.resume()

    def until_failure(self):
        if self.state != "service":
            return float("inf")
        return min((mode.left for mode in self.modes if mode.by == "work"), default=float("inf"))

    def resume(self):
        if self.down or not (self.on_shift or self.overtime) or self.runs_since is not None:
            return
        self.runs_since = self.line.now
        self.timer += 1
        seconds = min(self.left, self.until_failure())
        self.line.at(self.line.now + seconds, self.elapse, self.timer, seconds)

    def pause(self):
        if self.runs_since is not None:
            self.spend(min(self.line.now - self.runs_since, self.left))

    def spend(self, seconds):
        self.runs_since = None
        self.left -= seconds
        for mode in self.modes:
            if mode.by == "work" and self.state == "service":
                mode.left = max(0.0, mode.left - seconds)

    def elapse(self, timer, seconds):
        if self.runs_since is None or timer != self.timer:
            return
        fails = self.until_failure() < self.left
        self.spend(seconds)
        if fails:
            mode = next(m for m in self.modes if m.by == "work" and m.left <= self.until_failure())
            mode.left = mode.between.draw()
            self.fail(mode)
        elif self.state == "setup":
            self.serve()
        else:
            self.finish()

    def finish(self):
        part, self.state, self.overtime = self.work, "done", False
        before = dict(part.values)
        for kind, name, value in self.node["sets"]:
            if name in before and kind in (None, part.kind):
                part.values[name] = eval(value, {"min": min, "max": max}, before)
        for kind, probability, name, value in self.node["defects"]:
            if kind == part.kind and self.defects.chance(probability):
                self.defects.below(1)
                part.values[name] = eval(value, {"min": min, "max": max}, part.values)
        self.log("Ended", part)
        for mode in self.modes:
            if mode.by == "parts":
                mode.left -= 1
                if mode.left == 0:
                    mode.left = mode.every
                    self.fail(mode)
        self.line.offer(self, part)

    def left_by(self, part):
        self.state, self.work, self.overtime = "free", None, False

    def plan_failure(self, mode):
        if mode.by == "calendar":
            self.line.at(self.line.now + mode.between.draw(), self.fail, mode)

    def fail(self, mode):
        if self.down:
            self.down_next.append(mode)
            return
        self.pause()
        self.down = mode
        seconds = mode.repair.draw()
        if mode.restarts and self.state in ("setup", "service"):
            self.left = self.whole
        self.log("Failed")
        self.line.at(self.line.now + seconds, self.repair)

    def repair(self):
        mode, self.down = self.down, None
        self.log("Repaired")
        self.plan_failure(mode)
        if self.down_next:
            self.fail(self.down_next.pop(0))
        else:
            self.go_on()

    def go_on(self):
        if self.state in ("setup", "service"):
            self.resume()
        else:
            self.line.look(self)

    def change_shift(self, works, finishes):
        self.on_shift = works
        has_begun = self.state in ("setup", "service") and self.begun_at < self.line.now
        self.overtime = not works and finishes and has_begun
        if not works and not self.overtime:
            self.pause()
        self.go_on()
        self.line.look(self)
