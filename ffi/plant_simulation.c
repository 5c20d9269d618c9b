/* The Plant Simulation adapter: the exports that SimTalk's callLibrary calls.
 *
 * Each export has the signature `void name(UF_Value *ret, UF_Value *arg)` (Spellini et al. 2021,
 * Listing 1). The host does not pass the number of arguments, so every export has a fixed number of
 * arguments and checks the tag of each one. Arguments and results are scalars: SimTalk reads the
 * part's attributes, calls `simulate` with them, and writes the results back. A profile defines the
 * layout of the structure: see `uf_value.h`.
 *
 *     instantiate()                          integer: a handle above 0, or a negative code
 *     simulate(handle, operation, values...) real: the duration in seconds, 0 or more; or a negative code. `operation` is an
 *                                            index from 0 or a name; `values` are all of the machine's properties in the
 *                                            order of `station_describe`, real or integer
 *     get_real(handle, name)                 real: a result as a number; integer: a negative code
 *     get_integer(handle, name)              integer: an integer result, or a negative code. If a result itself can be negative,
 *                                            use get_real to distinguish it from a code
 *     get_string(handle, name)               string: a result as text; integer: a negative code
 *
 *         "verdict"          0 or the error code of the last operation; as text `ok`, or the kind of error (`assumption`)
 *         "rule"             text only: the name of the broken rule, `turn_a: gripped`
 *         "time", "energy"   duration in s and energy in J of the last completed operation; also "seconds" and "joules"
 *         "steps"            number of its controller steps
 *         "control_time"     the part of its duration in which no action was active, in s
 *         a property's name  value after that operation; "property.steps" if names clash. As text: its label
 *         "output.NAME"      an output or internal variable after the last step, `output.turn_a.angle`
 *
 *     reset(handle)                          integer: 0 or a negative code
 *     deinstantiate(handle)                  integer: 0 or a negative code
 *     last_error(handle)                     string: the instance's last error; for an invalid handle such as 0, the last
 *                                            error of the library
 *     station_describe()                     string: static JSON
 *
 * The library owns every string that it returns, because it is unknown whether and when the host
 * copies strings. Each instance has one string buffer, whose content stays valid until the next
 * string is returned for that instance. If several threads read texts of one instance, they must
 * use lw_last_error, which copies the text. Strings that are returned without a valid handle never
 * change, so any thread can read them at any time.
 *
 * The codes are those of station.h. Listing 2 of the paper loads and frees the library at every
 * entry, which loses all state: load it once, when the model starts, and create one instance for
 * each station. */
#include "uf_value.h"

static void lw_give_integer(UF_Value *ret, int32_t value)
{
    if (ret != NULL) {
        lw_uf_give_integer(ret, value);
    }
}

static void lw_give_real(UF_Value *ret, double value)
{
    if (ret != NULL) {
        lw_uf_set_real(ret, value);
    }
}

/* Returns a string; `value` is in the profile's encoding. */
static void lw_give_string(UF_Value *ret, const void *value)
{
    if (ret != NULL) {
        lw_uf_set_pointer(ret, value);
    }
}

/* Whether the first argument can be a handle: an integer, or a real number if the profile's
 * integers are too narrow for a handle. */
static int lw_is_handle(const UF_Value *arg)
{
    enum lw_uf_kind kind = arg == NULL ? LW_UF_OTHER : lw_uf_kind_of(&arg[0]);
    return kind == LW_UF_IS_INTEGER || (kind == LW_UF_IS_REAL && sizeof(LW_UF_INTEGER) < sizeof(lw_handle));
}

/* Returns the handle in the first argument; 0 if the number is out of range. */
static lw_handle lw_handle_of(const UF_Value *arg)
{
    double number = 0.0;
    (void)lw_uf_number_of(&arg[0], &number);
    return number > 0.0 && number <= (double)INT32_MAX ? (lw_handle)number : 0;
}

