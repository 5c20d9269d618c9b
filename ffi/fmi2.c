/* The FMI 2.0 co-simulation interface of a machine.
 *
 * Types, constants and signatures are those of the standard; only those that the functions below
 * use are declared. To link several units into one program, define `FMI2_FUNCTION_PREFIX`, a prefix
 * of the functions' names. */
#include <stddef.h>

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void fmi2CallbackLogger(fmi2ComponentEnvironment, fmi2String instance, fmi2Status, fmi2String category,
                                fmi2String message, ...);

typedef struct fmi2CallbackFunctions {
    fmi2CallbackLogger *logger;
    void *(*allocateMemory)(size_t count, size_t size);
    void (*freeMemory)(void *memory);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

/* An instance's data about its host. `name` is a copy of the instance's name, cut if it is too
 * long. */
typedef struct lw_fmi_host {
    fmi2CallbackLogger *logger;
    fmi2ComponentEnvironment environment;
    char name[128];
} lw_fmi_host;

/* Logs a text to the host. The host treats it as a format, so each `%` is doubled. */
static void lw_fmi_log(const lw_fmi_host *host, int status, const char *text)
{
    char format[2 * LW_TEXT_SIZE + 1];
    size_t length = 0;
    if (host->logger == NULL) {
        return;
    }
    while (*text != '\0' && length + 2 < sizeof format) {
        if (*text == '%') {
            format[length] = '%';
            length++;
        }
        format[length] = *text;
        length++;
        text++;
    }
    format[length] = '\0';
    host->logger(host->environment, host->name, (fmi2Status)status, "logStatusError", format);
}

#include "fmi.c"

#if defined(FMI2_FUNCTION_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX)
#define LW_FMI2(name) LW_FMI_PASTE(FMI2_FUNCTION_PREFIX, name)
#else
#define LW_FMI2(name) name
#endif

/* ---- Creation and destruction ---------------------------------------------------------------- */

LW_FMI_EXPORT const char *LW_FMI2(fmi2GetTypesPlatform)(void)
{
    return "default";
}

LW_FMI_EXPORT const char *LW_FMI2(fmi2GetVersion)(void)
{
    return "2.0";
}

/* Has no effect: rejected calls are always logged, and nothing else is logged. */
LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count,
                                                      const fmi2String categories[])
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2SetDebugLogging")) {
        (void)on;
        (void)lw_fmi_has_room(&call, categories, count, categories, count);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Component LW_FMI2(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid,
                                                     fmi2String resources, const fmi2CallbackFunctions *functions,
                                                     fmi2Boolean visible, fmi2Boolean logging)
{
    lw_fmi_host host;
    (void)resources;
    (void)visible;
    (void)logging;
    memset(&host, 0, sizeof host);
    if (functions != NULL) {
        host.logger = functions->logger;
        host.environment = functions->componentEnvironment;
    }
    if (name == NULL || name[0] == '\0') {
        lw_fmi_log(&host, LW_FMI_ERROR, "fmi2Instantiate: the instance has no name");
        return NULL;
    }
    for (size_t i = 0; name[i] != '\0' && i + 1 < sizeof host.name; i++) {
        host.name[i] = name[i];
    }
    if (type != fmi2CoSimulation) {
        lw_fmi_log(&host, LW_FMI_ERROR, "fmi2Instantiate: this unit supports only co-simulation");
        return NULL;
    }
    return lw_fmi_instantiate(&host, guid, "fmi2Instantiate");
}

LW_FMI_EXPORT void LW_FMI2(fmi2FreeInstance)(fmi2Component c)
{
    lw_fmi_free(c);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerates, fmi2Real tolerance,
                                                      fmi2Real start, fmi2Boolean ends, fmi2Real end)
{
    lw_fmi_call call;
    (void)tolerates;
    (void)tolerance;
    if (lw_fmi_enter(&call, c, LW_FMI_INSTANTIATED, "fmi2SetupExperiment")) {
        lw_fmi_set_up(&call, start, ends != 0, end);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

/* Moves an instance from one phase to another. */
static fmi2Status lw_fmi2_go(fmi2Component c, int from, int to, const char *function)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, from, function)) {
        call.unit->phase = to;
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2EnterInitializationMode)(fmi2Component c)
{
    return lw_fmi2_go(c, LW_FMI_INSTANTIATED, LW_FMI_INITIALIZING, "fmi2EnterInitializationMode");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2ExitInitializationMode)(fmi2Component c)
{
    return lw_fmi2_go(c, LW_FMI_INITIALIZING, LW_FMI_STEPPING, "fmi2ExitInitializationMode");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2Terminate)(fmi2Component c)
{
    return lw_fmi2_go(c, LW_FMI_STEPPING, LW_FMI_TERMINATED, "fmi2Terminate");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2Reset)(fmi2Component c)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2Reset")) {
        lw_fmi_initialize(call.slot, call.unit);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

