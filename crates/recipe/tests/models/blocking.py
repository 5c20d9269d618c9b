"""Least makespan of a cell with one transport in which parts block, by CP-SAT (OR-Tools).

Written from the rules of timed execution, without the Rust code. Reads the number of stations, a
table of the times of ways, and a line for each job: stations and durations. Prints the makespan.

A part holds its station from the moment when it arrives until the transport fetches it. The transport
holds the part until it hands it over, at least for the time of the way. The last station gives the
part out when its work has ended. Two parts cannot change places in one moment: what comes first at a
station or on the transport comes first, even if it takes no time.
"""

import itertools
import sys

from ortools.sat.python import cp_model


def main():
    lines = sys.stdin.read().splitlines()
    stations = int(lines[0])
    ways = [[int(word) for word in line.split()] for line in lines[1 : 1 + stations]]
    jobs = []
    for line in lines[1 + stations :]:
        numbers = [int(word) for word in line.split()]
        jobs.append(list(zip(numbers[0::2], numbers[1::2])))
    horizon = sum(d + max(map(max, ways)) for job in jobs for _, d in job)
    model = cp_model.CpModel()
    # For each stay: when it begins and ends, the trip that ends there, and the trip that begins there.
    stays = [[] for _ in range(stations)]
    trips = []
    ends = []

    def moment():
        return model.new_int_var(0, horizon, "")

    for job in jobs:
        arrived, trip = moment(), None
        for place, (station, duration) in enumerate(job):
            begin, left = moment(), moment()
            model.add(begin >= arrived)
            model.add(left >= begin + duration)
            # Nothing occupies the first station before its work begins.
            held = begin if place == 0 else arrived
            last = place + 1 == len(job)
            following = None if last else len(trips)
            stays[station].append((held, left, trip, following))
            if last:
                model.add(left == begin + duration)
                ends.append(left)
                continue
            arrived, trip = moment(), following
            model.add(arrived >= left + ways[station][job[place + 1][0]])
            trips.append((left, arrived))

    def order(first, second):
        """Returns a literal: the first of two intervals comes first."""
        before = model.new_bool_var("")
        model.add(first[1] <= second[0]).only_enforce_if(before)
        model.add(second[1] <= first[0]).only_enforce_if(before.negated())
        return before

    trip_order = {}
    for a, b in itertools.combinations(range(len(trips)), 2):
        trip_order[a, b] = order(trips[a], trips[b])
        trip_order[b, a] = trip_order[a, b].negated()
    for here in stays:
        for a, b in itertools.combinations(here, 2):
            before = order(a, b)
            for literal, first, second in [(before, a, b), (before.negated(), b, a)]:
                # The trip that takes the first part away precedes the one that brings the second.
                if first[3] is not None and second[2] is not None:
                    model.add_implication(literal, trip_order[first[3], second[2]])
    makespan = moment()
    model.add_max_equality(makespan, ends)
    model.minimize(makespan)
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    status = solver.solve(model)
    if status != cp_model.OPTIMAL:
        sys.exit("not solved")
    print(int(solver.objective_value))


main()