/* Locks and returns the instance of the first argument; null and an error code if there is none. */
static lw_slot *lw_instance_argument(const UF_Value *arg, int32_t *code)
{
    lw_slot *slot;
    if (!lw_is_handle(arg)) {
        *code = lw_fail_library(LW_ERROR_ARGUMENT, LW_LIBRARY_ARGUMENT);
        return NULL;
    }
    slot = lw_require_instance(lw_handle_of(arg));
    *code = slot == NULL ? LW_ERROR_HANDLE : LW_OK;
    return slot;
}

LW_EXPORT void instantiate(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
    /* No instance is created without a place for its handle, because it could never be
     * destroyed. */
    if (ret != NULL) {
        lw_give_integer(ret, lw_create());
    }
}

LW_EXPORT void deinstantiate(UF_Value *ret, UF_Value *arg)
{
    int32_t code;
    lw_slot *slot = lw_instance_argument(arg, &code);
    if (slot != NULL) {
        lw_lock_give(&slot->lock);
        code = lw_destroy(lw_handle_of(arg));
    }
    lw_give_integer(ret, code);
}

LW_EXPORT void reset(UF_Value *ret, UF_Value *arg)
{
    int32_t code;
    lw_slot *slot = lw_instance_argument(arg, &code);
    if (slot != NULL) {
        memset(&slot->state, 0, sizeof slot->state);
        lw_lock_give(&slot->lock);
    }
    lw_give_integer(ret, code);
}

/* The last string that was returned for each instance, in the host's encoding. */
#define LW_SHOWN_SIZE 512
static lw_uf_unit lw_shown[LW_SLOTS][LW_SHOWN_SIZE];

/* Returns a string for an instance, cut if it is too long. The caller holds the instance's lock. */
static void lw_show(UF_Value *ret, const lw_slot *slot, const char *text)
{
    lw_uf_unit *place = lw_shown[slot - lw_slots];
    lw_uf_encode(text, place, LW_SHOWN_SIZE);
    lw_give_string(ret, place);
}

/* The texts about calls without a valid handle. Each is encoded once, before it is first
 * returned. */
static lw_uf_unit lw_shown_library[LW_LIBRARY_ERRORS][LW_SHOWN_SIZE];

/* Returns the text about the last call without a valid handle. The caller holds the table's
 * lock. */
static void lw_show_library(UF_Value *ret)
{
    lw_uf_unit *place = lw_shown_library[lw_last_library_error];
    if (place[0] == 0 && lw_last_library_error != LW_LIBRARY_OK) {
        lw_uf_encode(lw_library_texts[lw_last_library_error], place, LW_SHOWN_SIZE);
    }
    lw_give_string(ret, place);
}

/* Reads the string in the second argument as UTF-8. Returns 0 if the argument is not a string. */
static int lw_text_of(const UF_Value *arg, char *text)
{
    const void *pointer = lw_uf_kind_of(&arg[1]) == LW_UF_IS_STRING ? lw_uf_pointer_of(&arg[1]) : NULL;
    if (pointer != NULL) {
        /* A string that has to be cut is longer than any name, so it matches none. */
        (void)lw_uf_decode(pointer, text, LW_TEXT_SIZE);
    }
    return pointer != NULL;
}

/* Returns the index of the operation in the second argument, or a negative code. */
static int32_t lw_operation_of(const UF_Value *arg, lw_error *error)
{
    char name[LW_TEXT_SIZE];
    if (lw_uf_kind_of(&arg[1]) == LW_UF_IS_INTEGER) {
        int64_t index = lw_uf_integer_of(&arg[1]);
        if (index >= 0 && index < LW_OPERATIONS) {
            return (int32_t)index;
        }
        return lw_fail_operation(error, index);
    }
    if (lw_text_of(arg, name)) {
        for (int i = 0; i < LW_OPERATIONS; i++) {
            if (strcmp(name, lw_operation_table[i].name) == 0) {
                return i;
            }
        }
        lw_fail(error, LW_ERROR_OPERATION, "there is no operation `");
        lw_append_name(error, name);
        lw_append(error, "`");
        return LW_ERROR_OPERATION;
    }
    return lw_fail(error, LW_ERROR_ARGUMENT, "the operation must be an integer or a string");
}

