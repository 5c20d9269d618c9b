/* @{about}
@ if orders
 *
@ endif
@ for order in orders
 *   @{order}
@ endfor
 *
 *     cc -std=c99 -O2 -c @{name}.c
 */
#include "@{name}.h"

/* A state is where its row of @{row} begins. What is no state says why a call is refused. */
#define ROW @{row}u
#define REFUSED @{refused}u
#define TOGETHER @{together}u
#define UNKNOWN @{unknown}u

/* A bit for each skill. */
#define ALL 0x@{all}ULL

@{after_a_skill}
static const @{kind} single[] = {
@ for row in single
    @{row},
@ endfor
};

/* The answers in words. */
static const char *const texts[] = {
    "allowed",
@ for text in texts
    @{text}@{"," if not loop.last else ""}
@ endfor
};

@ if sets
/* The sets of skills that may be called at once, in ascending order. */
static const uint64_t sets[] = {
@ for set in sets
    0x@{set.mask}ULL, @{set.about}
@ endfor
};
#define SETS @{set_count}u

/* After each of them, a row a state. */
static const @{kind} at_once[] = {
@ for row in at_once
    @{row},
@ endfor
};

@ endif
/* What a state becomes when these skills are called at once. */
static uint32_t after(uint32_t state, uint64_t skills)
{
@ if sets
    size_t first = 0, end = SETS;
@ endif
    if (skills == 0) {
        return state;
    }
    if ((skills & ~ALL) != 0) {
        return UNKNOWN;
    }
    if ((skills & (skills - 1)) == 0) {
        unsigned skill = 0;
        while ((skills >> skill & 1) == 0) {
            skill++;
        }
        return single[state + skill];
    }
@ if sets
    while (first < end) {
        size_t middle = first + (end - first) / 2;
        if (sets[middle] < skills) {
            first = middle + 1;
        } else {
            end = middle;
        }
    }
    if (first == SETS || sets[first] != skills) {
        return TOGETHER;
    }
    return at_once[state / ROW * SETS + first];
@ else
    return TOGETHER;
@ endif
}

/* A state as an answer. */
static int answer(uint32_t to)
{
    return to < REFUSED ? 0 : -1 - (int)(to - REFUSED);
}

void @{name}_reset(@{name} *monitor)
{
    monitor->state = @{start}u;
}

int @{name}_call(@{name} *monitor, uint64_t skills)
{
    uint32_t to = after(monitor->state, skills);
    if (to < REFUSED) {
        monitor->state = to;
    }
    return answer(to);
}

int @{name}_call_one(@{name} *monitor, unsigned skill)
{
    uint32_t to = skill < ROW ? single[monitor->state + skill] : UNKNOWN;
    if (to < REFUSED) {
        monitor->state = to;
    }
    return answer(to);
}

size_t @{name}_run(@{name} *monitor, const uint8_t *skills, size_t count)
{
    uint32_t state = monitor->state;
    size_t at;
    for (at = 0; at < count; at++) {
        uint32_t to = skills[at] < ROW ? single[state + skills[at]] : UNKNOWN;
        if (to >= REFUSED) {
            break;
        }
        state = to;
    }
    monitor->state = state;
    return at;
}

int @{name}_allows(const @{name} *monitor, uint64_t skills)
{
    return answer(after(monitor->state, skills));
}

uint64_t @{name}_allowed(const @{name} *monitor)
{
    uint64_t skills = 0;
    unsigned skill;
    for (skill = 0; skill < ROW; skill++) {
        if (single[monitor->state + skill] < REFUSED) {
            skills |= @{name}_MASK(skill);
        }
    }
    return skills;
}

const char *@{name}_text(int answer)
{
    const int last = (int)(sizeof texts / sizeof *texts) - 1;
    return texts[answer > 0 || answer < -last ? last : -answer];
}
