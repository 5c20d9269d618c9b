/* The Plant Simulation adapter: the exports that SimTalk's callLibrary calls.
 *
 * Each has the signature `void name(UF_Value *ret, UF_Value *arg)` (Spellini et al. 2021, Listing 1). No count of arguments
 * is passed, so the arity of every export is fixed, and the tag of each argument is checked. Only scalars pass: SimTalk
 * reads the part's attributes, calls `simulate` with them, and writes the results back. The layout of the structure is
 * that of a profile: `uf_value.h`.
 *
 *     instantiate()                          integer: a handle above 0, or a negative code
 *     simulate(handle, operation, values...) real: the duration in seconds, 0 or more; or a negative code. `operation` is an
 *                                            index from 0 or a name; `values` are all of the machine's properties in the
 *                                            order of `station_describe`, real or integer
 *     get_real(handle, name)                 real: a result of the last operation that ended: "seconds", "joules", "steps",
 *                                            or a property by its name ("property.steps" where the names clash);
 *                                            integer: a negative code
 *     reset(handle)                          integer: 0 or a negative code
 *     deinstantiate(handle)                  integer: 0 or a negative code
 *     last_error(handle)                     string: the instance's last error; for a handle that is not valid (0, say) that
 *                                            of the library. It stays as it is until the next call of last_error
 *     station_describe()                     string: static JSON
 *
 * The codes are those of station.h. Listing 2 of the paper loads and frees the library at every entry, which loses all
 * state: load it once, when the model starts, and make one instance for each station. */
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

/* Whether the first argument can be a handle. Where integers are too narrow for one, it comes as a real number. */
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
        *code = lw_fail_alone(LW_ERROR_ARGUMENT, "the handle must be an integer");
        return NULL;
    }
    slot = lw_enter(lw_handle_of(arg));
    *code = slot == NULL ? LW_ERROR_HANDLE : LW_OK;
    return slot;
}

LW_EXPORT void instantiate(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
    lw_give_integer(ret, lw_create());
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
        lw_fail(error, LW_ERROR_OPERATION, "there is no operation ");
        lw_say_integer(error, index);
        return LW_ERROR_OPERATION;
    }
    if (lw_text_of(arg, name)) {
        for (int i = 0; i < LW_OPERATIONS; i++) {
            if (strcmp(name, lw_operation_table[i].name) == 0) {
                return i;
            }
        }
        return lw_fail_name(error, LW_ERROR_OPERATION, "there is no operation `", name, "`");
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
    lw_give_real(ret, code == LW_OK ? slot->service.seconds : (double)code);
    lw_lock_give(&slot->lock);
}

LW_EXPORT void get_real(UF_Value *ret, UF_Value *arg)
{
    int32_t code;
    double value = 0.0;
    char name[LW_TEXT_SIZE];
    lw_slot *slot = lw_enter_value(arg, &code);
    if (slot == NULL) {
        lw_give_integer(ret, code);
        return;
    }
    if (!lw_text_of(arg, name)) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT, "the name must be a string");
    } else if (!slot->ended) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT, "no operation has ended yet");
    } else if (strcmp(name, "seconds") == 0) {
        value = slot->service.seconds;
    } else if (strcmp(name, "joules") == 0) {
        value = slot->service.joules;
    } else if (strcmp(name, "steps") == 0) {
        value = (double)slot->service.steps;
    } else {
        int i = 0;
        const char *property = strncmp(name, "property.", 9) == 0 ? name + 9 : name;
        while (i < LW_PROPERTIES && strcmp(property, lw_property_names[i]) != 0) {
            i++;
        }
        if (i == LW_PROPERTIES) {
            code = lw_fail_name(&slot->error, LW_ERROR_ARGUMENT, "there is no result `", name, "`");
        } else {
            value = slot->properties[i];
        }
    }
    if (code == LW_OK) {
        lw_give_real(ret, value);
    } else {
        lw_give_integer(ret, code);
    }
    lw_lock_give(&slot->lock);
}

LW_EXPORT void last_error(UF_Value *ret, UF_Value *arg)
{
    /* The text shown is a copy, which later errors leave alone: who owns a returned string is not known. */
    static lw_uf_unit alone[LW_TEXT_SIZE];
    lw_slot *slot = NULL;
    if (lw_is_handle(arg)) {
        slot = lw_enter_quietly(lw_handle_of(arg));
    }
    if (slot != NULL) {
        lw_uf_encode(slot->error.text, alone, LW_TEXT_SIZE);
        lw_give_string(ret, alone);
        lw_lock_give(&slot->lock);
    } else {
        lw_lock_take(&lw_table_lock);
        lw_uf_encode(lw_table_error.text, alone, LW_TEXT_SIZE);
        lw_give_string(ret, alone);
        lw_lock_give(&lw_table_lock);
    }
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
