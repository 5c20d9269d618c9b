/* The plain C interface of a station library.
 *
 * A station library holds one machine of a production line: its coordinator and its actions, wired
 * together. A host needs only this header; it is plain C99 and independent of any simulator.
 * `host.c` in the same folder is a complete host.
 *
 * Handles.  `lw_create` returns the handle of a new instance, a number above 0 that fits 31 bits.
 * It contains a mark of the library and a generation, so that functions return LW_ERROR_HANDLE for
 * a handle of another machine, for a handle of a destroyed instance, and for a handle that was
 * never issued. A handle is issued again after 2047 others at the earliest; if only few instances
 * exist at a time, after two million. Handles begin at another number each time the library is
 * loaded: the chance that a handle from an earlier load is valid is one in two million for each
 * existing instance. There are 1023 marks, so two machines have the same mark with a probability of
 * one in a thousand. Two copies of one library file have separate instances but the same mark: load
 * the library from one path only. A library holds up to 1024 instances at a time.
 *
 * Errors.  Every function that can fail returns a negative code; `lw_last_error` then returns a
 * text that describes the error. A failed call leaves the instance unchanged, except for
 * LW_ERROR_LIMIT, which resets it. No call aborts the host or unwinds into it.
 *
 * Threads.  Several threads can call every function at once; calls on one instance wait for each
 * other. Each instance stores the text of its last error, so threads that share an instance also
 * share that text. The library stores one text for the last call without a valid handle, which all
 * threads share. `lw_last_error` copies the text, so it does not change while a host reads it.
 *
 * Memory.  The library allocates no memory, and stores none of the pointers that it receives. */
#ifndef LW_STATION_H
#define LW_STATION_H

#include <stddef.h>
#include <stdint.h>

/* With LW_PRIVATE, these functions are not exported: an adapter in the same translation unit has
 * its own exports. */
#if defined(LW_PRIVATE)
#if defined(__GNUC__)
#define LW_EXPORT static __attribute__((unused))
#else
#define LW_EXPORT static
#endif
#elif defined(_WIN32)
#define LW_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define LW_EXPORT __attribute__((visibility("default")))
#else
#define LW_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Increases whenever the meaning or signature of a function changes. */
#define LW_ABI_VERSION 1

/* Handle of an instance of the machine. */
typedef int32_t lw_handle;

/* Return codes. */
enum {
    LW_OK = 0,
    LW_ERROR_HANDLE = -1,     /* a handle that was never issued, or is no longer valid */
    LW_ERROR_ARGUMENT = -2,   /* a null pointer, a wrong tag, or a wrong count */
    LW_ERROR_DOMAIN = -3,     /* a value outside its domain */
    LW_ERROR_OPERATION = -4,  /* an operation that the machine does not have */
    LW_ERROR_ASSUMPTION = -5, /* the plant broke an assumption */
    LW_ERROR_GUARANTEE = -6,  /* the machine broke a guarantee: a bug of generator or compiler */
    LW_ERROR_LIMIT = -7,      /* the step limit was reached; the instance has been reset */
    LW_ERROR_MEMORY = -8,     /* all slots for instances are in use */
    LW_ERROR_INTERNAL = -9,   /* a bug of the generator */
    LW_ERROR_ORDER = -10      /* a skill was called against an order, by machine or caller */
};

/* Cost of an operation. */
typedef struct lw_service {
    double seconds; /* duration */
    double joules;  /* energy */
    int64_t steps;  /* number of controller steps */
} lw_service;

/* Returns the LW_ABI_VERSION that the library was built with. */
LW_EXPORT int32_t lw_abi_version(void);

/* Returns a static JSON text: schema version, contract hash, ports with their domains, properties
 * with their units, operations. */
LW_EXPORT const char *lw_describe(void);

/* Number of values that `lw_step` reads and writes, of properties that `lw_simulate` takes, and of
 * operations. */
LW_EXPORT int32_t lw_plant_count(void);
LW_EXPORT int32_t lw_output_count(void);
LW_EXPORT int32_t lw_property_count(void);
LW_EXPORT int32_t lw_operation_count(void);

/* Creates an instance in its state before step 0. Returns its handle (above 0) or a negative
 * code. */
LW_EXPORT lw_handle lw_create(void);

/* Destroys an instance and invalidates its handle, after waiting for calls in progress. */
LW_EXPORT int32_t lw_destroy(lw_handle handle);

/* Resets an instance to its state before step 0. The results of its last operation stay
 * readable. */
LW_EXPORT int32_t lw_reset(lw_handle handle);

/* Makes one step. `plant` holds the plant inputs, `outputs` receives every output and internal
 * variable of every component, both in the order of `lw_describe`. The counts must equal
 * `lw_plant_count` and `lw_output_count`; a host that does not need the outputs can pass a null
 * pointer with the count 0. An error leaves `outputs` unchanged. */
LW_EXPORT int32_t lw_step(lw_handle handle, const int64_t *plant, size_t plant_count, int64_t *outputs,
                          size_t output_count);

/* Runs the operation with this index to its end: abstracts the properties, makes steps until the
 * coordinator reports the end, and writes the new properties back. `service` receives the cost; it
 * can be null. An error leaves `properties` and `service` unchanged.
 * Properties must be finite. That they are in their declared ranges is up to the host. */
LW_EXPORT int32_t lw_simulate(lw_handle handle, int32_t operation, double *properties, size_t property_count,
                              lw_service *service);

/* Copies the text of the instance's last error, cut to `size` bytes including a final 0, and
 * returns the full length without the 0. For an invalid handle, this is the text of the library's
 * last call without a valid handle. */
LW_EXPORT int32_t lw_last_error(lw_handle handle, char *text, size_t size);

/* Copies the name of the broken rule in the same way, component first (`turn: gripped`). The text
 * is empty if no rule caused the error. */
LW_EXPORT int32_t lw_last_rule(lw_handle handle, char *text, size_t size);

#ifdef __cplusplus
}
#endif

#endif