/* ---- Values ---------------------------------------------------------------------------------- */

/* The types of variables that each function accepts. Long integers are real numbers in FMI 2. */
#define LW_FMI2_REAL ((1U << LW_FMI_REAL) | (1U << LW_FMI_LONG))
#define LW_FMI2_INTEGER ((1U << LW_FMI_INTEGER) | (1U << LW_FMI_ENUMERATION))
#define LW_FMI2_BOOLEAN (1U << LW_FMI_BOOLEAN)

/* Whether all variables exist and can be read as one of the types; rejects the call if not. */
static int lw_fmi2_readable(lw_fmi_call *call, const fmi2ValueReference *references, size_t count, const void *values,
                            unsigned types)
{
    int good = lw_fmi_has_room(call, references, count, values, count);
    for (size_t i = 0; i < count && good; i++) {
        good = lw_fmi_has_type(call, references[i], types);
    }
    return good;
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetReal)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                              fmi2Real values[])
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2GetReal")
        && lw_fmi2_readable(&call, references, count, values, LW_FMI2_REAL)) {
        for (size_t i = 0; i < count; i++) {
            lw_fmi_value value = lw_fmi_read(&call, references[i]);
            values[i] = lw_fmi_type_of(references[i]) == LW_FMI_REAL ? value.real : (double)value.whole;
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

/* Reads variables of one integer type. */
static fmi2Status lw_fmi2_get(fmi2Component c, const fmi2ValueReference *references, size_t count, int *values,
                              unsigned types, const char *function)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, function) && lw_fmi2_readable(&call, references, count, values, types)) {
        for (size_t i = 0; i < count; i++) {
            values[i] = (int)lw_fmi_to_host(references[i], lw_fmi_read(&call, references[i]).whole);
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                 fmi2Integer values[])
{
    return lw_fmi2_get(c, references, count, values, LW_FMI2_INTEGER, "fmi2GetInteger");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                 fmi2Boolean values[])
{
    return lw_fmi2_get(c, references, count, values, LW_FMI2_BOOLEAN, "fmi2GetBoolean");
}

/* Reads or writes variables of a type that no variable has, so only an empty list is valid. */
static fmi2Status lw_fmi2_none(fmi2Component c, size_t count, const fmi2ValueReference *references, const char *function)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, function) && count != 0
        && lw_fmi_has_room(&call, references, count, references, count)) {
        (void)lw_fmi_has_type(&call, references[0], 0U);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetString)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                fmi2String values[])
{
    (void)values;
    return lw_fmi2_none(c, count, references, "fmi2GetString");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetString)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                const fmi2String values[])
{
    (void)values;
    return lw_fmi2_none(c, count, references, "fmi2SetString");
}

#define LW_FMI2_SETTABLE (LW_FMI_INSTANTIATED | LW_FMI_INITIALIZING | LW_FMI_STEPPING)

/* Converts a real number to a value of the machine; the value of a long integer must be
 * integral. */
static lw_fmi_value lw_fmi2_value(fmi2ValueReference reference, double real)
{
    lw_fmi_value value = { real, 0 };
    if (lw_fmi_type_of(reference) == LW_FMI_LONG) {
        value.whole = fabs(real) < 9e15 && real == floor(real) ? (int64_t)real : INT64_MIN;
    }
    return value;
}

