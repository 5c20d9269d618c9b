/* The Plant Simulation adapter: the exports that SimTalk's callLibrary calls.
 *
 * Each has the signature `void name(UF_Value *ret, UF_Value *arg)` (Spellini et al. 2021, Listing
 * 1). No count of arguments is passed, so the arity of every export is fixed, and the tag of each
 * argument is checked. Only scalars pass: SimTalk reads the part's attributes, calls `simulate`
 * with them, and writes the results back. The layout of the structure is that of a profile:
 * `uf_value.h`.
 *
 *     instantiate()                          integer: a handle above 0, or a negative code
 *     simulate(handle, operation, values...) real: the duration in seconds, 0 or more; or a negative code. `operation` is an
 *                                            index from 0 or a name; `values` are all of the machine's properties in the
 *                                            order of `station_describe`, real or integer
 *     get_real(handle, name)                 real: a result as a number; integer: a negative code
 *     get_integer(handle, name)              integer: a result that is a whole number, or a negative code. Where results are below
 *                                            0 themselves, get_real tells the two apart
 *     get_string(handle, name)               string: a result in words; integer: a negative code
 *
 *         "verdict"          0 or the code of the last operation; in words `ok`, or what was wrong (`assumption`)
 *         "rule"             in words only: the rule that was broken, `turn_a: gripped`
 *         "time", "energy"   of the last operation that ended, in s and J; "seconds" and "joules" are the same
 *         "steps"            of its controller
 *         a property's name  after that operation; "property.steps" where names clash. In words: its label
 *         "output.NAME"      an output or internal variable after the last step, `output.turn_a.angle`
 *
 *     reset(handle)                          integer: 0 or a negative code
 *     deinstantiate(handle)                  integer: 0 or a negative code
 *     last_error(handle)                     string: the instance's last error; for a handle that is not valid (0, say) that
 *                                            of the library
 *     station_describe()                     string: static JSON
 *
 * A string that is returned belongs to the library, since who owns it and when it is copied is not
 * known of the host. Each instance has room for one, which stays as it is until the next string
 * that is returned for that instance. Several threads that read texts of one instance use
 * lw_last_error, which copies. What is returned without a valid handle never changes, so that
 * threads may read it as they like.
 *
 * The codes are those of station.h. Listing 2 of the paper loads and frees the library at every
 * entry, which loses all state: load it once, when the model starts, and make one instance for each
 * station. */
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

/* `value` is in the profile's encoding. */
static void lw_give_string(UF_Value *ret, const void *value)
{
    if (ret != NULL) {
        lw_uf_set_pointer(ret, value);
    }
}

/* Whether the first argument can be a handle. Where integers are too narrow for one, it comes as a
 * real number. */
static int lw_is_handle(const UF_Value *arg)
{
    enum lw_uf_kind kind = arg == NULL ? LW_UF_OTHER : lw_uf_kind_of(&arg[0]);
    return kind == LW_UF_IS_INTEGER || (kind == LW_UF_IS_REAL && sizeof(LW_UF_INTEGER) < sizeof(lw_handle));
}

/* The handle of the first argument; 0 where its number cannot be one. */
static lw_handle lw_handle_of(const UF_Value *arg)
{
    double number = 0.0;
    (void)lw_uf_number_of(&arg[0], &number);
    return number > 0.0 && number <= (double)INT32_MAX ? (lw_handle)number : 0;
}

/* The instance of the first argument, locked; or null and a code. */
static lw_slot *lw_enter_value(const UF_Value *arg, int32_t *code)
{
    lw_slot *slot;
    if (!lw_is_handle(arg)) {
        *code = lw_fail_alone(LW_ERROR_ARGUMENT, LW_ALONE_KIND);
        return NULL;
    }
    slot = lw_enter(lw_handle_of(arg));
    *code = slot == NULL ? LW_ERROR_HANDLE : LW_OK;
    return slot;
}

LW_EXPORT void instantiate(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
    /* An instance whose handle nobody gets could never be ended. */
    if (ret != NULL) {
        lw_give_integer(ret, lw_create());
    }
}

