"""Five stations in a row for SimPy: exponential services of mean 1, buffers of three, blocking after
service, a source that is never empty. The argument is the number of parts.

A process for each station takes a part out of the buffer in front, works, and puts the part into
the buffer behind. A put that finds no room waits, and the station with it.
"""

import random
import sys

import simpy


def station(env, before, behind, draw):
    while True:
        if before is not None:
            yield before.get()
        yield env.timeout(draw(1.0))
        yield behind.put(None)


def last(env, before, draw, parts):
    for _ in range(parts):
        yield before.get()
        yield env.timeout(draw(1.0))


env = simpy.Environment()
draw = random.Random(1).expovariate
buffers = [simpy.Store(env, capacity=3) for _ in range(4)]
for before, behind in zip([None, *buffers], buffers):
    env.process(station(env, before, behind, draw))
env.run(env.process(last(env, buffers[-1], draw, int(sys.argv[1]))))
print(env.now)
