/* The plain C interface of a station library.
 *
 * A station library holds one machine of a production line: its coordinator and its actions, wired
 * together. This header is all that a host needs; it is plain C99, and names no simulator. `host.c`
 * beside it is a complete host.
 *
 * Handles.  `lw_create` gives an instance's handle, a number above 0 that fits 31 bits. It carries
 * a mark of the library and a generation, so that a handle of another machine, one that was
 * destroyed, and one that was never given are all answered with LW_ERROR_HANDLE. Handles begin
 * somewhere else each time that the library is loaded: one that was kept from before is valid by
 * chance, one in two million for each instance there is. There are 1023 marks, so that one pair of
 * machines in a thousand has the same; and two copies of one library file have instances of their
 * own, but the same mark: load it from one path. A library holds up to 1024 instances at a time.
 *
 * Errors.  Every function that can fail gives a negative code. A text that says what is wrong can
 * be read with `lw_last_error`. After an error the instance is as it was before the call, except
 * after LW_ERROR_LIMIT, where it has been reset. Nothing aborts, and nothing unwinds into the host.
 *
 * Threads.  Every function may be called from several threads at once; calls on one instance wait
 * for each other. The text of the last error belongs to the instance, so with several threads on
 * one instance it is that of the last of them; in the same way what a call without a valid handle
 * leaves is of whichever thread made the last of them. `lw_last_error` copies, so no text changes
 * under its reader.
 *
 * Memory.  The library allocates nothing, and keeps no pointer that it was given. */
#ifndef LW_STATION_H
#define LW_STATION_H

#include <stddef.h>
#include <stdint.h>

/* With LW_PRIVATE these functions are no exports: an adapter in the same translation unit has its
 * own. */
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

/* Goes up whenever a function's meaning or signature changes. */
#define LW_ABI_VERSION 1

/* An instance of the machine. */
typedef int32_t lw_handle;

/* What a call answers with. */
enum {
    LW_OK = 0,
    LW_ERROR_HANDLE = -1,     /* a handle that was never given, or is no longer valid */
    LW_ERROR_ARGUMENT = -2,   /* a null pointer, a wrong tag, or a wrong count */
    LW_ERROR_DOMAIN = -3,     /* a value outside its domain */
    LW_ERROR_OPERATION = -4,  /* an operation that the machine does not have */
    LW_ERROR_ASSUMPTION = -5, /* the plant broke an assumption */
    LW_ERROR_GUARANTEE = -6,  /* the machine broke a guarantee: a bug of generator or compiler */
    LW_ERROR_LIMIT = -7,      /* the step limit was reached; the instance has been reset */
    LW_ERROR_MEMORY = -8,     /* no free place for an instance */
    LW_ERROR_INTERNAL = -9,   /* a fault of the generator */
    LW_ERROR_ORDER = -10      /* a skill was called against an order, by machine or caller */
};

/* What an operation took. */
typedef struct lw_service {
    double seconds; /* duration */
    double joules;  /* energy */
    int64_t steps;  /* steps of the controller */
} lw_service;

/* LW_ABI_VERSION of the library. */
LW_EXPORT int32_t lw_abi_version(void);

/* A static JSON text: schema version, contract hash, ports with their domains, properties with
 * their units, operations. */
LW_EXPORT const char *lw_describe(void);

/* How many values `lw_step` reads and writes, how many properties `lw_simulate` takes, and how many
 * operations there are. */
LW_EXPORT int32_t lw_plant_count(void);
LW_EXPORT int32_t lw_output_count(void);
LW_EXPORT int32_t lw_property_count(void);
LW_EXPORT int32_t lw_operation_count(void);

/* A new instance, before its step 0: its handle (above 0), or a negative code. */
LW_EXPORT lw_handle lw_create(void);

/* Ends an instance; its handle is not valid any more. Waits for calls that are under way. */
LW_EXPORT int32_t lw_destroy(lw_handle handle);

/* Back to before step 0. What the last operation took can still be read. */
LW_EXPORT int32_t lw_reset(lw_handle handle);

/* One step. `plant` holds the plant's inputs, `outputs` gets every output and internal variable of
 * every component, both in the order of `lw_describe`. The counts must be those of `lw_plant_count`
 * and `lw_output_count`; a null pointer will do for `outputs` where the host does not want them
 * (its count is then 0). On an error `outputs` is left alone. */
LW_EXPORT int32_t lw_step(lw_handle handle, const int64_t *plant, size_t plant_count, int64_t *outputs,
                          size_t output_count);

/* Runs an operation, by its index, to its end: abstracts the properties, steps until the
 * coordinator reports the end, writes the new properties back. `service` (may be null) gets what it
 * took. On an error neither is touched. */
LW_EXPORT int32_t lw_simulate(lw_handle handle, int32_t operation, double *properties, size_t property_count,
                              lw_service *service);

/* Copies the text of the instance's last error, cut to `size` bytes with a 0 at the end, and gives
 * its whole length without the 0. A handle that is not valid gives the library's last error of a
 * call without a valid handle. */
LW_EXPORT int32_t lw_last_error(lw_handle handle, char *text, size_t size);

/* The same for the rule that was broken, component first (`turn: gripped`); empty where the error
 * is about no rule. */
LW_EXPORT int32_t lw_last_rule(lw_handle handle, char *text, size_t size);

#ifdef __cplusplus
}
#endif

#endif
