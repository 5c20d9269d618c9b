/* The controller of @{title}, synthesized and verified by linewright.
 *
 *     cc -std=c99 -O2 -c @{name}.c
 */
#include "@{name}.h"

#include <stddef.h>

/* A test that an input is from `low` to `high`. */
typedef struct {
    uint32_t input;
    int64_t low, high;
} test;

/* Rows of the next table, from `first` up to but not including `last`. */
typedef struct {
    uint32_t first, last;
} range;

/* A transition: if one of its cubes holds, it gives the answer and leads to state `to`. */
typedef struct {
    uint32_t first, last, answer;
    int32_t to;
} transition;

static const test tests[] = {
@ for test in tests
    { @{test.input}, @{test.low}, @{test.high} }, /* @{test.name} */
@ else
    { 0, 0, 0 }
@ endfor
};

/* Conjunctions of tests. */
static const range cubes[] = {
@ for cube in cubes
    { @{cube.first}, @{cube.last} },
@ else
    { 0, 0 }
@ endfor
};

static const transition transitions[] = {
@ for transition in transitions
    { @{transition.first}, @{transition.last}, @{transition.answer}, @{transition.to} },
@ else
    { 0, 0, 0, 0 }
@ endfor
};

/* Transitions of step 0, then those of every state. */
static const range states[] = {
@ for state in states
    { @{state.first}, @{state.last} },
@ endfor
};

@ if outputs
static const int64_t answers[] = {
@ for values in answers
    @{values}
@ else
    0
@ endfor
};

@ endif
@ if operators
/* Operators of contracts that C lacks. No result overflows an int64_t, and no divisor is 0. */
@ endif
@ for operator in operators
@{operator}

@ endfor
@ if assumed_first
/* Whether step 0 keeps the assumptions. */
static int assumed_first(const int64_t *values)
{
@ for name in assumed_first.unused
    (void)@{name};
@ endfor
@ for check in assumed_first.checks
    /* @{check.about} */
    if (!(@{check.holds})) {
        return 0;
    }
@ endfor
    return 1;
}

@ endif
@ if assumed
/* Whether a later step keeps the assumptions. */
static int assumed(const int64_t *last, const int64_t *values)
{
@ for name in assumed.unused
    (void)@{name};
@ endfor
@ for check in assumed.checks
    /* @{check.about} */
    if (!(@{check.holds})) {
        return 0;
    }
@ endfor
    return 1;
}

@ endif
void @{name}_reset(@{name}_state *state)
{
    state->state = -1;
@ for value in kept
    state->last[@{loop.index0}] = 0;
@ endfor
}

int @{name}_step(@{name}_state *state, const @{name}_inputs *inputs, @{name}_outputs *outputs)
{
    int64_t values[@{values}];
    const range *here = &states[state->state + 1];
    uint32_t t, c, k;
@ for input in inputs
    if (inputs->@{input.field} < @{input.low} || inputs->@{input.field} > @{input.high}) {
        return @{name}_OUTSIDE_DOMAIN;
    }
@ else
    (void)inputs;
@ endfor
@ for input in inputs
    values[@{loop.index0}] = inputs->@{input.field};
@ else
    values[0] = 0;
@ endfor
@ if broken
    if (@{broken}) {
        return @{name}_ASSUMPTION_BROKEN;
    }
@ endif
    for (t = here->first; t < here->last; t++) {
        const transition *taken = &transitions[t];
        for (c = taken->first; c < taken->last; c++) {
            int holds = 1;
            for (k = cubes[c].first; k < cubes[c].last; k++) {
                int64_t value = values[tests[k].input];
                holds = holds && tests[k].low <= value && value <= tests[k].high;
            }
            if (holds) {
@ for output in outputs
                outputs->@{output.field} = (@{output.kind})@{output.value};
@ endfor
@ for value in kept
                state->last[@{loop.index0}] = @{value};
@ endfor
@ if not outputs
                (void)outputs;
@ endif
                state->state = taken->to;
                return @{name}_OK;
            }
        }
    }
    return @{name}_ASSUMPTION_BROKEN;
}
