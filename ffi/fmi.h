/* Types and constants that generated machine files and the FMI adapters share: variable types and
 * value references.
 *
 * A value reference is a group and an index within the group, so a variable keeps its reference if
 * another group grows. */
#ifndef LW_FMI_H
#define LW_FMI_H

#include "machine.h"

#define LW_FMI_GROUP 0x100000U

/* The groups of value references. */
enum {
    LW_FMI_UNIT,     /* one of the variables below */
    LW_FMI_SIGNALS,  /* a signal of the plant, by its index among the plant's wires */
    LW_FMI_GIVEN,    /* a property or a parameter: the value that the host set */
    LW_FMI_RESULTS,  /* a property: its value after the last completed operation */
    LW_FMI_WIRES,    /* a wire after the last step */
    LW_FMI_GROUPS
};

/* The variables of every unit; those from `LW_FMI_OPERATION` on exist only if the machine has
 * operations. */
enum {
    LW_FMI_TIME,    /* the independent variable */
    LW_FMI_ENABLED,
    LW_FMI_SECONDS, /* from here: totals since the start */
    LW_FMI_JOULES,
    LW_FMI_STEPS,
    LW_FMI_VERDICT,
    LW_FMI_OPERATION,
    LW_FMI_DONE,
    LW_FMI_COMPLETED,
    LW_FMI_LAST_SECONDS, /* from here: the last completed operation */
    LW_FMI_LAST_JOULES,
    LW_FMI_LAST_STEPS,
    LW_FMI_UNIT_VARIABLES
};

/* The types of variables. Enumerations count from 1, as in Modelica: a label's number is the
 * machine's number plus 1. FMI 2 has no long integers and uses real numbers for them. */
enum { LW_FMI_REAL, LW_FMI_INTEGER, LW_FMI_LONG, LW_FMI_BOOLEAN, LW_FMI_ENUMERATION };

/* A wire: its type, and its value before the first step. */
typedef struct lw_fmi_wire {
    int type;
    int64_t before;
} lw_fmi_wire;

#if defined(_WIN32)
#define LW_FMI_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define LW_FMI_EXPORT __attribute__((visibility("default")))
#else
#define LW_FMI_EXPORT
#endif

#define LW_FMI_JOIN(a, b) a##b
#define LW_FMI_PASTE(a, b) LW_FMI_JOIN(a, b)

#endif
