/* The FMI 3.0 co-simulation interface of a machine.
 *
 * Types, constants and signatures are those of the standard; only those that the functions below
 * use are declared. The standard requires every function of all three kinds of units; the functions
 * of the other two kinds return an error. To link several units into one program, define
 * `FMI3_FUNCTION_PREFIX`, a prefix of the functions' names. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef bool fmi3Boolean;
typedef bool fmi3Clock;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum {
    fmi3IntervalNotYetKnown,
    fmi3IntervalUnchanged,
    fmi3IntervalChanged
} fmi3IntervalQualifier;

typedef void fmi3LogMessageCallback(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void fmi3IntermediateUpdateCallback(fmi3InstanceEnvironment, fmi3Float64 time, fmi3Boolean set_requested,
                                            fmi3Boolean get_allowed, fmi3Boolean step_finished, fmi3Boolean may_return,
                                            fmi3Boolean *returns, fmi3Float64 *return_time);
typedef void fmi3ClockUpdateCallback(fmi3InstanceEnvironment);
typedef void fmi3LockPreemptionCallback(void);
typedef void fmi3UnlockPreemptionCallback(void);

/* An instance's data about its host. */
typedef struct lw_fmi_host {
    fmi3LogMessageCallback *logger;
    fmi3InstanceEnvironment environment;
} lw_fmi_host;

static void lw_fmi_log(const lw_fmi_host *host, int status, const char *text)
{
    if (host->logger != NULL) {
        host->logger(host->environment, (fmi3Status)status, "logStatusError", text);
    }
}

#include "fmi.c"

#if defined(FMI3_FUNCTION_PREFIX) && !defined(FMI3_OVERRIDE_FUNCTION_PREFIX)
#define LW_FMI3(name) LW_FMI_PASTE(FMI3_FUNCTION_PREFIX, name)
#else
#define LW_FMI3(name) name
#endif

/* ---- Creation and destruction ---------------------------------------------------------------- */

LW_FMI_EXPORT const char *LW_FMI3(fmi3GetVersion)(void)
{
    return "3.0";
}

/* Has no effect: rejected calls are always logged, and nothing else is logged. */
LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetDebugLogging)(fmi3Instance instance, fmi3Boolean on, size_t count,
                                                      const fmi3String categories[])
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3SetDebugLogging")) {
        (void)on;
        (void)lw_fmi_has_room(&call, categories, count, categories, count);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi3Instance LW_FMI3(fmi3InstantiateCoSimulation)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference intermediate[], size_t intermediate_count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback *log, fmi3IntermediateUpdateCallback *update)
{
    lw_fmi_host host;
    host.logger = log;
    host.environment = environment;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)early_return;
    (void)intermediate;
    (void)update;
    if (name == NULL || name[0] == '\0') {
        lw_fmi_log(&host, LW_FMI_ERROR, "fmi3InstantiateCoSimulation: the instance has no name");
        return NULL;
    }
    if (event_mode || intermediate_count != 0) {
        lw_fmi_log(&host, LW_FMI_ERROR,
                   "fmi3InstantiateCoSimulation: this unit does not support event mode or intermediate values");
        return NULL;
    }
    return lw_fmi_instantiate(&host, token, "fmi3InstantiateCoSimulation");
}

LW_FMI_EXPORT fmi3Instance LW_FMI3(fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                                 fmi3Boolean visible, fmi3Boolean logging,
                                                                 fmi3InstanceEnvironment environment,
                                                                 fmi3LogMessageCallback *log)
{
    lw_fmi_host host;
    host.logger = log;
    host.environment = environment;
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    lw_fmi_log(&host, LW_FMI_ERROR, "fmi3InstantiateModelExchange: this unit supports only co-simulation");
    return NULL;
}

LW_FMI_EXPORT fmi3Instance LW_FMI3(fmi3InstantiateScheduledExecution)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback *log, fmi3ClockUpdateCallback *update,
    fmi3LockPreemptionCallback *lock, fmi3UnlockPreemptionCallback *unlock)
{
    lw_fmi_host host;
    host.logger = log;
    host.environment = environment;
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)update;
    (void)lock;
    (void)unlock;
    lw_fmi_log(&host, LW_FMI_ERROR, "fmi3InstantiateScheduledExecution: this unit supports only co-simulation");
    return NULL;
}

