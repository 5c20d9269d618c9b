/* The controller of @{title}, synthesized and verified by linewright.
@ if moore
 * The outputs of a step do not depend on its inputs.
@ else
 * The outputs of a step can depend on its inputs.
@ endif
@ for paragraph in usage
 *
 * @{paragraph}
@ endfor
 */
#ifndef LINEWRIGHT_@{name}_H
#define LINEWRIGHT_@{name}_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct @{name}_inputs {
@ for field in inputs
    @{field.kind} @{field.name}; /* @{field.about} */
@ else
    uint8_t none; /* C has no empty structures. */
@ endfor
} @{name}_inputs;

typedef struct @{name}_outputs {
@ for field in outputs
    @{field.kind} @{field.name}; /* @{field.about} */
@ else
    uint8_t none; /* C has no empty structures. */
@ endfor
} @{name}_outputs;

/* State of the controller between two steps. */
typedef struct @{name}_state {
@ if bits
    /* Index of the pursued goal; -1 before step 0. */
    int32_t goal;
    /* Bits of the values in the last step. */
    uint8_t current[@{bits}];
@ else
    /* Number of the state; -1 before step 0. */
    int32_t state;
@ endif
@ if kept
    @{kept.about}
    int64_t last[@{kept.count}];
@ endif
} @{name}_state;

/* Results of @{name}_step. */
enum {
    @{name}_OK = 0,
    @{name}_ASSUMPTION_BROKEN = -1,
    @{name}_OUTSIDE_DOMAIN = -2
};

/* Sets the state to before step 0. Call this function first. */
void @{name}_reset(@{name}_state *state);

/* Makes one step. A negative result is the reason why the step was rejected; state and outputs are then unchanged. */
int @{name}_step(@{name}_state *state, const @{name}_inputs *inputs, @{name}_outputs *outputs);

#ifdef __cplusplus
}
#endif

#endif
