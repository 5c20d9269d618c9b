/* @{about}
@ if orders
 *
@ endif
@ for order in orders
 *   @{order}
@ endfor
 *
 * Tell it every call of a skill before the call is made. It is an interlock: a call that is refused must not
 * be made, and changes nothing. A monitor belongs to one thread at a time.
 */
#ifndef LINEWRIGHT_@{name}_H
#define LINEWRIGHT_@{name}_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The skills. */
enum {
@ for skill in skills
    @{skill} = @{loop.index0},
@ endfor
    @{name}_SKILLS = @{count}
};

/* Several skills that are called at once: @{name}_MASK(a) | @{name}_MASK(b). */
#define @{name}_MASK(skill) ((uint64_t)1 << (skill))

/* What a call is answered with. What is negative refuses it. */
enum {
    @{name}_ALLOWED = 0,
@ for refusal in refusals
    @{refusal.about}
    @{refusal.name} = @{refusal.answer}@{"," if not loop.last else ""}
@ endfor
};

/* Where the monitor is between two calls. */
typedef struct @{name} {
    uint32_t state;
} @{name};

/* Before the first call. To be called before anything else. */
void @{name}_reset(@{name} *monitor);

/* All skills of a mask are called at once. */
int @{name}_call(@{name} *monitor, uint64_t skills);

/* One skill is called. */
int @{name}_call_one(@{name} *monitor, unsigned skill);

/* Skills are called one after the other. The result says how many were allowed before the first that was refused; call that one by
 * itself to learn why. */
size_t @{name}_run(@{name} *monitor, const uint8_t *skills, size_t count);

/* What @{name}_call would be answered with; nothing changes. */
int @{name}_allows(const @{name} *monitor, uint64_t skills);

/* The skills that may be called next, each alone, as a mask. */
uint64_t @{name}_allowed(const @{name} *monitor);

/* An answer in words: the rule that refused, with its name. */
const char *@{name}_text(int answer);

#ifdef __cplusplus
}
#endif

#endif