LW_EXPORT void simulate(UF_Value *ret, UF_Value *arg)
{
    double properties[LW_PROPERTIES + 1];
    int32_t operation;
    int32_t code;
    lw_slot *slot = lw_instance_argument(arg, &code);
    if (slot == NULL) {
        lw_give_real(ret, (double)code);
        return;
    }
    operation = lw_operation_of(arg, &slot->error);
    code = operation < 0 ? operation : LW_OK;
    for (int i = 0; i < LW_PROPERTIES && code == LW_OK; i++) {
        if (!lw_uf_number_of(&arg[2 + i], &properties[i])) {
            code = lw_fail_name(&slot->error, LW_ERROR_ARGUMENT, "property `", lw_property_names[i],
                                "` must be a real number or an integer");
        }
    }
    if (code == LW_OK) {
        code = lw_serve(slot, operation, properties);
    }
    slot->verdict = code;
    lw_give_real(ret, code == LW_OK ? slot->service.seconds : (double)code);
    lw_lock_give(&slot->lock);
}

/* A result as a number, and also as a text if the text is not just that number. */
typedef struct lw_result {
    double value;
    int whole;         /* whether it is an integer: then `number` holds it */
    int64_t number;
    const char *words; /* the text, or null */
} lw_result;

static const char *lw_label(const char *const *labels, int64_t number)
{
    return labels == NULL ? NULL : labels[number];
}

static lw_result lw_integer_result(int64_t number, const char *words)
{
    lw_result result;
    result.value = (double)number;
    result.whole = 1;
    result.number = number;
    result.words = words;
    return result;
}

static lw_result lw_real_result(double value)
{
    lw_result result = {0.0, 0, 0, NULL};
    result.value = value;
    return result;
}

static const char *lw_code_name(int32_t verdict)
{
    static const char *const words[] = {"ok", "handle", "argument", "domain", "operation", "assumption", "guarantee", "limit", "memory",
                                        "internal", "order"};
    return verdict <= 0 && verdict >= LW_ERROR_ORDER ? words[-verdict] : "internal";
}

/* Finds the result with this name. */
static int32_t lw_find_result(lw_slot *slot, const char *name, lw_result *result)
{
    const char *property = strncmp(name, "property.", 9) == 0 ? name + 9 : name;
    if (strcmp(name, "verdict") == 0) {
        *result = lw_integer_result(slot->verdict, lw_code_name(slot->verdict));
        return LW_OK;
    }
    if (strcmp(name, "rule") == 0) {
        const char *rule = slot->verdict == LW_OK ? NULL : slot->error.rule;
        *result = lw_integer_result(0, rule == NULL ? "" : rule);
        return LW_OK;
    }
    if (strncmp(name, "output.", 7) == 0) {
        for (int i = 0; i < LW_OUTPUTS; i++) {
            const lw_wire *output = &lw_output_table[i];
            if (strcmp(name + 7, output->name) == 0) {
                int64_t number = slot->state.values[output->value];
                if (!slot->state.started) {
                    return lw_fail(&slot->error, LW_ERROR_ARGUMENT, "no step has been made yet");
                }
                *result = lw_integer_result(number, lw_label(output->labels, number));
                return LW_OK;
            }
        }
    }
    if (!slot->has_results) {
        return lw_fail(&slot->error, LW_ERROR_ARGUMENT, "no operation has ended yet");
    }
    if (strcmp(name, "time") == 0 || strcmp(name, "seconds") == 0) {
        *result = lw_real_result(slot->service.seconds);
        return LW_OK;
    }
    if (strcmp(name, "energy") == 0 || strcmp(name, "joules") == 0) {
        *result = lw_real_result(slot->service.joules);
        return LW_OK;
    }
    if (strcmp(name, "control_time") == 0) {
        *result = lw_real_result(slot->control);
        return LW_OK;
    }
    if (strcmp(name, "steps") == 0) {
        *result = lw_integer_result(slot->service.steps, NULL);
        return LW_OK;
    }
    for (int i = 0; i < LW_PROPERTIES; i++) {
        if (strcmp(property, lw_property_names[i]) == 0) {
            const lw_range *range = &lw_property_ranges[i];
            double value = slot->properties[i];
            /* The host's value of a property that no operation wrote can be outside its range. */
            int inside = range->whole && value >= range->low && value <= range->high && floor(value) <= value
                         && floor(value) >= value;
            *result = inside ? lw_integer_result((int64_t)value, lw_label(range->labels, (int64_t)value)) : lw_real_result(value);
            /* Keep the sign of a zero. */
            result->value = value;
            return LW_OK;
        }
    }
    lw_fail(&slot->error, LW_ERROR_ARGUMENT, "there is no result `");
    lw_append_name(&slot->error, name);
    lw_append(&slot->error, "`");
    return LW_ERROR_ARGUMENT;
}