LW_FMI_EXPORT void LW_FMI3(fmi3FreeInstance)(fmi3Instance instance)
{
    lw_fmi_free(instance);
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3EnterInitializationMode)(fmi3Instance instance, fmi3Boolean tolerates,
                                                              fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean ends,
                                                              fmi3Float64 end)
{
    lw_fmi_call call;
    (void)tolerates;
    (void)tolerance;
    if (lw_fmi_enter(&call, instance, LW_FMI_INSTANTIATED, "fmi3EnterInitializationMode")) {
        lw_fmi_set_up(&call, start, ends ? 1 : 0, end);
        if (call.status == LW_FMI_OK) {
            call.unit->phase = LW_FMI_INITIALIZING;
        }
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

/* Moves an instance from one phase to another. */
static fmi3Status lw_fmi3_go(fmi3Instance instance, int from, int to, const char *function)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, from, function)) {
        call.unit->phase = to;
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3ExitInitializationMode)(fmi3Instance instance)
{
    return lw_fmi3_go(instance, LW_FMI_INITIALIZING, LW_FMI_STEPPING, "fmi3ExitInitializationMode");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3Terminate)(fmi3Instance instance)
{
    return lw_fmi3_go(instance, LW_FMI_STEPPING, LW_FMI_TERMINATED, "fmi3Terminate");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3Reset)(fmi3Instance instance)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3Reset")) {
        lw_fmi_initialize(call.slot, call.unit);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

/* ---- Values ---------------------------------------------------------------------------------- */

#define LW_FMI3_SETTABLE (LW_FMI_INSTANTIATED | LW_FMI_INITIALIZING | LW_FMI_STEPPING)

