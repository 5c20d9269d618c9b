/* The Plant Simulation adapter: the exports that SimTalk's callLibrary calls.
 *
 * Each has the signature `void name(UF_Value *ret, UF_Value *arg)` (Spellini et al. 2021, Listing 1). No count of arguments
 * is passed, so the arity of every export is fixed, and the tag of each argument is checked. Only scalars pass: SimTalk
 * reads the part's attributes, calls `simulate` with them, and writes the results back. `uf_value.h` says what is assumed
 * of the structure.
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
        ret->type = LW_UF_TAG_INTEGER;
        ret->value.LW_UF_FIELD_INTEGER = (LW_UF_INTEGER)value;
    }
}

static void lw_give_real(UF_Value *ret, double value)
{
    if (ret != NULL) {
        ret->type = LW_UF_TAG_REAL;
        ret->value.LW_UF_FIELD_REAL = value;
    }
}

static void lw_give_string(UF_Value *ret, const char *value)
{
    if (ret != NULL) {
        ret->type = LW_UF_TAG_STRING;
        ret->value.LW_UF_FIELD_STRING = value;
    }
}

/* The handle of the first argument; 0 where its number cannot be one. */
static lw_handle lw_handle_of(const UF_Value *arg)
{
    int64_t number = (int64_t)arg[0].value.LW_UF_FIELD_INTEGER;
    return number > 0 && number <= INT32_MAX ? (lw_handle)number : 0;
}

/* The instance of the first argument, locked; or null and a code. */
static lw_slot *lw_enter_value(const UF_Value *arg, int32_t *code)
{
    lw_slot *slot;
    if (arg == NULL || arg[0].type != LW_UF_TAG_INTEGER) {
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

/* The operation of the second argument: its index, or a negative code. */
static int32_t lw_which_operation(const UF_Value *arg, lw_error *error)
{
    if (arg[1].type == LW_UF_TAG_INTEGER) {
        int64_t index = (int64_t)arg[1].value.LW_UF_FIELD_INTEGER;
        if (index >= 0 && index < LW_OPERATIONS) {
            return (int32_t)index;
        }
        lw_fail(error, LW_ERROR_OPERATION, "there is no operation ");
        lw_say_integer(error, index);
        return LW_ERROR_OPERATION;
    }
    if (arg[1].type == LW_UF_TAG_STRING && arg[1].value.LW_UF_FIELD_STRING != NULL) {
        for (int i = 0; i < LW_OPERATIONS; i++) {
            if (strcmp(arg[1].value.LW_UF_FIELD_STRING, lw_operation_table[i].name) == 0) {
                return i;
            }
        }
        return lw_fail_name(error, LW_ERROR_OPERATION, "there is no operation `", arg[1].value.LW_UF_FIELD_STRING, "`");
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
        const UF_Value *value = &arg[2 + i];
        if (value->type == LW_UF_TAG_REAL) {
            properties[i] = value->value.LW_UF_FIELD_REAL;
        } else if (value->type == LW_UF_TAG_INTEGER) {
            properties[i] = (double)value->value.LW_UF_FIELD_INTEGER;
        } else {
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
    const char *name;
    lw_slot *slot = lw_enter_value(arg, &code);
    if (slot == NULL) {
        lw_give_integer(ret, code);
        return;
    }
    name = arg[1].type == LW_UF_TAG_STRING ? arg[1].value.LW_UF_FIELD_STRING : NULL;
    if (name == NULL) {
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
    static char alone[LW_TEXT_SIZE];
    lw_slot *slot = NULL;
    if (arg != NULL && arg[0].type == LW_UF_TAG_INTEGER) {
        slot = lw_enter_quietly(lw_handle_of(arg));
    }
    if (slot != NULL) {
        memcpy(slot->shown, slot->error.text, sizeof slot->shown);
        lw_give_string(ret, slot->shown);
        lw_lock_give(&slot->lock);
    } else {
        lw_lock_take(&lw_table_lock);
        memcpy(alone, lw_table_error.text, sizeof alone);
        lw_give_string(ret, alone);
        lw_lock_give(&lw_table_lock);
    }
}

LW_EXPORT void station_describe(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
    lw_give_string(ret, lw_description);
}
