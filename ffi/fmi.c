/* A machine as an FMI co-simulation unit: the code that FMI 2 and FMI 3 share.
 *
 * `fmi2.c` and `fmi3.c` define `lw_fmi_host` (an instance's data about its host) and `lw_fmi_log`,
 * and include this file. An instance of a unit is an instance of runtime.c. The pointer that the
 * host holds is the handle of the instance, so a pointer that was never issued, or whose instance
 * was freed, is recognized. A table parallel to the slots holds the data that the unit adds.
 *
 * A communication step is an integer number of machine steps. An operation begins in the first
 * machine step, and in each machine step after the end of an operation. Only then are the
 * properties read, as in `lw_simulate`. If `enabled` is false, the machine stays in its state. The
 * machine steps of one communication step are made on a copy, so a failed communication step
 * changes only the verdict.
 *
 * Only the functions up to `lw_fmi_wire_value` use step.c directly. */
#include <stdlib.h>

/* The data of an instance that a saved state contains: all except the host. */
typedef struct lw_fmi_unit {
    int phase;
    /* Values that the host set. */
    int enabled;
    int32_t operation;
    int64_t signals[LW_PLANT + 1];
    double given[LW_PROPERTIES + 1];
    /* The operation in progress, and the values with which it began. */
    int running;
    int done; /* whether the last step ended an operation */
    int32_t performed;
    int64_t plant[LW_PLANT + 1];
    double held[LW_PROPERTIES + 1];
    lw_state start;
    lw_job job;
    /* Totals without the operation in progress. */
    double seconds;
    double joules;
    int64_t steps;
    int64_t completed;
    int32_t verdict;
    lw_service last;
    double results[LW_PROPERTIES + 1];
    /* Start time, number of machine steps since then, and stop time if there is one. */
    double began;
    int64_t ticks;
    int ends;
    double end;
} lw_fmi_unit;

/* ---- The machine's steps --------------------------------------------------------------------- */

/* Begins an operation, like `lw_perform` before its first step. In a machine without operations,
 * this function is called before each step and does not reset the totals. */
static int32_t lw_fmi_begin(const lw_state *state, lw_fmi_unit *unit, lw_error *error)
{
    int64_t value = 0;
    int32_t code;
#if LW_OPERATIONS > 0
    value = lw_operation_table[unit->operation].value;
    memset(&unit->job, 0, sizeof unit->job);
#endif
    memcpy(unit->held, unit->given, sizeof unit->held);
    code = lw_abstract(state, unit->held, value, unit->plant, error);
    unit->start = *state;
    unit->performed = unit->operation;
    unit->running = LW_OPERATIONS > 0;
    return code;
}

/* Ends an operation, like `lw_perform` after its last step. */
static int32_t lw_fmi_finish(const lw_state *state, lw_fmi_unit *unit, lw_error *error)
{
    int32_t code = lw_write_properties(unit->held, state->values, unit->results, error);
    if (code == LW_OK) {
        unit->last = unit->job.service;
        unit->seconds += unit->last.seconds;
        unit->joules += unit->last.joules;
        unit->steps += unit->last.steps;
        unit->completed++;
        unit->running = 0;
        memset(&unit->job, 0, sizeof unit->job);
    }
    return code;
}

/* Makes one machine step; while the machine is disabled, only time and energy advance. After an
 * error, the contents of `state` and `unit` are undefined. */
static int32_t lw_fmi_tick(lw_state *state, lw_fmi_unit *unit, lw_error *error)
{
    lw_state before = *state;
    int32_t code = LW_OK;
    if (!unit->enabled) {
        unit->seconds += LW_FMI_STEP_SECONDS;
        unit->joules += LW_FMI_STEP_SECONDS * LW_FMI_IDLE_WATTS;
        return LW_OK;
    }
    if (!unit->running) {
        code = lw_fmi_begin(&before, unit, error);
    }
    for (int i = 0; i < LW_PLANT; i++) {
        if (lw_plant_table[i].source == LW_FROM_SCRIPT) {
            unit->plant[i] = unit->signals[i];
        }
    }
    if (code == LW_OK) {
        code = lw_advance(&before, unit->plant, state, error);
    }
    if (code == LW_OK) {
        unit->job.properties = unit->held;
        code = lw_charge(&unit->job, &unit->start, &before, state, error);
        unit->job.properties = NULL;
    }
    if (code == LW_OK && unit->running) {
        unit->done = machine_done(state->values);
        if (unit->done) {
            code = lw_fmi_finish(state, unit, error);
        } else if (unit->job.service.steps >= LW_STEP_LIMIT) {
            code = lw_fail_limit(&unit->job, lw_operation_table[unit->performed].name, error);
        }
    }
    return code;
}