/* Whether all variables exist and can be read as one of the types; rejects the call if not. */
static int lw_fmi3_readable(lw_fmi_call *call, const fmi3ValueReference *references, size_t count, const void *values,
                            size_t room, unsigned types)
{
    int good = lw_fmi_has_room(call, references, count, values, room);
    for (size_t i = 0; i < count && good; i++) {
        good = lw_fmi_has_type(call, references[i], types);
    }
    return good;
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetFloat64)(fmi3Instance instance, const fmi3ValueReference references[],
                                                 size_t count, fmi3Float64 values[], size_t room)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3GetFloat64")
        && lw_fmi3_readable(&call, references, count, values, room, 1U << LW_FMI_REAL)) {
        for (size_t i = 0; i < count; i++) {
            values[i] = lw_fmi_read(&call, references[i]).real;
        }
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

/* Checks all values before the first is set, so that a rejected call changes nothing. */
LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetFloat64)(fmi3Instance instance, const fmi3ValueReference references[],
                                                 size_t count, const fmi3Float64 values[], size_t room)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI3_SETTABLE, "fmi3SetFloat64")
        && lw_fmi3_readable(&call, references, count, values, room, 1U << LW_FMI_REAL)) {
        size_t good = 0;
        lw_fmi_value value = { 0.0, 0 };
        while (good < count) {
            value.real = values[good];
            if (!lw_fmi_can_set(&call, references[good], value)) {
                break;
            }
            good++;
        }
        for (size_t i = 0; i < count && good == count; i++) {
            value.real = values[i];
            lw_fmi_write(&call, references[i], value);
        }
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

/* The three integer types differ only in their width. */
#define LW_FMI3_WHOLE(Name, Type, kinds)                                                                                   \
    LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3Get##Name)(fmi3Instance instance, const fmi3ValueReference references[],          \
                                                    size_t count, Type values[], size_t room)                              \
    {                                                                                                                      \
        lw_fmi_call call;                                                                                                  \
        if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3Get" #Name)                                                     \
            && lw_fmi3_readable(&call, references, count, values, room, kinds)) {                                          \
            for (size_t i = 0; i < count; i++) {                                                                           \
                values[i] = (Type)lw_fmi_to_host(references[i], lw_fmi_read(&call, references[i]).whole);                    \
            }                                                                                                              \
        }                                                                                                                  \
        return (fmi3Status)lw_fmi_leave(&call);                                                                            \
    }                                                                                                                      \
    LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3Set##Name)(fmi3Instance instance, const fmi3ValueReference references[],          \
                                                    size_t count, const Type values[], size_t room)                        \
    {                                                                                                                      \
        lw_fmi_call call;                                                                                                  \
        if (lw_fmi_enter(&call, instance, LW_FMI3_SETTABLE, "fmi3Set" #Name)                                               \
            && lw_fmi3_readable(&call, references, count, values, room, kinds)) {                                          \
            size_t good = 0;                                                                                               \
            lw_fmi_value value = { 0.0, 0 };                                                                               \
            while (good < count) {                                                                                         \
                value.whole = lw_fmi_from_host(references[good], values[good]);                                              \
                if (!lw_fmi_can_set(&call, references[good], value)) {                                                     \
                    break;                                                                                                 \
                }                                                                                                          \
                good++;                                                                                                    \
            }                                                                                                              \
            for (size_t i = 0; i < count && good == count; i++) {                                                          \
                value.whole = lw_fmi_from_host(references[i], values[i]);                                                    \
                lw_fmi_write(&call, references[i], value);                                                                 \
            }                                                                                                              \
        }                                                                                                                  \
        return (fmi3Status)lw_fmi_leave(&call);                                                                            \
    }

LW_FMI3_WHOLE(Int32, int32_t, 1U << LW_FMI_INTEGER)
LW_FMI3_WHOLE(Int64, int64_t, (1U << LW_FMI_LONG) | (1U << LW_FMI_ENUMERATION))
LW_FMI3_WHOLE(Boolean, fmi3Boolean, 1U << LW_FMI_BOOLEAN)

/* Reads or writes variables of a type that no variable has, so only an empty list is valid. */
static fmi3Status lw_fmi3_none(fmi3Instance instance, size_t count, const fmi3ValueReference *references,
                               const char *function)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, function) && count != 0
        && lw_fmi_has_room(&call, references, count, references, count)) {
        (void)lw_fmi_has_type(&call, references[0], 0U);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

#define LW_FMI3_NONE(Name, Type)                                                                                           \
    LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3Get##Name)(fmi3Instance instance, const fmi3ValueReference references[],          \
                                                    size_t count, Type values[], size_t room)                              \
    {                                                                                                                      \
        (void)values;                                                                                                      \
        (void)room;                                                                                                        \
        return lw_fmi3_none(instance, count, references, "fmi3Get" #Name);                                                 \
    }                                                                                                                      \
    LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3Set##Name)(fmi3Instance instance, const fmi3ValueReference references[],          \
                                                    size_t count, const Type values[], size_t room)                        \
    {                                                                                                                      \
        (void)values;                                                                                                      \
        (void)room;                                                                                                        \
        return lw_fmi3_none(instance, count, references, "fmi3Set" #Name);                                                 \
    }

LW_FMI3_NONE(Float32, fmi3Float32)
LW_FMI3_NONE(Int8, int8_t)
LW_FMI3_NONE(UInt8, uint8_t)
LW_FMI3_NONE(Int16, int16_t)
LW_FMI3_NONE(UInt16, uint16_t)
LW_FMI3_NONE(UInt32, uint32_t)
LW_FMI3_NONE(UInt64, uint64_t)
LW_FMI3_NONE(String, fmi3String)

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetBinary)(fmi3Instance instance, const fmi3ValueReference references[],
                                                size_t count, size_t sizes[], fmi3Binary values[], size_t room)
{
    (void)sizes;
    (void)values;
    (void)room;
    return lw_fmi3_none(instance, count, references, "fmi3GetBinary");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetBinary)(fmi3Instance instance, const fmi3ValueReference references[],
                                                size_t count, const size_t sizes[], const fmi3Binary values[], size_t room)
{
    (void)sizes;
    (void)values;
    (void)room;
    return lw_fmi3_none(instance, count, references, "fmi3SetBinary");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetClock)(fmi3Instance instance, const fmi3ValueReference references[],
                                               size_t count, fmi3Clock values[])
{
    (void)values;
    return lw_fmi3_none(instance, count, references, "fmi3GetClock");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetClock)(fmi3Instance instance, const fmi3ValueReference references[],
                                               size_t count, const fmi3Clock values[])
{
    (void)values;
    return lw_fmi3_none(instance, count, references, "fmi3SetClock");
}

