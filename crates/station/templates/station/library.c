/* The machine @{name}, emitted by linewright from its contracts.
@ if doc
 *
 * @{doc}
@ endif
 *
 * Compile only this file; it includes the files of ffi/, which must be in the same folder:
 *
 *     cc -std=c99 -O2 -fPIC -shared -fvisibility=hidden -ffp-contract=off -pthread THIS.c -o THIS.so -lm
 */
@{unit}

#ifndef UF_USE_VENDOR_HEADER
static const char lw_description[] =
    @{description};
#else
static const char lw_description[] =
    @{vendors_description};
#endif

#include "runtime.c"
#include "plant_simulation.c"
