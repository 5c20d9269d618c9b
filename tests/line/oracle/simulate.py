"""Simulates lines with SimPy: one line as JSON per line of the file, logs to standard output.

    simulate.py LINES

SimPy's calendar decides what happens next. At one instant, the consequences of an event come
before other events, stations, sources and conveyors come before shifts, and what was planned first
comes first. A place gives its room to the one that has waited longest.
"""

import json
import sys
from heapq import heappush

import simpy

from places import Buffer, Conveyor, Sink, Source
from station import Station
from streams import Stream

CONSEQUENCE, WORK, SHIFT = 0, 1, 2
KINDS = {"sink": Sink, "source": Source, "buffer": Buffer, "conveyor": Conveyor, "station": Station}


class Part:
    def __init__(self, number, kind, values):
        self.number, self.kind, self.values, self.entered = number, kind, values, False


class Way:
    """A route of a part type, to one place or to several with a choice."""

    def __init__(self, line, route, place, number):
        self.to = [line.places[name] for name in route["to"]]
        self.when, self.choice, self.shares = route["when"], route["choice"], route["shares"]
        self.next, self.drawn = 0, None
        if self.choice == "probability":
            suffix = f".{route['type']}" + (f".{number + 1}" if number else "")
            self.stream = Stream(line.seed, "routes", place + suffix)

    def holds(self, part):
        return self.when is None or eval(self.when, {}, part.values)

    def open_to(self):
        """The places to which the next part can go."""
        if self.choice == "robin":
            return [self.to[self.next]]
        if self.choice == "probability":
            if self.drawn is None:
                unit, self.drawn = self.stream.unit(), len(self.to) - 1
                for index, share in enumerate(self.shares[:-1]):
                    unit -= share
                    if unit < 0.0:
                        self.drawn = index
                        break
            return [self.to[self.drawn]]
        return self.to

    def chosen(self):
        self.next, self.drawn = (self.next + 1) % len(self.to), None


class Line(simpy.Environment):
    def __init__(self, text):
        super().__init__()
        self.seed, self.target, self.product = text["seed"], text["parts"], text["product"]
        self.kinds = {kind["name"]: kind for kind in text["types"]}
        self.bills = {name: kind["bill"] for name, kind in self.kinds.items()}
        self.in_line = dict.fromkeys(self.kinds, 0)
        self.made = self.products = self.numbers = 0
        self.ended, self.entries = False, []
        self.places, self.shifts = {}, {}
        for node in text["nodes"]:
            self.places[node["name"]] = KINDS[node["kind"]](self, node)
        self.ways, chosen = {}, {}
        for route in text["routes"]:
            for start in route["from"]:
                key = start, route["type"]
                way = Way(self, route, start, chosen.get(key, 0))
                chosen[key] = chosen.get(key, 0) + (way.choice == "probability")
                self.ways.setdefault(key, []).append(way)

    def simulate(self, until):
        for place in self.places.values():
            if isinstance(place, (Source, Station)):
                place.begin_run()
            self.look(place)
        while not self.ended and self.peek() <= until:
            self.step()

    def at(self, time, function, *arguments, priority=WORK):
        """Plans a call. SimPy takes delays, and a sum would be rounded."""
        event = simpy.Event(self)
        event._ok, event._value = True, None
        event.callbacks.append(lambda _: function(*arguments))
        heappush(self._queue, (time, priority, next(self._eid), event))

    def at_shift(self, time, change):
        """Plans a change of a shift. All changes at an instant are one event."""
        if time not in self.shifts:
            self.shifts[time] = []
            self.at(time, self.change_shifts, time, priority=SHIFT)
        self.shifts[time].append(change)

    def change_shifts(self, time):
        for change in self.shifts[time]:
            change()

    def log(self, place, what, part):
        if not self.ended:
            of = f"{part.kind} {part.number}" if part else "- 0"
            self.entries.append(f"{self.now!r} {place.name} {what} {of}")

    def content(self, whole, kind):
        """Number of parts of a type in one part."""
        if whole == kind:
            return 1
        return sum(count * self.content(of, kind) for count, of in self.bills[whole])

    def make(self, kind, components):
        self.made += 1
        values = {}
        for name, initial in self.kinds[kind]["properties"].items():
            of = isinstance(initial, list)
            values[name] = components[initial[0]].values[initial[1]] if of else initial
        return Part(self.made, kind, values)

    def leave(self, place, part, what):
        """A part leaves the line."""
        self.log(place, what, part)
        for kind in self.kinds:
            self.in_line[kind] -= self.content(part.kind, kind)
        for source in self.places.values():
            if isinstance(source, Source) and source.node["most"] is not None:
                self.look(source)
        if what == "Finished" and part.kind == self.product:
            self.products += 1
            self.ended = self.products == self.target

    def look(self, place):
        """Looks at a place again before anything else happens."""
        if not place.listed:
            place.listed = True
            self.at(self.now, self.examine, place, priority=CONSEQUENCE)

    def examine(self, place):
        place.listed = False
        while place.part is None and (part := place.next_part()) and not self.ended:
            self.offer(place, part)
        if isinstance(place, Station):
            place.join()
        while request := self.oldest(place):
            self.move(request[1], place)
        if place.requests:
            place.begin_waiting()

    def oldest(self, place):
        """The oldest request that a place can grant."""
        able = (request for request in place.requests if place.takes(request[1].part))
        return next(able, None) if not self.ended else None

    def offer(self, place, part):
        """A part is ready to leave: it moves, or waits."""
        way = next(way for way in self.ways[place.name, part.kind] if way.holds(part))
        turn, place.turn = place.turn, None
        place.part, place.way = part, way
        able = [to for to in way.open_to() if to.takes(part)]
        free = [to for to in able if not self.oldest(to)]
        if free:
            self.move(place, self.chosen(way, free))
            return
        for to in way.open_to():
            if turn is None:
                self.numbers += 1
            to.requests.append((turn or self.numbers, place))
            to.requests.sort(key=lambda request: request[0])
            to.begin_waiting()
            if to in able:
                self.look(to)

    def chosen(self, way, free):
        return min(free, key=lambda to: to.load()) if way.choice == "shortest" else free[0]

    def withdraw(self, place):
        """Takes back the requests of a place; returns the number of the last one."""
        number = None
        for to in place.way.to if place.part else []:
            for request in [request for request in to.requests if request[1] is place]:
                to.requests.remove(request)
                number = request[0]
        return number

    def move(self, place, to):
        part = place.part
        self.withdraw(place)
        place.way.chosen()
        place.part = place.way = None
        if not part.entered:
            part.entered = True
            self.log(place, "Entered", part)
        self.log(place, "Left", part)
        place.left_by(part)
        self.look(place)
        to.arrive(part)


def main():
    with open(sys.argv[1]) as file:
        for text in map(json.loads, file):
            line = Line(text)
            line.simulate(text["until"])
            print(f"line {text['seed']} {line.now!r} {len(line.entries)}")
            for entry in line.entries:
                print(entry)


main()
