/* What a generated machine file and the runtime share: the shape of the tables.
 *
 * A generated file defines the sizes below, includes this header, fills the tables, and includes
 * `runtime.c` and the adapter at its end. So a library is one translation unit, compiled by one run
 * of the compiler, and all storage has a fixed size.
 *
 * Values.  Booleans are 0 and 1, labels are numbered from 0, integers are themselves.
 * `lw_state.values` holds the plant's inputs first, then every component's variables in the order
 * of its contract, from `first_value` on. */
#ifndef LW_MACHINE_H
#define LW_MACHINE_H

/* A strict C99 compiler shows the threads of <pthread.h> only when asked. */
#if !defined(_WIN32) && !defined(_POSIX_C_SOURCE)
#define _POSIX_C_SOURCE 200809L
#endif

#include "station.h"

#include <math.h>

#if !defined(LW_COMPONENTS) || !defined(LW_NUMBER) || !defined(LW_PLANT) || !defined(LW_OUTPUTS) || !defined(LW_VALUES) || \
    !defined(LW_PROPERTIES) || !defined(LW_OPERATIONS) || !defined(LW_JUSTICE) || !defined(LW_HANDLE_MARK)
#error "machine.h is included by a generated machine file, after the machine's sizes"
#endif

/* The smallest type that holds every value of every domain of this machine: tables and resting
 * instances are small. What is computed with is an int64_t. */
typedef LW_NUMBER lw_number;

/* A comparison of one of the component's variables, an input: whereto when it is at most `bound`,
 * and when it is more. A way is the number of a further split, or -1 - n for leaf n. */
typedef struct lw_split {
    int variable;
    int at_most;
    int above;
    lw_number bound;
} lw_split;

/* What a step gives: a row of the table of outputs, and the place that follows; -1 where there is
 * no transition. Place 0 is before step 0, place s + 1 is state s. */
typedef struct lw_leaf {
    int answer;
    int to;
} lw_leaf;

/* A controller whose tables would be too large is functions of signals: of the bits of the values
 * of the step before and of this step. They are read where they are: bit `shift` of value number
 * `value` of those that `from` says. */
enum {
    LW_PREVIOUS, /* the component's values in the step before */
    LW_CURRENT,  /* its values in this step */
    LW_SHIFTED,  /* the current value minus the lowest one of the domain: see lw_shifted */
    LW_PUT       /* in a walk: LW_PUT + LW_CURRENT and LW_PUT + LW_SHIFTED are written */
};

/* A decision goes on with one edge or the other; edge 2n leads to node n - 1, edge 2n + 1 to its
 * negation, 0 is false and 1 is true. */
typedef struct lw_node {
    uint32_t high; /* when the signal is 1 */
    uint32_t low;
    uint16_t value;
    uint8_t from;
    uint8_t shift;
} lw_node;

/* A variable whose domain does not begin at 0: number 2k of the shifted values is its value in the
 * step before, less `low`, and number 2k + 1 that in this step. */
typedef struct lw_shifted {
    int value;
    int computed; /* whether it is an output */
    int64_t low;
} lw_shifted;

/* The output bits of a step are decided in a few walks, one after the other; their places follow
 * each other in a list, with 0 at its end. Row n - 1 of the table of walks is place n, place 0 is
 * the end of a walk. A row asks for a signal and goes on with place `high` or `low`; or it writes:
 * the bits of `low` are set, `shift` places up, and place `high` is next. */

/* A way of pursuing a goal: when it is taken, and the first of its walks. The last mode of a goal
 * always holds. */
typedef struct lw_mode {
    uint32_t when;
    uint32_t first;
} lw_mode;

/* A goal: its first mode, and when a step has reached it. */
typedef struct lw_goal {
    uint32_t mode;
    uint32_t reached;
} lw_goal;

/* All that is kept between two steps is the goal that is pursued: place 0 is before step 0, place g
 * + 1 is goal g. */
typedef struct lw_functions {
    const lw_node *nodes;
    const lw_shifted *shifted;
    int shifted_count;
    const lw_node *walk;
    const uint32_t *walks; /* where walks begin; those of step 0 first */
    const lw_mode *modes;
    const lw_goal *goals;
    int goal_count;
} lw_functions;

/* A formula's name, and what is said when it is broken. */
typedef struct lw_rule {
    const char *rule;
    const char *message;
} lw_rule;

/* Which formula of a list is broken: its index, or -1. `previous` is not looked at in step 0. */
typedef int lw_check(const int64_t *previous, const int64_t *current);

/* A list of formulas; `check` is null where the list is empty. */
typedef struct lw_promise {
    lw_check *check;
    const lw_rule *rules;
} lw_promise;

/* One side of a contract, without its justice. */
typedef struct lw_side {
    lw_promise initial;
    lw_promise invariants;
    lw_promise safety;
} lw_side;

/* The values of a property: whole numbers from `low` to `high`, where `whole` is not 0; with
 * `labels`, these stand for the numbers from 0 on. */
typedef struct lw_range {
    int whole;
    double low;
    double high;
    const char *const *labels;
} lw_range;

