"""Random numbers and durations of a line.

The generator is xoshiro256++ by Blackman and Vigna, seeded through their SplitMix64. A stream is
named by the seed of the run, a purpose, and the FNV-1a hash of a name.
"""

import math

BITS = (1 << 64) - 1
PURPOSES = ["arrivals", "failures", "defects", "sample", "service", "repairs", "setup", "routes"]


def split_mix(state):
    state = (state + 0x9E3779B97F4A7C15) & BITS
    mixed = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & BITS
    mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & BITS
    return state, mixed ^ (mixed >> 31)


def rotate(value, count):
    return ((value << count) | (value >> (64 - count))) & BITS


class Stream:
    def __init__(self, seed, purpose, name):
        named = 0xCBF29CE484222325
        for byte in name.encode():
            named = ((named ^ byte) * 0x100000001B3) & BITS
        state = split_mix(seed)[1] ^ named
        state = split_mix(state)[1] ^ (PURPOSES.index(purpose) + 1)
        self.state = []
        for _ in range(4):
            state, word = split_mix(state)
            self.state.append(word)

    def bits(self):
        a, b, c, d = self.state
        result = (rotate((a + d) & BITS, 23) + a) & BITS
        shifted = (b << 17) & BITS
        c ^= a
        d ^= b
        b ^= c
        a ^= d
        c ^= shifted
        self.state = [a, b, c, rotate(d, 45)]
        return result

    def unit(self):
        return (self.bits() >> 11) * 2.0**-53

    def chance(self, probability):
        return self.unit() < probability

    def below(self, count):
        return (self.bits() * count) >> 64


class Durations:
    """Draws from `[name, parameter, ...]`. `["table", numbers]` are draws that were made already."""

    def __init__(self, distribution, stream):
        self.name, *self.parameters = distribution
        self.stream = stream
        if self.name == "table":
            self.numbers = iter(self.parameters[0])

    def draw(self):
        if self.name == "constant":
            return self.parameters[0]
        if self.name == "table":
            return next(self.numbers)
        if self.name == "uniform":
            low, high = self.parameters
            return low + (high - low) * self.stream.unit()
        if self.name == "exponential":
            return -self.parameters[0] * math.log(1.0 - self.stream.unit())
        if self.name == "discrete":
            unit, total = self.stream.unit(), 0.0
            for value, probability in self.parameters[0]:
                total += probability
                if unit < total:
                    break
            return value
        if self.name == "empirical":
            (values,) = self.parameters
            return values[self.stream.below(len(values))]
        raise ValueError(self.name)
