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

/* A state is the index at which its row of @{row} entries begins. Entries from REFUSED on are reasons to refuse a call. */
#define ROW @{row}u
#define REFUSED @{refused}u
#define TOGETHER @{together}u
#define UNKNOWN @{unknown}u

/* Mask with one bit for each skill. */
#define ALL 0x@{all}ULL

@{single_comment}
static const @{kind} single[] = {
@ for row in single
    @{row},
@ endfor
};

/* Texts of the answers. */
static const char *const texts[] = {
    "allowed",
@ for text in texts
    @{text}@{"," if not loop.last else ""}
@ endfor
};

@ if sets
/* The sets of skills that can be called at once, in ascending order. */
static const uint64_t sets[] = {
@ for set in sets
    0x@{set.mask}ULL, @{set.about}
@ endfor
};
#define SETS @{set_count}u

/* Next states after each of these sets: one row per state. */
static const @{kind} at_once[] = {
@ for row in at_once
    @{row},
@ endfor
};

@ endif
/* Next state, or reason to refuse, if these skills are called at once. */
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

/* Converts an entry of the tables to an answer. */
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