/* An output or internal variable as a host sees it: `turn_a.angle`. `labels` stand for the numbers
 * from 0 on, or are null. */
typedef struct lw_wire {
    const char *name;
    int value; /* counts all values */
    const char *const *labels;
} lw_wire;

/* An input of a component whose binding could leave its domain: `value` counts the component's
 * variables. */
typedef struct lw_input {
    const char *name;
    const char *domain;
    int value;
    int64_t low;
    int64_t high;
} lw_input;

/* A number of the plant, over the properties and all values. */
typedef double lw_real(const double *properties, const int64_t *values);

/* How an action's time is charged. */
enum { LW_TIME_STEP, LW_TIME_EXECUTION };

typedef struct lw_component {
    const char *name;
    int moore;
    int watches; /* it does nothing but watch over orders of skills, which it assumes to be kept */
    int first_value;
    int inputs; /* those that have to be checked */
    int outputs;
    const lw_input *input;
    const int *output; /* the outputs' places among the component's variables */
    const int *way; /* where each place begins */
    const lw_split *splits;
    const lw_leaf *leaves;
    const lw_number *answers; /* `outputs` values a row */
    const int *first_answer;  /* of a Moore component: its answer in each place, or -1 */
    const lw_functions *functions; /* instead of the five above, or null */
    void (*bind)(const int64_t *values, int64_t *current);
    lw_side assumptions;
    lw_side guarantees;
    /* Justice assumptions: notes in `held` the step in which each one held. Null where there are
     * none. */
    void (*justice)(const int64_t *previous, const int64_t *current, int earlier, int64_t step, int64_t *held);
    int first_justice;
    /* Null for the coordinator. */
    int (*active)(const int64_t *values);
    int time;
    lw_real *seconds;
    lw_real *watts;
} lw_component;

/* Where a plant input's value comes from in `lw_simulate`. */
enum { LW_FROM_OPERATION, LW_FROM_SCRIPT, LW_FROM_PROPERTY };

typedef struct lw_plant_input {
    const char *name;
    const char *domain;
    int64_t low;
    int64_t high;
    int source;
    const int64_t *script;
    int script_length;
    lw_real *abstraction;
    const char *about; /* how an error of the abstraction begins */
} lw_plant_input;

typedef struct lw_operation {
    const char *name;
    int64_t value;
} lw_operation;

/* Everything that a step changes, while it is worked with. All zero is "before step 0". */
typedef struct lw_state {
    int started;
    int place[LW_COMPONENTS + 1];
    int64_t values[LW_VALUES + 1];
} lw_state;

/* The same of an instance at rest. */
typedef struct lw_rest {
    int started;
    int place[LW_COMPONENTS + 1];
    lw_number values[LW_VALUES + 1];
} lw_rest;

#if defined(__GNUC__)
#define LW_MAY_BE_UNUSED __attribute__((unused))
#else
#define LW_MAY_BE_UNUSED
#endif

/* A loop over a component's constant tables that becomes plain statements, where the compiler can
 * do that. */
#if defined(__clang__) && defined(__OPTIMIZE__)
#define LW_UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__) && defined(__OPTIMIZE__)
#define LW_UNROLL _Pragma("GCC unroll 32")
#else
#define LW_UNROLL
#endif

/* A function that is compiled anew for every component, with its tables as constants; where speed
 * is asked for at all. */
#if defined(__GNUC__) && defined(__OPTIMIZE__)
#define LW_INLINE LW_MAY_BE_UNUSED static inline __attribute__((always_inline))
#elif defined(_MSC_VER) && !defined(__GNUC__)
#define LW_INLINE static __forceinline
#else
#define LW_INLINE LW_MAY_BE_UNUSED static
#endif

/* The contract language's integer operators that C lacks. No value leaves an int64_t, and no
 * divisor is 0: both were checked when the contract was read. */
LW_MAY_BE_UNUSED static int64_t lw_abs(int64_t a)
{
    return a < 0 ? -a : a;
}

LW_MAY_BE_UNUSED static int64_t lw_min(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

LW_MAY_BE_UNUSED static int64_t lw_max(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

/* Division rounded towards minus infinity. */
LW_MAY_BE_UNUSED static int64_t lw_div(int64_t a, int64_t b)
{
    int64_t q = a / b;
    return (a % b != 0 && (a < 0) != (b < 0)) ? q - 1 : q;
}

/* The rest of that division. */
LW_MAY_BE_UNUSED static int64_t lw_mod(int64_t a, int64_t b)
{
    return a - b * lw_div(a, b);
}

/* A truth value as a number. */
LW_MAY_BE_UNUSED static int64_t lw_int(int truth)
{
    return truth ? 1 : 0;
}

/* A truth value as a real number. */
LW_MAY_BE_UNUSED static double lw_truth(int truth)
{
    return truth ? 1.0 : 0.0;
}

/* The contract language's `mod` of real numbers. */
LW_MAY_BE_UNUSED static double lw_real_mod(double a, double b)
{
    return a - b * floor(a / b);
}

#endif