/* Resets the machine to its state before step 0, without an operation in progress. */
static void lw_fmi_restart(lw_slot *slot, lw_fmi_unit *unit)
{
    memset(&slot->state, 0, sizeof slot->state);
    unit->running = 0;
    unit->done = 0;
    memset(&unit->job, 0, sizeof unit->job);
}

/* Makes `ticks` machine steps. If one fails, none has an effect. */
static int32_t lw_fmi_ticks(lw_slot *slot, lw_fmi_unit *unit, int64_t ticks)
{
    lw_state state;
    lw_fmi_unit after = *unit;
    memset(&state, 0, sizeof state);
    lw_load_state(slot, &state);
    for (int64_t i = 0; i < ticks; i++) {
        int32_t code = lw_fmi_tick(&state, &after, &slot->error);
        if (code != LW_OK) {
            unit->verdict = code;
            if (code == LW_ERROR_LIMIT) {
                lw_fmi_restart(slot, unit);
            }
            return code;
        }
    }
    after.ticks += ticks;
    lw_store_state(slot, &state);
    *unit = after;
    return LW_OK;
}

/* Returns the value of a wire as the host sees it. */
static int64_t lw_fmi_wire_value(const lw_slot *slot, int wire)
{
    int value = wire < LW_PLANT ? wire : lw_output_table[wire - LW_PLANT].value;
    return slot->state.started ? slot->state.values[value] : lw_fmi_wire_table[wire].before;
}

/* ---- Calls ----------------------------------------------------------------------------------- */

/* Status values that both versions of FMI share. A failed step returns Error, "could not be carried
 * out at all", because Discard would mean that a part of the step was carried out, and hosts would
 * retry shorter steps repeatedly. */
enum { LW_FMI_OK = 0, LW_FMI_ERROR = 3 };

/* Phases of an instance. */
enum { LW_FMI_INSTANTIATED = 1, LW_FMI_INITIALIZING = 2, LW_FMI_STEPPING = 4, LW_FMI_TERMINATED = 8, LW_FMI_ANY = 15 };

static lw_fmi_unit lw_fmi_units[LW_SLOTS];
static lw_fmi_host lw_fmi_hosts[LW_SLOTS];

/* A call on an instance, which stays locked until `lw_fmi_leave`. Texts are sent to the host only
 * after that, because the host's logger can itself call the unit. */
typedef struct lw_fmi_call {
    const char *function;
    lw_slot *slot;
    lw_fmi_unit *unit;
    lw_fmi_host *host;
    lw_handle handle;
    int status;
    int broken; /* whether the text is the machine's own error */
    size_t length;
    char text[LW_TEXT_SIZE];
} lw_fmi_call;

static void lw_fmi_append(lw_fmi_call *call, const char *text)
{
    while (*text != '\0' && call->length + 1 < sizeof call->text) {
        call->text[call->length] = *text;
        call->length++;
        text++;
    }
    call->text[call->length] = '\0';
}

static void lw_fmi_append_number(lw_fmi_call *call, uint64_t number)
{
    char digits[24];
    int at = (int)sizeof digits - 1;
    digits[at] = '\0';
    do {
        at--;
        digits[at] = (char)('0' + (int)(number % 10U));
        number /= 10U;
    } while (number != 0);
    lw_fmi_append(call, &digits[at]);
}

/* Rejects a call with a text. */
static void lw_fmi_refuse(lw_fmi_call *call, const char *text)
{
    call->status = LW_FMI_ERROR;
    call->length = 0;
    lw_fmi_append(call, call->function);
    lw_fmi_append(call, ": ");
    lw_fmi_append(call, text);
}

/* Locks the instance of a pointer. Returns 0 if there is no such instance, or if the call is not
 * allowed in the instance's phase. */
