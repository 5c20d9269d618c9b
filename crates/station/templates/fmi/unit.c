/* The machine @{name}, emitted by linewright from its contracts as a co-simulation unit of FMI @{version}.
 *
 * Compile only this file; it includes the other files, which must be in the same folder:
 *
 *     cc -std=c99 -O2 -fPIC -shared -fvisibility=hidden -ffp-contract=off -pthread THIS.c -o THIS.so -lm
 *
 * To link the unit into a program, define @{prefix}, a prefix of the functions' names. */
#define LW_PRIVATE
@{unit}

/* ---- FMI -------------------------------------------------------------------------------------------------- */

#include "fmi.h"

/* Unused: modelDescription.xml describes the unit. */
static const char lw_description[] = "";

#define LW_FMI_TOKEN @{token}
@{tables}

#include "runtime.c"
#include "@{adapter}"
