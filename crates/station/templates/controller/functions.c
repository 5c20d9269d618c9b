/* The controller of @{title}, synthesized and verified by linewright.
 *
 *     cc -std=c99 -O2 -c @{name}.c
 */
#include "@{name}.h"

#include <stddef.h>

/* The signals: signal 2k is a bit of the values in the last step, signal 2k + 1 the same bit in this step. */
@ for signal in signals
/* @{signal.first}..@{signal.end}: @{signal.about} */
@ endfor

/* A node of a decision diagram. Edge 2n leads to node n - 1, edge 2n + 1 to its negation; edge 0 is false and edge 1 is true. */
typedef struct {
    uint32_t high, low; /* edges if the signal is 1, and if it is 0 */
    uint16_t signal;
} node;

typedef struct {
    uint32_t edge;
    uint16_t signal;
} output;

/* A mode of pursuing a goal: the edge of its condition, and the index of its first output. */
typedef struct {
    uint32_t when, first;
} mode;

/* A goal: the index of its first mode, and the edge of the condition that it is reached. */
typedef struct {
    uint32_t mode, reached;
} goal;

static const node nodes[] = {
@{nodes}
};

/* The outputs of step 0, then those of the modes, in the order of computation. */
static const output computed[] = {
@{computed}
};

static const mode modes[] = {
@{modes}
};

static const goal goals[] = {
@{goals}
};

/* Assumptions about step 0, and about every later step. */
static const uint32_t assumed_first[] = {
@ for rule in assumed_first
    @{rule.edge}, /* @{rule.about} */
@ else
    1
@ endfor
};

static const uint32_t assumed[] = {
@ for rule in assumed
    @{rule.edge}, /* @{rule.about} */
@ else
    1
@ endfor
};

static int holds(uint32_t edge, const uint8_t *signals)
{
    uint32_t value = edge & 1u;
    while (edge > 1u) {
        const node *at = &nodes[edge / 2u - 1u];
        edge = signals[at->signal] ? at->high : at->low;
        value ^= edge & 1u;
    }
    return (int)value;
}

@ if reads
/* Writes the bits of a number to every other signal, most significant bit first. */
static void put(uint8_t *signals, size_t bits, uint64_t code)
{
    while (bits-- > 0) {
        signals[2 * bits] = (uint8_t)(code & 1u);
        code >>= 1;
    }
}

@ endif
@ if writes
/* Reads a number from every other signal, most significant bit first. */
static int64_t get(const uint8_t *signals, size_t bits)
{
    uint64_t code = 0;
    size_t i;
    for (i = 0; i < bits; i++) {
        code = 2 * code + signals[2 * i];
    }
    return (int64_t)code;
}

@ endif
void @{name}_reset(@{name}_state *state)
{
    size_t i;
    state->goal = -1;
    for (i = 0; i < sizeof state->current; i++) {
        state->current[i] = 0;
    }
}

int @{name}_step(@{name}_state *state, const @{name}_inputs *inputs, @{name}_outputs *outputs)
{
    uint8_t signals[@{bits}];
    const uint32_t *assumptions = state->goal < 0 ? assumed_first : assumed;
    size_t assumption_count = state->goal < 0 ? sizeof assumed_first / sizeof *assumed_first : sizeof assumed / sizeof *assumed;
    const output *answer = computed;
    size_t i;
@ for input in inputs
    if (inputs->@{input.field} < @{input.low} || inputs->@{input.field} > @{input.high}) {
        return @{name}_OUTSIDE_DOMAIN;
    }
@ else
    (void)inputs;
@ endfor
    for (i = 0; i < sizeof state->current; i++) {
        signals[2 * i] = state->current[i];
        signals[2 * i + 1] = 0;
    }
@ for input in inputs
@ if input.bits
    put(signals + @{input.signal}, @{input.bits}, (uint64_t)((int64_t)inputs->@{input.field} - @{input.low}));
@ endif
@ endfor
    for (i = 0; i < assumption_count; i++) {
        if (!holds(assumptions[i], signals)) {
            return @{name}_ASSUMPTION_BROKEN;
        }
    }
    if (state->goal >= 0) {
        const mode *taken = &modes[goals[state->goal].mode];
        while (!holds(taken->when, signals)) {
            taken++; /* the condition of a goal's last mode always holds */
        }
        answer = &computed[taken->first];
    }
@ if count
    for (i = 0; i < @{count}; i++) {
        signals[answer[i].signal] = (uint8_t)holds(answer[i].edge, signals);
    }
@ else
    (void)answer;
@ endif
    if (state->goal < 0) {
        state->goal = 0;
    } else if (holds(goals[state->goal].reached, signals)) {
        state->goal = (state->goal + 1) % @{goal_count};
    }
    for (i = 0; i < sizeof state->current; i++) {
        state->current[i] = signals[2 * i + 1];
    }
@ for output in outputs
    outputs->@{output.field} = (@{output.kind})(@{output.value});
@ else
    (void)outputs;
@ endfor
    return @{name}_OK;
}