static int lw_fmi_enter(lw_fmi_call *call, const void *instance, int phases, const char *function)
{
    intptr_t number = (intptr_t)instance;
    call->function = function;
    call->handle = number > 0 && number <= INT32_MAX ? (lw_handle)number : 0;
    call->status = LW_FMI_ERROR;
    call->broken = 0;
    call->length = 0;
    call->text[0] = '\0';
    call->slot = lw_lock_instance(call->handle);
    if (call->slot == NULL) {
        return 0;
    }
    call->unit = &lw_fmi_units[call->slot - lw_slots];
    call->host = &lw_fmi_hosts[call->slot - lw_slots];
    if ((call->unit->phase & phases) == 0) {
        int phase = call->unit->phase;
        lw_fmi_refuse(call, "not allowed ");
        lw_fmi_append(call, phase == LW_FMI_INSTANTIATED   ? "before the initialization"
                         : phase == LW_FMI_INITIALIZING ? "during the initialization"
                         : phase == LW_FMI_STEPPING     ? "after the initialization"
                                                        : "after the simulation was terminated");
        return 0;
    }
    call->status = LW_FMI_OK;
    return 1;
}

/* Unlocks the instance, logs an error to the host, and returns the status. */
static int lw_fmi_leave(lw_fmi_call *call)
{
    if (call->slot == NULL) {
        return call->status;
    }
    if (call->status == LW_FMI_OK) {
        lw_lock_give(&call->slot->lock);
    } else {
        lw_fmi_host host = *call->host;
        lw_lock_give(&call->slot->lock);
        if (call->broken) {
            lw_last_error(call->handle, call->text, sizeof call->text);
        }
        lw_fmi_log(&host, call->status, call->text);
    }
    return call->status;
}

/* Rejects a call that the unit does not support. */
static int lw_fmi_unsupported(const void *instance, const char *function)
{
    lw_fmi_call call;
    if (lw_fmi_enter(&call, instance, LW_FMI_ANY, function)) {
        lw_fmi_refuse(&call, "this unit does not support this function");
    }
    return lw_fmi_leave(&call);
}

/* ---- Creation and destruction ---------------------------------------------------------------- */

/* Sets an instance to its state after instantiation. */
static void lw_fmi_initialize(lw_slot *slot, lw_fmi_unit *unit)
{
    memset(unit, 0, sizeof *unit);
    unit->phase = LW_FMI_INSTANTIATED;
    unit->enabled = 1;
    unit->operation = LW_FMI_FIRST_OPERATION;
    for (int i = 0; i < LW_PLANT; i++) {
        if (lw_plant_table[i].source == LW_FROM_SCRIPT) {
            unit->signals[i] = lw_plant_table[i].script[0];
        }
    }
    for (int i = 0; i < LW_PROPERTIES; i++) {
        unit->given[i] = lw_fmi_defaults[i];
        unit->results[i] = lw_fmi_defaults[i];
    }
    lw_fmi_restart(slot, unit);
}

/* Creates an instance for a host. If that fails, logs an error to the host and returns null. */
static void *lw_fmi_instantiate(const lw_fmi_host *host, const char *token, const char *function)
{
    lw_fmi_call call;
    lw_handle handle;
    call.function = function;
    call.length = 0;
    if (token == NULL || strcmp(token, LW_FMI_TOKEN) != 0) {
        lw_fmi_refuse(&call, "the guid or instantiation token differs from that of this binary, " LW_FMI_TOKEN
                             ": modelDescription.xml and the binary belong to different units");
        lw_fmi_log(host, LW_FMI_ERROR, call.text);
        return NULL;
    }
    handle = lw_create();
    call.slot = handle > 0 ? lw_lock_instance(handle) : NULL;
    if (call.slot == NULL) {
        lw_fmi_log(host, LW_FMI_ERROR, "all slots for instances in this process are in use");
        return NULL;
    }
    lw_fmi_hosts[call.slot - lw_slots] = *host;
    lw_fmi_initialize(call.slot, &lw_fmi_units[call.slot - lw_slots]);
    lw_lock_give(&call.slot->lock);
    return (void *)(intptr_t)handle;
}

static void lw_fmi_free(const void *instance)
{
    intptr_t number = (intptr_t)instance;
    if (number > 0 && number <= INT32_MAX) {
        (void)lw_destroy((lw_handle)number);
    }
}

/* Sets the start and stop time of the simulation. */
static void lw_fmi_set_up(lw_fmi_call *call, double start, int ends, double end)
{
    if (!isfinite(start) || (ends && !(isfinite(end) && end >= start))) {
        lw_fmi_refuse(call, "the start time must be a finite number, and the stop time a finite number that is not less");
        return;
    }
    call->unit->began = start;
    call->unit->ends = ends;
    call->unit->end = end;
}

static double lw_fmi_now(const lw_fmi_unit *unit)
{
    return unit->began + (double)unit->ticks * LW_FMI_STEP_SECONDS;
}