/* ---- States ---------------------------------------------------------------------------------- */

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3GetFMUState")) {
        lw_fmi_get_state(&call, state);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3SetFMUState")) {
        lw_fmi_set_state(&call, state);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3FreeFMUState")) {
        lw_fmi_free_state(state);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SerializedFMUStateSize)(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3SerializedFMUStateSize")
        && lw_fmi_has_room(&call, state, 1, size, 1)) {
        *size = sizeof(lw_fmi_saved);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SerializeFMUState)(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[],
                                                        size_t size)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3SerializeFMUState")) {
        lw_fmi_serialize(&call, state, bytes, size);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3DeserializeFMUState)(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                                          fmi3FMUState *state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, "fmi3DeserializeFMUState")) {
        lw_fmi_deserialize(&call, bytes, size, state);
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

/* ---- Steps ----------------------------------------------------------------------------------- */

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3DoStep)(fmi3Instance instance, fmi3Float64 at, fmi3Float64 size, fmi3Boolean final,
                                             fmi3Boolean *events, fmi3Boolean *terminates, fmi3Boolean *early,
                                             fmi3Float64 *reached)
{
    lw_fmi_call call;
    (void)final;
    if (lw_fmi_enter(&call, instance, LW_FMI_STEPPING, "fmi3DoStep")) {
        if (events == NULL || terminates == NULL || early == NULL || reached == NULL) {
            lw_fmi_refuse(&call, "an argument is missing");
        } else {
            lw_fmi_step(&call, at, size);
            *events = false;
            *terminates = false;
            *early = false;
            *reached = lw_fmi_now(call.unit);
        }
    }
    return (fmi3Status)lw_fmi_leave(&call);
}