/* Checks all values before the first is set, so that a rejected call changes nothing. */
LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetReal)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                              const fmi2Real values[])
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI2_SETTABLE, "fmi2SetReal")
        && lw_fmi2_readable(&call, references, count, values, LW_FMI2_REAL)) {
        size_t good = 0;
        while (good < count && lw_fmi_can_set(&call, references[good], lw_fmi2_value(references[good], values[good]))) {
            good++;
        }
        for (size_t i = 0; i < count && good == count; i++) {
            lw_fmi_write(&call, references[i], lw_fmi2_value(references[i], values[i]));
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

static lw_fmi_value lw_fmi2_whole(fmi2ValueReference reference, int whole)
{
    lw_fmi_value value = { 0.0, 0 };
    value.whole = lw_fmi_from_host(reference, whole);
    return value;
}

static fmi2Status lw_fmi2_set(fmi2Component c, const fmi2ValueReference *references, size_t count, const int *values,
                              unsigned types, const char *function)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI2_SETTABLE, function)
        && lw_fmi2_readable(&call, references, count, values, types)) {
        size_t good = 0;
        while (good < count && lw_fmi_can_set(&call, references[good], lw_fmi2_whole(references[good], values[good]))) {
            good++;
        }
        for (size_t i = 0; i < count && good == count; i++) {
            lw_fmi_write(&call, references[i], lw_fmi2_whole(references[i], values[i]));
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                 const fmi2Integer values[])
{
    return lw_fmi2_set(c, references, count, values, LW_FMI2_INTEGER, "fmi2SetInteger");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                 const fmi2Boolean values[])
{
    return lw_fmi2_set(c, references, count, values, LW_FMI2_BOOLEAN, "fmi2SetBoolean");
}

/* ---- States ---------------------------------------------------------------------------------- */

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2GetFMUstate")) {
        lw_fmi_get_state(&call, state);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2SetFMUstate")) {
        lw_fmi_set_state(&call, state);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2FreeFMUstate")) {
        lw_fmi_free_state(state);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2SerializedFMUstateSize")
        && lw_fmi_has_room(&call, state, 1, size, 1)) {
        *size = sizeof(lw_fmi_saved);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                                        size_t size)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2SerializeFMUstate")) {
        lw_fmi_serialize(&call, state, bytes, size);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                                          fmi2FMUstate *state)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2DeSerializeFMUstate")) {
        lw_fmi_deserialize(&call, bytes, size, state);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

/* ---- Steps ----------------------------------------------------------------------------------- */

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2DoStep)(fmi2Component c, fmi2Real at, fmi2Real size, fmi2Boolean final)
{
    lw_fmi_call call;
    (void)final;
    if (lw_fmi_enter(&call, c, LW_FMI_STEPPING, "fmi2DoStep")) {
        lw_fmi_step(&call, at, size);
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2CancelStep)(fmi2Component c)
{
    return (fmi2Status)lw_fmi_unsupported(c, "fmi2CancelStep");
}

/* No step is ever pending: the status is that of the last step, which was already returned. */
LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2GetStatus") && lw_fmi_has_room(&call, c, 1, value, 1)) {
        if (kind == fmi2DoStepStatus) {
            *value = fmi2OK;
        } else {
            lw_fmi_refuse(&call, "this unit has no status of this kind");
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2GetRealStatus") && lw_fmi_has_room(&call, c, 1, value, 1)) {
        if (kind == fmi2LastSuccessfulTime) {
            *value = lw_fmi_now(call.unit);
        } else {
            lw_fmi_refuse(&call, "this unit has no status of this kind");
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind;
    (void)value;
    return (fmi2Status)lw_fmi_unsupported(c, "fmi2GetIntegerStatus");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2GetBooleanStatus") && lw_fmi_has_room(&call, c, 1, value, 1)) {
        if (kind == fmi2Terminated) {
            *value = 0;
        } else {
            lw_fmi_refuse(&call, "this unit has no status of this kind");
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, c, LW_FMI_ANY, "fmi2GetStringStatus") && lw_fmi_has_room(&call, c, 1, value, 1)) {
        if (kind == fmi2PendingStatus) {
            *value = "";
        } else {
            lw_fmi_refuse(&call, "this unit has no status of this kind");
        }
    }
    return (fmi2Status)lw_fmi_leave(&call);
}

/* ---- Unsupported functions ------------------------------------------------------------------- */

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknowns[],
                                                               size_t unknown_count, const fmi2ValueReference knowns[],
                                                               size_t known_count, const fmi2Real known_changes[],
                                                               fmi2Real unknown_changes[])
{
    (void)unknowns;
    (void)unknown_count;
    (void)knowns;
    (void)known_count;
    (void)known_changes;
    (void)unknown_changes;
    return (fmi2Status)lw_fmi_unsupported(c, "fmi2GetDirectionalDerivative");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference references[],
                                                              size_t count, const fmi2Integer orders[],
                                                              const fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    return (fmi2Status)lw_fmi_unsupported(c, "fmi2SetRealInputDerivatives");
}

LW_FMI_EXPORT fmi2Status LW_FMI2(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference references[],
                                                               size_t count, const fmi2Integer orders[],
                                                               fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)orders;
    (void)values;
    return (fmi2Status)lw_fmi_unsupported(c, "fmi2GetRealOutputDerivatives");
}