LW_EXPORT void deinstantiate(UF_Value *ret, UF_Value *arg)
{
    int32_t code;
    lw_slot *slot = lw_enter_value(arg, &code);
    if (slot != NULL) {
        lw_lock_give(&slot->lock);
        code = lw_destroy(lw_handle_of(arg));
    }
    lw_give_integer(ret, code);
}

LW_EXPORT void reset(UF_Value *ret, UF_Value *arg)
{
    int32_t code;
    lw_slot *slot = lw_enter_value(arg, &code);
    if (slot != NULL) {
        memset(&slot->state, 0, sizeof slot->state);
        lw_lock_give(&slot->lock);
    }
    lw_give_integer(ret, code);
}

/* The text that was last shown for each instance, in the host's encoding. */
#define LW_SHOWN_SIZE 512
static lw_uf_unit lw_shown[LW_SLOTS][LW_SHOWN_SIZE];

/* Shows a text, cut where it is too long, for an instance. The caller holds its lock. */
static void lw_show(UF_Value *ret, const lw_slot *slot, const char *text)
{
    lw_uf_unit *place = lw_shown[slot - lw_slots];
    lw_uf_encode(text, place, LW_SHOWN_SIZE);
    lw_give_string(ret, place);
}

/* The texts about calls without an instance. Each is written once, before it is first shown. */
static lw_uf_unit lw_shown_alone[LW_ALONE_COUNT][LW_SHOWN_SIZE];

/* Shows the last of them. The caller holds the table's lock. */
static void lw_show_alone(UF_Value *ret)
{
    lw_uf_unit *place = lw_shown_alone[lw_last_alone];
    if (place[0] == 0 && lw_last_alone != LW_ALONE_FINE) {
        lw_uf_encode(lw_alone_texts[lw_last_alone], place, LW_SHOWN_SIZE);
    }
    lw_give_string(ret, place);
}

/* The text of the second argument, as UTF-8; 0 where it is none. */
static int lw_text_of(const UF_Value *arg, char *text)
{
    const void *pointer = lw_uf_kind_of(&arg[1]) == LW_UF_IS_STRING ? lw_uf_pointer_of(&arg[1]) : NULL;
    if (pointer != NULL) {
        /* One that is cut off is too long for any name. */
        (void)lw_uf_decode(pointer, text, LW_TEXT_SIZE);
    }
    return pointer != NULL;
}

/* The operation of the second argument: its index, or a negative code. */
static int32_t lw_which_operation(const UF_Value *arg, lw_error *error)
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
        lw_say_name(error, name);
        lw_say(error, "`");
        return LW_ERROR_OPERATION;
    }
    return lw_fail(error, LW_ERROR_ARGUMENT, "the operation must be an integer or a string");
}

