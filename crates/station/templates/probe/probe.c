/* The probe for Plant Simulation's UF_Value, emitted by linewright. See `probe.c` for a description. */
#define LW_PROBE_CALLS(CALL)@% for call in calls %@ \
    CALL(@{call.name}, @{call.count}U, @{call.arguments})@% endfor %@
@ if confirmed

/* The profile, line by line. */
#define LW_PROBE_PROFILE \
@ for line in confirmed.profile
    @{line}@{" \\" if not loop.last else ""}
@ endfor
#define LW_CONFIRM_INTEGER @{confirmed.integer}
#define LW_CONFIRM_REAL @{confirmed.real}
#define LW_CONFIRM_STRING @{confirmed.string}
@ endif

#include "probe.c"
