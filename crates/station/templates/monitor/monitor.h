/* @{about}
@ if orders
 *
@ endif
@ for order in orders
 *   @{order}
@ endfor
 *
 * Report every call of a skill to the monitor before the call is made. The monitor is an interlock: a refused
 * call must not be made, and does not change the monitor. Use a monitor from one thread at a time.
 */
#ifndef LINEWRIGHT_@{name}_H
#define LINEWRIGHT_@{name}_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of the skills. */
enum {
@ for skill in skills
    @{skill} = @{loop.index0},
@ endfor
    @{name}_SKILLS = @{count}
};

/* Mask of a skill. To call several skills at once, combine their masks: @{name}_MASK(a) | @{name}_MASK(b). */
#define @{name}_MASK(skill) ((uint64_t)1 << (skill))

/* Answers to a call. A negative answer refuses it. */
enum {
    @{name}_ALLOWED = 0,
@ for refusal in refusals
    @{refusal.about}
    @{refusal.name} = @{refusal.answer}@{"," if not loop.last else ""}
@ endfor
};

/* State of the monitor between two calls. */
typedef struct @{name} {
    uint32_t state;
} @{name};

/* Sets the monitor to its state before the first call. Call this function first. */
void @{name}_reset(@{name} *monitor);

/* Reports that all skills of a mask are called at once. */
int @{name}_call(@{name} *monitor, uint64_t skills);

/* Reports that one skill is called. */
int @{name}_call_one(@{name} *monitor, unsigned skill);

/* Reports that skills are called one after the other. Returns the number of skills allowed before the first refusal; report the
 * refused skill by itself to get the reason. */
size_t @{name}_run(@{name} *monitor, const uint8_t *skills, size_t count);

/* Returns the answer that @{name}_call would give, without changing the monitor. */
int @{name}_allows(const @{name} *monitor, uint64_t skills);

/* Returns the mask of the skills that are allowed next, each on its own. */
uint64_t @{name}_allowed(const @{name} *monitor);

/* Returns the text of an answer: the name and text of the rule that refused the call. */
const char *@{name}_text(int answer);

#ifdef __cplusplus
}
#endif

#endif