/* Makes a communication step. The host computes points in time by summation, so they are compared
 * with a tolerance of half a machine step. The communication step size must be an integer number of
 * machine steps, within a millionth of a step. */
static void lw_fmi_step(lw_fmi_call *call, double at, double size)
{
    double ticks = size / LW_FMI_STEP_SECONDS;
    double now = lw_fmi_now(call->unit);
    int32_t code;
    if (!(isfinite(at) && fabs(at - now) <= 0.5 * LW_FMI_STEP_SECONDS)) {
        lw_fmi_refuse(call, "the step does not begin at the end of the previous step");
        return;
    }
    if (ticks > 1e9) {
        lw_fmi_refuse(call, "the communication step is longer than 1000000000 machine steps of " LW_FMI_STEP_TEXT
                            " s");
        return;
    }
    if (!(ticks >= 0.5 && fabs(ticks - round(ticks)) <= 1e-6)) {
        lw_fmi_refuse(call, "the communication step size must be an integer multiple of " LW_FMI_STEP_TEXT
                            " s, the machine's step");
        return;
    }
    if (call->unit->ends && at + size > call->unit->end + 0.5 * LW_FMI_STEP_SECONDS) {
        lw_fmi_refuse(call, "the step would end after the stop time");
        return;
    }
    code = lw_fmi_ticks(call->slot, call->unit, (int64_t)round(ticks));
    if (code != LW_OK) {
        call->broken = 1;
        call->status = LW_FMI_ERROR;
    }
}

/* ---- Values ---------------------------------------------------------------------------------- */

/* A value in the machine's numbering. */
typedef struct lw_fmi_value {
    double real;   /* the value of a real variable */
    int64_t whole; /* the value of any other variable */
} lw_fmi_value;

/* Returns the type of a variable; -1 if no variable has that reference. */
static int lw_fmi_type_of(uint32_t reference)
{
    int index = (int)(reference % LW_FMI_GROUP);
    switch (reference / LW_FMI_GROUP) {
    case LW_FMI_UNIT:
        if (index >= (LW_OPERATIONS > 0 ? (int)LW_FMI_UNIT_VARIABLES : (int)LW_FMI_OPERATION)) {
            return -1;
        }
        switch (index) {
        case LW_FMI_ENABLED:
        case LW_FMI_DONE:
            return LW_FMI_BOOLEAN;
        case LW_FMI_STEPS:
        case LW_FMI_COMPLETED:
        case LW_FMI_LAST_STEPS:
            return LW_FMI_LONG;
        case LW_FMI_VERDICT:
            return LW_FMI_INTEGER;
        case LW_FMI_OPERATION:
            return LW_FMI_ENUMERATION;
        default:
            return LW_FMI_REAL;
        }
    case LW_FMI_SIGNALS:
        return index < LW_PLANT && lw_plant_table[index].source == LW_FROM_SCRIPT ? lw_fmi_wire_table[index].type : -1;
    case LW_FMI_GIVEN:
        return index < LW_PROPERTIES ? LW_FMI_REAL : -1;
    case LW_FMI_RESULTS:
        return LW_OPERATIONS > 0 && index < LW_PROPERTIES ? LW_FMI_REAL : -1;
    case LW_FMI_WIRES:
        return index < LW_PLANT + LW_OUTPUTS && (index >= LW_PLANT || lw_plant_table[index].source == LW_FROM_PROPERTY)
                   ? lw_fmi_wire_table[index].type
                   : -1;
    default:
        return -1;
    }
}

/* Whether a variable exists and has one of the types (a bit mask); rejects the call if not. */
static int lw_fmi_has_type(lw_fmi_call *call, uint32_t reference, unsigned types)
{
    int type = lw_fmi_type_of(reference);
    if (type >= 0 && ((types >> type) & 1U) != 0) {
        return 1;
    }
    lw_fmi_refuse(call, type < 0 ? "there is no variable with the value reference "
                                 : "the function is for another type than that of the variable with the value reference ");
    lw_fmi_append_number(call, reference);
    return 0;
}

/* Whether counts and pointers are valid; rejects the call if not. */
static int lw_fmi_has_room(lw_fmi_call *call, const void *references, size_t count, const void *values, size_t room)
{
    if ((count == 0 || (references != NULL && values != NULL)) && room == count) {
        return 1;
    }
    lw_fmi_refuse(call, "an array is missing, or the number of values differs from the number of value references");
    return 0;
}

