/* The test host: what its files share.
 *
 * It is the host that nobody wants to be served by: it loads a station library by its path, does everything that a plan says and
 * compares every answer, calls with whatever can be wrong, counts the calls in millions, unloads in between, and comes with several
 * threads. The plan is written by the tests from the machine run in their own process, so that nothing in here knows what a
 * machine means.
 *
 *     host LIBRARY PLAN CALLS OTHER_LIBRARY
 *
 * LIBRARY and OTHER_LIBRARY (of another machine, for handles that are not the library's own) are absolute paths; CALLS says how
 * many calls it should come to. The last line is HOST PASSED, or HOST FAILED after what was expected and what was seen.
 *
 *     platform.c   libraries, threads, memory: all that differs between Windows and POSIX
 *     library.c    the exports
 *     plan.c       the plan's file
 *     replay.c     one line of the plan on an instance, through either interface
 *     mistakes.c   calls that have to be refused
 *     lifetimes.c  instances: how many, how often, and after the library was loaded anew
 *     threads.c    several threads on many instances, on one, and on instances that come and go
 *     main.c       the order of it all */
#ifndef HOST_H
#define HOST_H

/* The threads of <pthread.h> are shown only when asked for. */
#if !defined(_WIN32) && !defined(_POSIX_C_SOURCE)
#define _POSIX_C_SOURCE 200809L
#endif

#include "station.h"

#include <stddef.h>
#include <stdint.h>

/* ---- Values of the adapter, in the default profile: written down once more, as a host would have it ----------------- */

#define LW_UF_TAG_INTEGER 1
#define LW_UF_TAG_REAL 2
#define LW_UF_TAG_STRING 3
#define LW_UF_INTEGER int32_t
#define LW_UF_FIELD_INTEGER integer
#define LW_UF_FIELD_REAL real
#define LW_UF_FIELD_STRING string

typedef struct UF_Value {
    int type;
    union {
        LW_UF_INTEGER integer;
        double real;
        const char *string;
    } value;
} UF_Value;

/* ---- platform.c -------------------------------------------------------------------------------------------------- */

/* A library loaded by its path, or null. */
void *module_load(const char *path);
void module_unload(void *module);
/* Whether a library of that path is still in this process. */
int module_present(const char *path);
/* Copies the address of an export to `function`, a pointer to a function; 0 where there is none. */
int module_find(void *module, const char *name, void *function);

/* Bytes that this process has in memory, or 0 where that is not known cheaply, or means nothing (under a sanitizer). */
int64_t memory_in_use(void);

#define MOST_THREADS 8

/* Runs `work` in as many threads as asked, each with its number from 0, and waits for all. */
void threads_run(int threads, void (*work)(int thread));

/* A lock of the host's own: for its table of handles, and for the last words. */
void lock_take(void);
void lock_give(void);

/* ---- library.c --------------------------------------------------------------------------------------------------- */

typedef void value_export(UF_Value *ret, UF_Value *arg);

typedef struct library {
    void *module;
    const char *path;
    /* station.h */
    int32_t (*abi_version)(void);
    const char *(*describe)(void);
    int32_t (*plant_count)(void);
    int32_t (*output_count)(void);
    int32_t (*property_count)(void);
    int32_t (*operation_count)(void);
    lw_handle (*create)(void);
    int32_t (*destroy)(lw_handle);
    int32_t (*reset)(lw_handle);
    int32_t (*step)(lw_handle, const int64_t *, size_t, int64_t *, size_t);
    int32_t (*simulate)(lw_handle, int32_t, double *, size_t, lw_service *);
    int32_t (*last_error)(lw_handle, char *, size_t);
    int32_t (*last_rule)(lw_handle, char *, size_t);
    /* plant_simulation.c */
    value_export *instantiate_value;
    value_export *simulate_value;
    value_export *get_real_value;
    value_export *get_integer_value;
    value_export *get_string_value;
    value_export *reset_value;
    value_export *deinstantiate_value;
    value_export *last_error_value;
    value_export *describe_value;
} library;

/* Loads a library and finds every export; any that is missing is a failure. */
void library_open(library *lib, const char *path);
/* Unloads it; that it stays in the process is a failure. */
void library_close(library *lib);

