"""The places of a line: what each takes, keeps and hands on."""

from collections import deque

from streams import Durations, Stream


class Place:
    """A place with an outlet: the part that leaves next waits there, once its way is chosen."""

    def __init__(self, line, node):
        self.line, self.node, self.name = line, node, node["name"]
        self.part = None  # at the outlet
        self.way = None
        self.turn = None  # of a part that was overtaken
        self.requests = []  # of other places, oldest first: (number, place)
        self.listed = False

    def stream(self, purpose, suffix=""):
        return Stream(self.line.seed, purpose, self.name + suffix)

    def log(self, what, part=None):
        self.line.log(self, what, part)

    def load(self):
        return 0

    def next_part(self):
        """The part that comes to the empty outlet."""
        return None

    def begin_waiting(self):
        """Somebody waits for this place, or still does."""


class Sink(Place):
    def takes(self, part):
        return True

    def arrive(self, part):
        self.log("Arrived", part)
        self.line.leave(self, part, "Rejected" if self.node["rejects"] else "Finished")
        if self.node["reorder"]:
            self.line.places[self.node["reorder"]].order(part)


class Source(Place):
    """Makes a part when it is due, the one before has left, and the line has room."""

    def __init__(self, line, node):
        super().__init__(line, node)
        self.due, self.due_at, self.scheduled = True, 0.0, False
        self.left = node["limit"]
        self.instants, self.replacements = deque(node["at"] or []), 0
        if self.instants:
            self.left = len(self.instants)
            self.take_instant()
        if node["every"] is None and node["limit"] is None and line.target is not None:
            if node["on_order"]:
                self.left = line.target * max(1, line.content(line.product, node["type"]))
        if node["every"]:
            self.interval = Durations(node["every"], self.stream("arrivals"))

    def takes(self, part):
        return False

    def next_part(self):
        kind, most = self.node["type"], self.node["most"]
        full = most is not None and self.line.in_line[kind] >= most
        if not (self.due or self.replacements) or self.left == 0 or full:
            return None
        if self.left is not None:
            self.left -= 1
        if self.replacements:
            self.replacements -= 1
        elif self.node["at"]:
            if self.instants:
                self.take_instant()
                self.begin_run()
            else:
                self.due = False
        elif self.node["every"]:
            self.due = False
            self.due_at = self.line.now + self.interval.draw()
            self.plan()
        self.line.in_line[kind] += 1
        return self.line.make(kind, {})

    def take_instant(self):
        self.due_at = self.instants.popleft()
        self.due = self.due_at <= self.line.now

    def begin_run(self):
        if not self.due:
            self.line.at(self.due_at, self.fall_due)

    def plan(self):
        if self.left != 0:
            self.line.at(self.due_at, self.fall_due)

    def fall_due(self):
        self.due = True
        self.line.look(self)

    def order(self, rejected):
        """A rejected part is made again."""
        stopped = self.left == 0 and not self.due
        count = max(1, self.line.content(rejected.kind, self.node["type"]))
        if self.left is not None:
            self.left += count
        if self.node["at"]:
            self.replacements += count
        elif stopped:
            self.due_at = max(self.due_at, self.line.now)
            self.plan()
        self.line.look(self)

    def left_by(self, part):
        pass


class Buffer(Place):
    def __init__(self, line, node):
        super().__init__(line, node)
        self.parts, self.came = [], 0  # (rank, number, part), the next to leave first

    def load(self):
        return len(self.parts)

    def takes(self, part):
        return len(self.parts) < self.node["capacity"]

    def arrive(self, part):
        self.log("Arrived", part)
        self.came += 1
        order, of = self.node["order"]
        rank = {
            "fifo": lambda: (0, self.came),
            "lifo": lambda: (0, -self.came),
            "highest": lambda: (-part.values[of], self.came),
            "lowest": lambda: (part.values[of], self.came),
        }[order]()
        self.parts.append((*rank, part))
        self.parts.sort(key=lambda entry: entry[:2])
        if self.parts[0][2] is part:
            self.turn = self.line.withdraw(self) or self.turn
            self.part = None
            self.line.look(self)

    def next_part(self):
        return self.parts[0][2] if self.parts else None

    def left_by(self, part):
        self.parts.pop(0)


class Conveyor(Place):
    """Parts come on and off one period apart at least, and need one period for each place."""

    def __init__(self, line, node):
        super().__init__(line, node)
        self.parts = deque()  # (part, when it is at the end)
        self.opens = self.closes = 0.0
        self.coming = self.opening = False

    def load(self):
        return len(self.parts)

    def takes(self, part):
        return len(self.parts) < self.node["places"] and self.line.now >= self.opens

    def arrive(self, part):
        self.log("Arrived", part)
        period, now = self.node["period"], self.line.now
        self.opens = now + period
        self.parts.append((part, now + self.node["places"] * period))
        if len(self.parts) == 1:
            self.line.look(self)

    def next_part(self):
        if not self.parts:
            return None
        part, when = self.parts[0]
        when = max(when, self.closes)
        if when <= self.line.now:
            return part
        if not self.coming:
            self.coming = True
            self.line.at(when, self.come)
        return None

    def come(self):
        self.coming = False
        self.line.look(self)

    def left_by(self, part):
        self.parts.popleft()
        self.closes = self.line.now + self.node["period"]

    def begin_waiting(self):
        if len(self.parts) < self.node["places"] and self.line.now < self.opens:
            if not self.opening:
                self.opening = True
                self.line.at(self.opens, self.open)

    def open(self):
        self.opening = False
        self.line.look(self)