/* Finds the result that the two arguments of a getter name. Locks and returns the instance; null if
 * there is none. */
static lw_slot *lw_get_result(const UF_Value *arg, lw_result *result, int32_t *code)
{
    char name[LW_TEXT_SIZE];
    lw_slot *slot = lw_instance_argument(arg, code);
    if (slot == NULL) {
        return NULL;
    }
    if (lw_text_of(arg, name)) {
        *code = lw_find_result(slot, name, result);
    } else {
        *code = lw_fail(&slot->error, LW_ERROR_ARGUMENT, "the name must be a string");
    }
    return slot;
}

LW_EXPORT void get_real(UF_Value *ret, UF_Value *arg)
{
    lw_result result;
    int32_t code;
    lw_slot *slot = lw_get_result(arg, &result, &code);
    if (code == LW_OK) {
        lw_give_real(ret, result.value);
    } else {
        lw_give_integer(ret, code);
    }
    if (slot != NULL) {
        lw_lock_give(&slot->lock);
    }
}

LW_EXPORT void get_integer(UF_Value *ret, UF_Value *arg)
{
    lw_result result;
    int32_t code;
    lw_slot *slot = lw_get_result(arg, &result, &code);
    if (code == LW_OK && !result.whole) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT, "the result is not an integer: use get_real");
    } else if (code == LW_OK && (result.number < INT32_MIN || result.number > INT32_MAX)) {
        code = lw_fail(&slot->error, LW_ERROR_DOMAIN, "the result does not fit into 32 bits: use get_real");
    }
    lw_give_integer(ret, code == LW_OK ? (int32_t)result.number : code);
    if (slot != NULL) {
        lw_lock_give(&slot->lock);
    }
}

LW_EXPORT void get_string(UF_Value *ret, UF_Value *arg)
{
    lw_result result;
    lw_text text;
    int32_t code;
    lw_slot *slot = lw_get_result(arg, &result, &code);
    if (code == LW_OK) {
        text.length = 0;
        text.text[0] = '\0';
        if (result.words != NULL) {
            lw_write(&text, result.words);
        } else if (result.whole) {
            lw_write_integer(&text, result.number);
        } else {
            lw_write_real(&text, result.value);
        }
    }
    if (code == LW_OK) {
        lw_show(ret, slot, text.text);
    } else {
        lw_give_integer(ret, code);
    }
    if (slot != NULL) {
        lw_lock_give(&slot->lock);
    }
}

LW_EXPORT void last_error(UF_Value *ret, UF_Value *arg)
{
    lw_text text;
    lw_slot *slot = lw_is_handle(arg) ? lw_lock_instance(lw_handle_of(arg)) : NULL;
    if (slot == NULL) {
        lw_lock_take(&lw_table_lock);
        lw_show_library(ret);
        lw_lock_give(&lw_table_lock);
        return;
    }
    lw_format_error(&slot->error, &text);
    lw_show(ret, slot, text.text);
    lw_lock_give(&slot->lock);
}

LW_EXPORT void station_describe(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
#if LW_UF_ENCODING == LW_UF_UTF_8
    lw_give_string(ret, lw_description);
#else
    /* No encoding has more units than UTF-8, so this buffer is large enough. */
    static lw_uf_unit description[sizeof lw_description];
    lw_lock_take(&lw_table_lock);
    if (description[0] == 0) {
        lw_uf_encode(lw_description, description, sizeof lw_description);
    }
    lw_lock_give(&lw_table_lock);
    lw_give_string(ret, description);
#endif
}