UF_Value value_integer(int64_t integer);
UF_Value value_real(double real);
UF_Value value_string(const char *string);
UF_Value value_of_tag(int tag);

/* Calls an export, and gives its answer. A failure, where no answer of that kind is given. */
int64_t call_integer(value_export *export, UF_Value *arg, const char *what);
double call_real(value_export *export, UF_Value *arg, const char *what);
const char *call_string(value_export *export, UF_Value *arg, const char *what);

/* ---- plan.c ------------------------------------------------------------------------------------------------------ */

typedef enum line_kind { LINE_RESET, LINE_STEP, LINE_OPERATION } line_kind;

typedef struct line {
    line_kind kind;
    int number;        /* in the file, from 1 */
    int32_t operation; /* of an operation */
    int32_t code;      /* what is to be answered */
    size_t given;      /* of a step: the first plant value among the integers; of an operation: the first property among the reals */
    size_t got;        /* where it succeeds, likewise: outputs, or properties */
    lw_service service;
    const char *rule; /* where it is refused */
    const char *text;
} line;

/* A name with what values it has, and what those from 0 on are called, where they are called anything. */
typedef struct port {
    const char *name;
    int64_t low;
    int64_t high;
    const char **labels;
    int32_t label_count;
} port;

typedef struct plan {
    const char *machine;
    const char *description;
    int32_t plant;
    int32_t outputs;
    int32_t properties;
    int32_t operations;
    port *plant_ports;
    port *output_ports;
    port *property_ports;
    const char **operation_names;
    line *lines;
    int line_count;
    int64_t *integers;
    double *reals;
} plan;

/* The plan of this run, which nothing changes once it is read. */
extern plan the_plan;

void plan_read(const char *path);

/* ---- replay.c ---------------------------------------------------------------------------------------------------- */

/* The interface through which operations go, and in which results are asked for. Texts that the adapter returns are overwritten by
 * later ones, of other threads too, so that several threads go by the adapter's numbers. */
typedef enum way { WAY_PLAIN, WAY_VALUES, WAY_NUMBERS } way;

#define MOST_VALUES 512

/* Does what a line says, and compares the answer with it. Gives how many calls of the library that took. */
int replay(const library *lib, lw_handle handle, const line *line, way way);

/* ---- mistakes.c -------------------------------------------------------------------------------------------------- */

/* How many mistakes there are to make. */
int mistake_count(void);
/* Makes one of them: a call that is to be refused, after which the instance is as before. Gives how many calls that took. */
int make_mistake(const library *lib, lw_handle handle, int which);
/* Every export with a handle that is not valid. */
int refuse_handle(const library *lib, lw_handle handle, const char *what);

/* ---- lifetimes.c ------------------------------------------------------------------------------------------------- */

/* A new instance; a failure where there is none. */
lw_handle instance(const library *lib);

void check_handles(const library *lib, const library *other);
void check_room(const library *lib);
void check_generations(const library *lib);
void use_up_generations(const library *lib);
void check_reload(library *lib);

/* ---- threads.c --------------------------------------------------------------------------------------------------- */

void check_threads(const library *lib, int64_t calls);

/* ---- main.c ------------------------------------------------------------------------------------------------------ */

#if defined(__GNUC__)
#define LIKE_PRINTF __attribute__((format(printf, 1, 2)))
#define NEVER_RETURNS __attribute__((noreturn))
#else
#define LIKE_PRINTF
#define NEVER_RETURNS
#endif

/* Says what was expected and what was seen, and ends the program. */
LIKE_PRINTF NEVER_RETURNS void fail(const char *format, ...);
/* A line about what is being done. */
LIKE_PRINTF void say(const char *format, ...);
/* Fails unless the two numbers are the same. */
void same(int64_t expected, int64_t seen, const char *what);
/* Fails unless an answer is this code. */
void same_code(int32_t expected, int32_t seen, const char *what);
/* Fails unless the text contains a part. */
void holds(const char *text, const char *part, const char *what);

/* A stream of numbers that is the same everywhere. */
uint32_t draw(uint64_t *state, uint32_t below);

#endif
