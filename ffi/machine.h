/* The types of the tables that a generated machine file and the runtime share.
 *
 * A generated file defines the sizes below, includes this header, fills the tables, and includes
 * `runtime.c` and the adapter at its end. A library is therefore one translation unit, which one
 * run of the compiler builds, and all storage has a fixed size.
 *
 * Values.  A Boolean is 0 or 1, a label is its index from 0, an integer is itself.
 * `lw_state.values` holds the plant inputs first, then the variables of each component, in the
 * order of its contract and starting at its `first_value`. */
#ifndef LW_MACHINE_H
#define LW_MACHINE_H

/* In strict C99 mode, <pthread.h> declares its functions only with this macro. */
#if !defined(_WIN32) && !defined(_POSIX_C_SOURCE)
#define _POSIX_C_SOURCE 200809L
#endif

#include "station.h"

#include <math.h>

#if !defined(LW_COMPONENTS) || !defined(LW_NUMBER) || !defined(LW_PLANT) || !defined(LW_OUTPUTS) || !defined(LW_VALUES) || \
    !defined(LW_PROPERTIES) || !defined(LW_OPERATIONS) || !defined(LW_JUSTICE) || !defined(LW_HANDLE_MARK)
#error "include machine.h from a generated machine file, after the machine's sizes"
#endif

/* The smallest type that holds every value of every domain of this machine, for compact tables and
 * stored instances. Computations use int64_t. */
typedef LW_NUMBER lw_number;

/* A decision. It continues at `at_most` if the variable (an input of the component) is at most
 * `bound`, and otherwise at `above`. Each of the two is the number of another split, or -1 - n for
 * leaf n. */
typedef struct lw_split {
    int variable;
    int at_most;
    int above;
    lw_number bound;
} lw_split;

/* The result of a step: a row of the table of outputs and the next place, or -1 if there is no
 * transition. Place 0 is before step 0, place s + 1 is state s. */
typedef struct lw_leaf {
    int answer;
    int to;
} lw_leaf;

/* A controller whose tables would be too large is stored as functions of signals: the bits of the
 * values in the previous step and in this step. A signal is bit `shift` of value number `value` in
 * the array that `from` selects. */
enum {
    LW_PREVIOUS, /* the component's values in the previous step */
    LW_CURRENT,  /* the component's values in this step */
    LW_SHIFTED,  /* values minus the lowest value of their domain: see lw_shifted */
    LW_PUT       /* LW_PUT + LW_CURRENT and LW_PUT + LW_SHIFTED: a row of a walk that writes */
};

/* A node of a decision diagram. Edge 2n leads to node n - 1, edge 2n + 1 to its negation; edge 0 is
 * false and edge 1 is true. */
typedef struct lw_node {
    uint32_t high; /* edge if the signal is 1 */
    uint32_t low;  /* edge if the signal is 0 */
    uint16_t value;
    uint8_t from;
    uint8_t shift;
} lw_node;

/* A variable whose domain does not begin at 0. For variable number k, shifted value 2k is its value
 * in the previous step minus `low`, and shifted value 2k + 1 its value in this step minus `low`. */
typedef struct lw_shifted {
    int value;
    int computed; /* whether it is an output */
    int64_t low;
} lw_shifted;

/* A few walks, one after the other, set the output bits of a step. A list holds the rows at which
 * they begin, with 0 at its end. Rows count from 1; row 0 ends a walk. A row either reads a signal
 * and continues at row `high` or `low`; or it writes: it sets the bits of `low`, shifted left by
 * `shift`, and continues at row `high`. */

/* A mode of pursuing a goal: the edge of its condition, and the index of its first walk. The
 * condition of a goal's last mode always holds. */
typedef struct lw_mode {
    uint32_t when;
    uint32_t first;
} lw_mode;

/* A goal: the index of its first mode, and the edge of the condition that a step has reached it. */
typedef struct lw_goal {
    uint32_t mode;
    uint32_t reached;
} lw_goal;

/* Besides the values of the previous step, functions store only the pursued goal between two steps:
 * place 0 is before step 0, place g + 1 is goal g. */
typedef struct lw_functions {
    const lw_node *nodes;
    const lw_shifted *shifted;
    int shifted_count;
    const lw_node *walk;
    const uint32_t *walks; /* first rows of the walks; those of step 0 come first */
    const lw_mode *modes;
    const lw_goal *goals;
    int goal_count;
} lw_functions;

/* A formula's name, and the message if it is broken. */
typedef struct lw_rule {
    const char *rule;
    const char *message;
} lw_rule;