LW_EXPORT void simulate(UF_Value *ret, UF_Value *arg)
{
    double properties[LW_PROPERTIES + 1];
    int32_t operation;
    int32_t code;
    lw_slot *slot = lw_enter_value(arg, &code);
    if (slot == NULL) {
        lw_give_real(ret, (double)code);
        return;
    }
    operation = lw_which_operation(arg, &slot->error);
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

/* A result: its value, and what it is in words where that is more than a number. */
typedef struct lw_result {
    double value;
    int whole;         /* a whole number of an int64_t, which is in `number` */
    int64_t number;
    const char *words; /* or null */
} lw_result;

static const char *lw_label(const char *const *labels, int64_t number)
{
    return labels == NULL ? NULL : labels[number];
}

static lw_result lw_whole(int64_t number, const char *words)
{
    lw_result result;
    result.value = (double)number;
    result.whole = 1;
    result.number = number;
    result.words = words;
    return result;
}

static lw_result lw_measured(double value)
{
    lw_result result = {0.0, 0, 0, NULL};
    result.value = value;
    return result;
}

static const char *lw_verdict_words(int32_t verdict)
{
    static const char *const words[] = {"ok", "handle", "argument", "domain", "operation", "assumption", "guarantee", "limit", "memory",
                                        "internal", "order"};
    return verdict <= 0 && verdict >= LW_ERROR_ORDER ? words[-verdict] : "internal";
}

/* The result of a name. */
static int32_t lw_find_result(lw_slot *slot, const char *name, lw_result *result)
{
    const char *property = strncmp(name, "property.", 9) == 0 ? name + 9 : name;
    if (strcmp(name, "verdict") == 0) {
        *result = lw_whole(slot->verdict, lw_verdict_words(slot->verdict));
        return LW_OK;
    }
    if (strcmp(name, "rule") == 0) {
        const char *rule = slot->verdict == LW_OK ? NULL : slot->error.rule;
        *result = lw_whole(0, rule == NULL ? "" : rule);
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
                *result = lw_whole(number, lw_label(output->labels, number));
                return LW_OK;
            }
        }
    }
    if (!slot->ended) {
        return lw_fail(&slot->error, LW_ERROR_ARGUMENT, "no operation has ended yet");
    }
    if (strcmp(name, "time") == 0 || strcmp(name, "seconds") == 0) {
        *result = lw_measured(slot->service.seconds);
        return LW_OK;
    }
    if (strcmp(name, "energy") == 0 || strcmp(name, "joules") == 0) {
        *result = lw_measured(slot->service.joules);
        return LW_OK;
    }
    if (strcmp(name, "steps") == 0) {
        *result = lw_whole(slot->service.steps, NULL);
        return LW_OK;
    }
    for (int i = 0; i < LW_PROPERTIES; i++) {
        if (strcmp(property, lw_property_names[i]) == 0) {
            const lw_range *range = &lw_property_ranges[i];
            double value = slot->properties[i];
            /* A property that no operation wrote is what the host gave, in its range or not. */
            int inside = range->whole && value >= range->low && value <= range->high && floor(value) <= value
                         && floor(value) >= value;
            *result = inside ? lw_whole((int64_t)value, lw_label(range->labels, (int64_t)value)) : lw_measured(value);
            /* A zero keeps its sign. */
            result->value = value;
            return LW_OK;
        }
    }
    lw_fail(&slot->error, LW_ERROR_ARGUMENT, "there is no result `");
    lw_say_name(&slot->error, name);
    lw_say(&slot->error, "`");
    return LW_ERROR_ARGUMENT;
}

/* The result that the two arguments of a getter ask for; its instance, locked, or null. */
static lw_slot *lw_get(const UF_Value *arg, lw_result *result, int32_t *code)
{
    char name[LW_TEXT_SIZE];
    lw_slot *slot = lw_enter_value(arg, code);
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
    lw_slot *slot = lw_get(arg, &result, &code);
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
    lw_slot *slot = lw_get(arg, &result, &code);
    if (code == LW_OK && !result.whole) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT, "the result is not a whole number: ask get_real for it");
    } else if (code == LW_OK && (result.number < INT32_MIN || result.number > INT32_MAX)) {
        code = lw_fail(&slot->error, LW_ERROR_DOMAIN, "the result does not fit 32 bits: ask get_real for it");
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
    lw_slot *slot = lw_get(arg, &result, &code);
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
    lw_slot *slot = lw_is_handle(arg) ? lw_enter_quietly(lw_handle_of(arg)) : NULL;
    if (slot == NULL) {
        lw_lock_take(&lw_table_lock);
        lw_show_alone(ret);
        lw_lock_give(&lw_table_lock);
        return;
    }
    lw_put_into_words(&slot->error, &text);
    lw_show(ret, slot, text.text);
    lw_lock_give(&slot->lock);
}

LW_EXPORT void station_describe(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
#if LW_UF_ENCODING == LW_UF_UTF_8
    lw_give_string(ret, lw_description);
#else
    /* No encoding has more units than UTF-8. */
    static lw_uf_unit description[sizeof lw_description];
    lw_lock_take(&lw_table_lock);
    if (description[0] == 0) {
        lw_uf_encode(lw_description, description, sizeof lw_description);
    }
    lw_lock_give(&lw_table_lock);
    lw_give_string(ret, description);
#endif
}