static lw_fmi_value lw_fmi_read(const lw_fmi_call *call, uint32_t reference)
{
    const lw_fmi_unit *unit = call->unit;
    const lw_service *job = &unit->job.service;
    int index = (int)(reference % LW_FMI_GROUP);
    lw_fmi_value value = { 0.0, 0 };
    switch (reference / LW_FMI_GROUP) {
    case LW_FMI_SIGNALS:
        value.whole = unit->signals[index];
        break;
    case LW_FMI_GIVEN:
        value.real = unit->given[index];
        break;
    case LW_FMI_RESULTS:
        value.real = unit->results[index];
        break;
    case LW_FMI_WIRES:
        value.whole = lw_fmi_wire_value(call->slot, index);
        break;
    default:
        switch (index) {
        case LW_FMI_TIME:
            value.real = lw_fmi_now(unit);
            break;
        case LW_FMI_ENABLED:
            value.whole = unit->enabled;
            break;
        case LW_FMI_SECONDS:
            value.real = unit->seconds + job->seconds;
            break;
        case LW_FMI_JOULES:
            value.real = unit->joules + job->joules;
            break;
        case LW_FMI_STEPS:
            value.whole = unit->steps + job->steps;
            break;
        case LW_FMI_VERDICT:
            value.whole = unit->verdict;
            break;
        case LW_FMI_OPERATION:
            value.whole = unit->operation;
            break;
        case LW_FMI_DONE:
            value.whole = unit->done;
            break;
        case LW_FMI_COMPLETED:
            value.whole = unit->completed;
            break;
        case LW_FMI_LAST_SECONDS:
            value.real = unit->last.seconds;
            break;
        case LW_FMI_LAST_JOULES:
            value.real = unit->last.joules;
            break;
        default:
            value.whole = unit->last.steps;
            break;
        }
        break;
    }
    return value;
}

/* Whether a variable can be set to a value; rejects the call if not. */
static int lw_fmi_can_set(lw_fmi_call *call, uint32_t reference, lw_fmi_value value)
{
    int index = (int)(reference % LW_FMI_GROUP);
    int good;
    switch (reference / LW_FMI_GROUP) {
    case LW_FMI_UNIT:
        if (index == LW_FMI_ENABLED) {
            good = value.whole == 0 || value.whole == 1;
        } else if (index == LW_FMI_OPERATION) {
            good = value.whole >= 0 && value.whole < LW_OPERATIONS;
        } else {
            lw_fmi_refuse(call, "only inputs and parameters can be set, not the variable with the value reference ");
            lw_fmi_append_number(call, reference);
            return 0;
        }
        break;
    case LW_FMI_SIGNALS:
        good = value.whole >= lw_plant_table[index].low && value.whole <= lw_plant_table[index].high;
        break;
    case LW_FMI_GIVEN:
        good = isfinite(value.real)
               && (!lw_property_ranges[index].whole
                   || (value.real >= lw_property_ranges[index].low && value.real <= lw_property_ranges[index].high
                       && value.real == floor(value.real)));
        break;
    default:
        lw_fmi_refuse(call, "only inputs and parameters can be set, not the variable with the value reference ");
        lw_fmi_append_number(call, reference);
        return 0;
    }
    if (!good) {
        lw_fmi_refuse(call, "the value is outside the domain of `");
        switch (reference / LW_FMI_GROUP) {
        case LW_FMI_SIGNALS:
            lw_fmi_append(call, lw_plant_table[index].name);
            lw_fmi_append(call, "`, ");
            lw_fmi_append(call, lw_plant_table[index].domain);
            break;
        case LW_FMI_GIVEN:
            lw_fmi_append(call, lw_property_names[index]);
            lw_fmi_append(call, "`, or is not a finite number");
            break;
        default:
            lw_fmi_append(call, index == LW_FMI_ENABLED ? "enabled`" : "operation`, which counts from 1");
            break;
        }
    }
    return good;
}

/* Sets a variable to a value that `lw_fmi_can_set` has checked. */
static void lw_fmi_write(lw_fmi_call *call, uint32_t reference, lw_fmi_value value)
{
    int index = (int)(reference % LW_FMI_GROUP);
    switch (reference / LW_FMI_GROUP) {
    case LW_FMI_SIGNALS:
        call->unit->signals[index] = value.whole;
        break;
    case LW_FMI_GIVEN:
        call->unit->given[index] = value.real;
        break;
    default:
        if (index == LW_FMI_ENABLED) {
            call->unit->enabled = (int)value.whole;
        } else {
            call->unit->operation = (int32_t)value.whole;
        }
        break;
    }
}