/* Returns the index of the first broken formula of a list, or -1. Does not read `previous` in step
 * 0. */
typedef int lw_check(const int64_t *previous, const int64_t *current);

/* A list of formulas; `check` is null if the list is empty. */
typedef struct lw_formulas {
    lw_check *check;
    const lw_rule *rules;
} lw_formulas;

/* One side of a contract, without justice. */
typedef struct lw_side {
    lw_formulas initial;
    lw_formulas invariants;
    lw_formulas safety;
} lw_side;

/* The range of a property: if `whole` is not 0, the integers from `low` to `high`. `labels` are the
 * names of the values from 0 on, or null. */
typedef struct lw_range {
    int whole;
    double low;
    double high;
    const char *const *labels;
} lw_range;

/* An output or internal variable as a host sees it: `turn_a.angle`. `labels` are the names of its
 * values from 0 on, or null. */
typedef struct lw_wire {
    const char *name;
    int value; /* index among all values */
    const char *const *labels;
} lw_wire;

/* An input of a component whose binding could have a value outside the input's domain. `value` is
 * the index of the input among the component's variables. */
typedef struct lw_input {
    const char *name;
    const char *domain;
    int value;
    int64_t low;
    int64_t high;
} lw_input;

/* A real number computed from the properties and all values. */
typedef double lw_real(const double *properties, const int64_t *values);

/* How an action's time is charged. */
enum { LW_TIME_STEP, LW_TIME_EXECUTION };

typedef struct lw_component {
    const char *name;
    int moore;
    int watches; /* whether it only watches orders of skills: its assumptions are the orders */
    int first_value;
    int inputs; /* number of inputs to check */
    int outputs;
    const lw_input *input;
    const int *output; /* indices of the outputs among the component's variables */
    const int *root; /* of each place: the split or leaf at which its decisions begin */
    const lw_split *splits;
    const lw_leaf *leaves;
    const lw_number *answers; /* rows of `outputs` values */
    const int *first_answer;  /* of a Moore component: its row of answers in each place, or -1 */
    const lw_functions *functions; /* used instead of the five fields above, or null */
    void (*bind)(const int64_t *values, int64_t *current);
    lw_side assumptions;
    lw_side guarantees;
    /* Stores `step` in `held` for each justice assumption that holds; null if there are none. */
    void (*justice)(const int64_t *previous, const int64_t *current, int earlier, int64_t step, int64_t *held);
    int first_justice;
    /* For an action: when it is active, its time and its power. The functions are null for other
     * components. */
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
    const char *about; /* beginning of an error message about the abstraction */
} lw_plant_input;

typedef struct lw_operation {
    const char *name;
    int64_t value;
} lw_operation;

/* Everything that a step changes, in the form that computations use. All zeros mean "before step
 * 0". */
typedef struct lw_state {
    int started;
    int place[LW_COMPONENTS + 1];
    int64_t values[LW_VALUES + 1];
} lw_state;

/* The same in compact form, as instances store it between calls. */
typedef struct lw_stored_state {
    int started;
    int place[LW_COMPONENTS + 1];
    lw_number values[LW_VALUES + 1];
} lw_stored_state;

#if defined(__GNUC__)
#define LW_MAY_BE_UNUSED __attribute__((unused))
#else
#define LW_MAY_BE_UNUSED
#endif

/* Unrolls a loop over a component's constant tables, if the compiler supports that. */
#if defined(__clang__) && defined(__OPTIMIZE__)
#define LW_UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__) && defined(__OPTIMIZE__)
#define LW_UNROLL _Pragma("GCC unroll 32")
#else
#define LW_UNROLL
#endif

/* Inlines a function, so that it is compiled for each component with its tables as constants; only
 * in optimized builds. */
#if defined(__GNUC__) && defined(__OPTIMIZE__)
#define LW_INLINE LW_MAY_BE_UNUSED static inline __attribute__((always_inline))
#elif defined(_MSC_VER) && !defined(__GNUC__)
#define LW_INLINE static __forceinline
#else
#define LW_INLINE LW_MAY_BE_UNUSED static
#endif

/* Integer operators of the contract language that C lacks. No result overflows an int64_t, and no
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

/* Division, rounded toward minus infinity. */
LW_MAY_BE_UNUSED static int64_t lw_div(int64_t a, int64_t b)
{
    int64_t q = a / b;
    return (a % b != 0 && (a < 0) != (b < 0)) ? q - 1 : q;
}

/* The remainder of lw_div. */
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
