/* The machine @{name}, emitted by linewright from its contracts as a co-simulation unit of FMI @{version}.
 *
 * Compile this file alone, with the others of this folder beside it:
 *
 *     cc -std=c99 -O2 -fPIC -shared -fvisibility=hidden -ffp-contract=off -pthread THIS.c -o THIS.so -lm
 *
 * Linked into a program, @{prefix} begins the names of its functions. */
#define LW_PRIVATE
@{unit}

/* ---- FMI -------------------------------------------------------------------------------------------------- */

#include "fmi.h"

/* modelDescription.xml describes the unit. */
static const char lw_description[] = "";

#define LW_FMI_TOKEN @{token}
@{tables}

#include "runtime.c"
#include "@{adapter}"