/* Converts an integer from the machine's numbering to the host's: enumerations count from 1
 * there. */
static int64_t lw_fmi_to_host(uint32_t reference, int64_t whole)
{
    return lw_fmi_type_of(reference) == LW_FMI_ENUMERATION ? whole + 1 : whole;
}

/* Converts an integer from the host's numbering to the machine's. */
static int64_t lw_fmi_from_host(uint32_t reference, int64_t shown)
{
    return lw_fmi_type_of(reference) == LW_FMI_ENUMERATION && shown > INT64_MIN ? shown - 1 : shown;
}

/* ---- States ---------------------------------------------------------------------------------- */

/* A saved state. A host can store its bytes in a file, so they contain the unit's token and a
 * checksum. */
typedef struct lw_fmi_saved {
    char token[sizeof LW_FMI_TOKEN];
    uint64_t size;
    uint64_t sum; /* checksum, computed with 0 in this field */
    lw_stored_state state;
    lw_fmi_unit unit;
} lw_fmi_saved;

/* Checksum of a saved state: FNV-1a over its bytes in memory. */
static uint64_t lw_fmi_sum(const lw_fmi_saved *saved)
{
    const unsigned char *bytes = (const unsigned char *)saved;
    size_t skipped = offsetof(lw_fmi_saved, sum);
    uint64_t sum = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < sizeof *saved; i++) {
        unsigned char byte = i >= skipped && i < skipped + sizeof saved->sum ? 0 : bytes[i];
        sum = (sum ^ byte) * UINT64_C(1099511628211);
    }
    return sum;
}

static int lw_fmi_is_saved(const lw_fmi_saved *saved)
{
    return memcmp(saved->token, LW_FMI_TOKEN, sizeof saved->token) == 0 && saved->size == sizeof *saved
           && saved->sum == lw_fmi_sum(saved);
}

/* Saves the state into `*place`, and overwrites a state that is already there. */
static void lw_fmi_get_state(lw_fmi_call *call, void **place)
{
    lw_fmi_saved *saved;
    if (place == NULL) {
        lw_fmi_refuse(call, "the pointer for the state is missing");
        return;
    }
    if (*place == NULL) {
        *place = malloc(sizeof *saved);
    }
    saved = *place;
    if (saved == NULL) {
        lw_fmi_refuse(call, "there is not enough memory for the state");
        return;
    }
    memset(saved, 0, sizeof *saved);
    memcpy(saved->token, LW_FMI_TOKEN, sizeof saved->token);
    saved->size = sizeof *saved;
    saved->state = call->slot->state;
    saved->unit = *call->unit;
    saved->sum = lw_fmi_sum(saved);
}

static void lw_fmi_set_state(lw_fmi_call *call, const void *state)
{
    const lw_fmi_saved *saved = state;
    if (saved == NULL || !lw_fmi_is_saved(saved)) {
        lw_fmi_refuse(call, "the state is damaged, or does not belong to this unit");
        return;
    }
    call->slot->state = saved->state;
    *call->unit = saved->unit;
}

static void lw_fmi_free_state(void **place)
{
    if (place != NULL) {
        free(*place);
        *place = NULL;
    }
}

static void lw_fmi_serialize(lw_fmi_call *call, const void *state, void *bytes, size_t size)
{
    const lw_fmi_saved *saved = state;
    if (saved == NULL || !lw_fmi_is_saved(saved)) {
        lw_fmi_refuse(call, "the state is damaged, or does not belong to this unit");
    } else if (bytes == NULL || size < sizeof *saved) {
        lw_fmi_refuse(call, "the buffer is missing, or too small for the state");
    } else {
        memcpy(bytes, saved, sizeof *saved);
    }
}

static void lw_fmi_deserialize(lw_fmi_call *call, const void *bytes, size_t size, void **place)
{
    lw_fmi_saved *saved;
    if (bytes == NULL || place == NULL || size != sizeof *saved) {
        lw_fmi_refuse(call, "the bytes are missing, or do not have the size of a state of this unit");
        return;
    }
    saved = malloc(sizeof *saved);
    if (saved == NULL) {
        lw_fmi_refuse(call, "there is not enough memory for the state");
        return;
    }
    memcpy(saved, bytes, sizeof *saved);
    if (lw_fmi_is_saved(saved)) {
        /* The previous value of the host's pointer is ignored, because the standard gives it no
         * meaning. */
        *place = saved;
    } else {
        free(saved);
        lw_fmi_refuse(call, "the bytes are damaged, or do not belong to this unit");
    }
}
