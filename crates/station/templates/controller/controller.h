/* The controller of the contract @{contract}, synthesized and verified by linewright.
@ if moore
 * The outputs of a step do not depend on its inputs.
@ else
 * The outputs of a step may depend on its inputs.
@ endif
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

/* Where the controller is between two steps. */
typedef struct @{name}_state {
@ if bits
    /* The goal that is pursued; -1 before step 0. */
    int32_t goal;
    /* The bits of the last step's values. */
    uint8_t current[@{bits}];
@ else
    /* -1 before step 0. */
    int32_t state;
@ endif
@ if kept
    @{kept.about}
    int64_t last[@{kept.count}];
@ endif
} @{name}_state;

/* What @{name}_step returns. Exactly the inputs that break an assumption are refused as such. */
enum {
    @{name}_OK = 0,
    @{name}_ASSUMPTION_BROKEN = -1,
    @{name}_OUTSIDE_DOMAIN = -2
};

/* Before step 0. */
void @{name}_reset(@{name}_state *state);

/* One step. A negative result says why it was refused; then state and outputs are as before. */
int @{name}_step(@{name}_state *state, const @{name}_inputs *inputs, @{name}_outputs *outputs);

#ifdef __cplusplus
}
#endif

#endif