/* ---- Unsupported functions ------------------------------------------------------------------- */

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3EnterEventMode)(fmi3Instance instance)
{
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3EnterEventMode");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3EnterConfigurationMode)(fmi3Instance instance)
{
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3EnterConfigurationMode");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3ExitConfigurationMode)(fmi3Instance instance)
{
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3ExitConfigurationMode");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3EnterStepMode)(fmi3Instance instance)
{
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3EnterStepMode");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3EnterContinuousTimeMode)(fmi3Instance instance)
{
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3EnterContinuousTimeMode");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3EvaluateDiscreteStates)(fmi3Instance instance)
{
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3EvaluateDiscreteStates");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetNumberOfVariableDependencies)(fmi3Instance instance,
                                                                      fmi3ValueReference reference, size_t *count)
{
    (void)reference;
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetNumberOfVariableDependencies");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetVariableDependencies)(fmi3Instance instance, fmi3ValueReference dependent,
                                                              size_t dependent_elements[],
                                                              fmi3ValueReference independents[],
                                                              size_t independent_elements[],
                                                              fmi3DependencyKind kinds[], size_t count)
{
    (void)dependent;
    (void)dependent_elements;
    (void)independents;
    (void)independent_elements;
    (void)kinds;
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetVariableDependencies");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetDirectionalDerivative)(fmi3Instance instance,
                                                               const fmi3ValueReference unknowns[],
                                                               size_t unknown_count,
                                                               const fmi3ValueReference knowns[], size_t known_count,
                                                               const fmi3Float64 seed[], size_t seed_count,
                                                               fmi3Float64 sensitivity[], size_t sensitivity_count)
{
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)seed_count;
    (void)sensitivity;
    (void)sensitivity_count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetDirectionalDerivative");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetAdjointDerivative)(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                           size_t unknown_count, const fmi3ValueReference knowns[],
                                                           size_t known_count, const fmi3Float64 seed[],
                                                           size_t seed_count, fmi3Float64 sensitivity[],
                                                           size_t sensitivity_count)
{
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)seed;
    (void)seed_count;
    (void)sensitivity;
    (void)sensitivity_count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetAdjointDerivative");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetIntervalDecimal)(fmi3Instance instance, const fmi3ValueReference references[],
                                                         size_t count, fmi3Float64 intervals[],
                                                         fmi3IntervalQualifier qualifiers[])
{
    (void)references;
    (void)count;
    (void)intervals;
    (void)qualifiers;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetIntervalDecimal");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetIntervalFraction)(fmi3Instance instance,
                                                          const fmi3ValueReference references[], size_t count,
                                                          uint64_t counters[], uint64_t resolutions[],
                                                          fmi3IntervalQualifier qualifiers[])
{
    (void)references;
    (void)count;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetIntervalFraction");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference references[],
                                                      size_t count, fmi3Float64 shifts[])
{
    (void)references;
    (void)count;
    (void)shifts;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetShiftDecimal");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetShiftFraction)(fmi3Instance instance, const fmi3ValueReference references[],
                                                       size_t count, uint64_t counters[], uint64_t resolutions[])
{
    (void)references;
    (void)count;
    (void)counters;
    (void)resolutions;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetShiftFraction");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetIntervalDecimal)(fmi3Instance instance, const fmi3ValueReference references[],
                                                         size_t count, const fmi3Float64 intervals[])
{
    (void)references;
    (void)count;
    (void)intervals;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3SetIntervalDecimal");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetIntervalFraction)(fmi3Instance instance,
                                                          const fmi3ValueReference references[], size_t count,
                                                          const uint64_t counters[], const uint64_t resolutions[])
{
    (void)references;
    (void)count;
    (void)counters;
    (void)resolutions;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3SetIntervalFraction");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference references[],
                                                      size_t count, const fmi3Float64 shifts[])
{
    (void)references;
    (void)count;
    (void)shifts;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3SetShiftDecimal");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetShiftFraction)(fmi3Instance instance, const fmi3ValueReference references[],
                                                       size_t count, const uint64_t counters[],
                                                       const uint64_t resolutions[])
{
    (void)references;
    (void)count;
    (void)counters;
    (void)resolutions;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3SetShiftFraction");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3UpdateDiscreteStates)(fmi3Instance instance, fmi3Boolean *again,
                                                           fmi3Boolean *terminates, fmi3Boolean *nominals_changed,
                                                           fmi3Boolean *values_changed, fmi3Boolean *next_known,
                                                           fmi3Float64 *next)
{
    (void)again;
    (void)terminates;
    (void)nominals_changed;
    (void)values_changed;
    (void)next_known;
    (void)next;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3UpdateDiscreteStates");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3CompletedIntegratorStep)(fmi3Instance instance, fmi3Boolean final,
                                                              fmi3Boolean *event_mode, fmi3Boolean *terminates)
{
    (void)final;
    (void)event_mode;
    (void)terminates;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3CompletedIntegratorStep");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetTime)(fmi3Instance instance, fmi3Float64 time)
{
    (void)time;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3SetTime");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3SetContinuousStates)(fmi3Instance instance, const fmi3Float64 states[],
                                                          size_t count)
{
    (void)states;
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3SetContinuousStates");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetContinuousStateDerivatives)(fmi3Instance instance, fmi3Float64 derivatives[],
                                                                    size_t count)
{
    (void)derivatives;
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetContinuousStateDerivatives");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetEventIndicators)(fmi3Instance instance, fmi3Float64 indicators[],
                                                         size_t count)
{
    (void)indicators;
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetEventIndicators");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetContinuousStates)(fmi3Instance instance, fmi3Float64 states[], size_t count)
{
    (void)states;
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetContinuousStates");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetNominalsOfContinuousStates)(fmi3Instance instance, fmi3Float64 nominals[],
                                                                    size_t count)
{
    (void)nominals;
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetNominalsOfContinuousStates");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *count)
{
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetNumberOfEventIndicators");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetNumberOfContinuousStates)(fmi3Instance instance, size_t *count)
{
    (void)count;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetNumberOfContinuousStates");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3GetOutputDerivatives)(fmi3Instance instance,
                                                           const fmi3ValueReference references[], size_t count,
                                                           const int32_t orders[], fmi3Float64 values[], size_t room)
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    (void)room;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3GetOutputDerivatives");
}

LW_FMI_EXPORT fmi3Status LW_FMI3(fmi3ActivateModelPartition)(fmi3Instance instance, fmi3ValueReference clock,
                                                             fmi3Float64 time)
{
    (void)clock;
    (void)time;
    return (fmi3Status)lw_fmi_unsupported(instance, "fmi3ActivateModelPartition");
}
