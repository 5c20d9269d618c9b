/* One line of the plan on an instance, and what the machine in the tests' own process answered to it. */
#include "host.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* As large as any text of a library. */
#define TEXT_ROOM 4096

/* What a library leaves alone when it refuses a call. */
#define UNTOUCHED INT64_C(-6148914691236517206)

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void same_real(double expected, double seen, int number, const char *what)
{
    if (bits_of(expected) != bits_of(seen)) {
        fail("line %d of the plan, %s: expected %.17g, saw %.17g", number, what, expected, seen);
    }
}

/* The text and the rule of a refused call. A text of more than 1023 bytes is cut there, or before the character that is there. */
static void check_error(const library *lib, lw_handle handle, const line *line, int32_t seen)
{
    char text[TEXT_ROOM];
    char rule[TEXT_ROOM];
    int32_t length = lib->last_error(handle, text, sizeof text);
    lib->last_rule(handle, rule, sizeof rule);
    if (seen != line->code) {
        fail("line %d of the plan: expected code %d (%s), saw %d (%s)", line->number, (int)line->code, line->text, (int)seen,
             seen < 0 ? text : "success");
    }
    if (strcmp(rule, line->rule) != 0) {
        fail("line %d of the plan: expected the rule `%s`, saw `%s`", line->number, line->rule, rule);
    }
    if ((size_t)length != strlen(text)) {
        fail("line %d of the plan: expected a length of %d, saw %d", line->number, (int)strlen(text), (int)length);
    }
    size_t kept = strlen(line->text);
    if (kept > 1023) {
        kept = 1023;
        while (kept > 0 && ((unsigned char)line->text[kept] & 0xC0U) == 0x80U) {
            kept--;
        }
    }
    if ((size_t)length != kept || strncmp(text, line->text, kept) != 0) {
        fail("line %d of the plan: expected the text `%s`, saw `%s`", line->number, line->text, text);
    }
}

static void unexpected(const library *lib, lw_handle handle, const line *line, int32_t seen)
{
    char text[TEXT_ROOM];
    lib->last_error(handle, text, sizeof text);
    fail("line %d of the plan: expected success, saw code %d: %s", line->number, (int)seen, text);
}

static int replay_step(const library *lib, lw_handle handle, const line *line)
{
    int64_t outputs[MOST_VALUES];
    /* As large as it has to be and no larger: the address sanitizer sees it when more is read. */
    int64_t plant[the_plan.plant > 0 ? the_plan.plant : 1];
    size_t count = (size_t)the_plan.outputs;
    const int64_t *expected = the_plan.integers + line->got;
    int32_t code;
    for (int32_t i = 0; i < the_plan.plant; i++) {
        plant[i] = the_plan.integers[line->given + (size_t)i];
    }
    for (size_t i = 0; i < count + 1; i++) {
        outputs[i] = UNTOUCHED;
    }
    code = lib->step(handle, plant, (size_t)the_plan.plant, outputs, count);
    if (line->code != LW_OK) {
        check_error(lib, handle, line, code);
        for (size_t i = 0; i < count; i++) {
            if (outputs[i] != UNTOUCHED) {
                fail("line %d of the plan: output %d was written although the step was refused", line->number, (int)i);
            }
        }
        return 3;
    }
    if (code != LW_OK) {
        unexpected(lib, handle, line, code);
    }
    for (size_t i = 0; i < count; i++) {
        if (outputs[i] != expected[i]) {
            fail("line %d of the plan, output `%s`: expected %" PRId64 ", saw %" PRId64, line->number,
                 the_plan.output_ports[i].name, expected[i], outputs[i]);
        }
    }
    if (outputs[count] != UNTOUCHED) {
        fail("line %d of the plan: more outputs were written than there are", line->number);
    }
    return 1;
}

static int replay_plain(const library *lib, lw_handle handle, const line *line)
{
    double properties[the_plan.properties > 0 ? the_plan.properties : 1];
    lw_service service = {-1.0, -2.0, -3};
    size_t count = (size_t)the_plan.properties;
    const double *given = the_plan.reals + line->given;
    const double *expected = line->code == LW_OK ? the_plan.reals + line->got : given;
    const lw_service untouched = service;
    const lw_service *taken = line->code == LW_OK ? &line->service : &untouched;
    int32_t code;
    for (size_t i = 0; i < count; i++) {
        properties[i] = given[i];
    }
    code = lib->simulate(handle, line->operation, properties, count, &service);
    if (line->code != LW_OK) {
        check_error(lib, handle, line, code);
    } else if (code != LW_OK) {
        unexpected(lib, handle, line, code);
    }
    for (size_t i = 0; i < count; i++) {
        same_real(expected[i], properties[i], line->number, the_plan.property_ports[i].name);
    }
    same_real(taken->seconds, service.seconds, line->number, "the duration");
    same_real(taken->joules, service.joules, line->number, "the energy");
    same(taken->steps, service.steps, "the steps of an operation");
    return line->code == LW_OK ? 1 : 3;
}

/* ---- Results by name --------------------------------------------------------------------------------------------- */

static const char *const VERDICTS[] = {"ok",        "handle", "argument", "domain",  "operation", "assumption",
                                       "guarantee", "limit",  "memory",   "internal"};

static void set_name(UF_Value *arg, lw_handle handle, const char *name)
{
    arg[0] = value_integer(handle);
    arg[1] = value_string(name);
}

static void check_real(const library *lib, lw_handle handle, const line *line, const char *name, double expected)
{
    UF_Value arg[2];
    set_name(arg, handle, name);
    same_real(expected, call_real(lib->get_real_value, arg, "get_real"), line->number, name);
}

static void check_words(const library *lib, lw_handle handle, const line *line, way way, const char *name, const char *expected)
{
    UF_Value arg[2];
    const char *seen;
    if (way != WAY_VALUES) {
        return;
    }
    set_name(arg, handle, name);
    seen = call_string(lib->get_string_value, arg, "get_string");
    if (seen == NULL || strcmp(seen, expected) != 0) {
        fail("line %d of the plan, %s in words: expected `%s`, saw `%s`", line->number, name, expected,
             seen == NULL ? "(none)" : seen);
    }
}

/* A whole number through all three getters; in words it is its label, or its digits. */
static void check_whole(const library *lib, lw_handle handle, const line *line, way way, const char *name, int64_t expected,
                        const port *port)
{
    UF_Value arg[2];
    char digits[32];
    set_name(arg, handle, name);
    same(expected, call_integer(lib->get_integer_value, arg, "get_integer"), name);
    check_real(lib, handle, line, name, (double)expected);
    snprintf(digits, sizeof digits, "%" PRId64, expected);
    check_words(lib, handle, line, way, name,
                port != NULL && port->label_count > 0 ? port->labels[expected] : digits);
}

/* How the call went. */
static void check_verdict(const library *lib, lw_handle handle, const line *line, way way)
{
    UF_Value arg[2];
    set_name(arg, handle, "verdict");
    same(line->code, call_integer(lib->get_integer_value, arg, "get_integer"), "the verdict");
    check_real(lib, handle, line, "verdict", (double)line->code);
    check_words(lib, handle, line, way, "verdict", VERDICTS[-line->code]);
    if (line->code != LW_OK) {
        check_words(lib, handle, line, way, "rule", line->rule);
    }
}

/* One of the outputs after a step, another one in each line. */
static void check_output(const library *lib, lw_handle handle, const line *line, way way)
{
    char name[TEXT_ROOM];
    int32_t i = line->number % the_plan.outputs;
    snprintf(name, sizeof name, "output.%s", the_plan.output_ports[i].name);
    check_whole(lib, handle, line, way, name, the_plan.integers[line->got + (size_t)i], &the_plan.output_ports[i]);
}

static void check_property(const library *lib, lw_handle handle, const line *line, way way, int32_t i)
{
    char name[TEXT_ROOM];
    UF_Value arg[2];
    const port *port = &the_plan.property_ports[i];
    double expected = the_plan.reals[line->got + (size_t)i];
    snprintf(name, sizeof name, "property.%s", port->name);
    check_real(lib, handle, line, name, expected);
    if (expected >= (double)port->low && expected <= (double)port->high
        && bits_of((double)(int64_t)expected) == bits_of(expected)) {
        check_whole(lib, handle, line, way, name, (int64_t)expected, port);
    } else if (port->low > port->high) {
        set_name(arg, handle, name);
        same(LW_ERROR_ARGUMENT, call_integer(lib->get_integer_value, arg, "get_integer"), "what is no whole number");
    }
}

/* An integer is as good as a real number where it holds the same value. */
static UF_Value value_of_property(double value, int as_integer)
{
    if (as_integer && value >= -1000000.0 && value <= 1000000.0) {
        int32_t whole = (int32_t)value;
        if (bits_of((double)whole) == bits_of(value)) {
            return value_integer(whole);
        }
    }
    return value_real(value);
}

static int replay_values(const library *lib, lw_handle handle, const line *line, way way)
{
    UF_Value arg[MOST_VALUES + 2];
    const double *given = the_plan.reals + line->given;
    int known = line->operation >= 0 && line->operation < the_plan.operations;
    double answer;
    int32_t code;
    arg[0] = value_integer(handle);
    if (known && line->number % 2 == 0) {
        arg[1] = value_string(the_plan.operation_names[line->operation]);
    } else {
        arg[1] = value_integer(line->operation);
    }
    for (int32_t i = 0; i < the_plan.properties; i++) {
        arg[2 + i] = value_of_property(given[i], line->number % 3 == 0);
    }
    answer = call_real(lib->simulate_value, arg, "simulate");
    code = answer < 0.0 ? (int32_t)answer : LW_OK;
    if (line->code != LW_OK) {
        check_error(lib, handle, line, code);
        check_verdict(lib, handle, line, way);
        return 7;
    }
    if (code != LW_OK) {
        unexpected(lib, handle, line, code);
    }
    same_real(line->service.seconds, answer, line->number, "the duration");
    check_verdict(lib, handle, line, way);
    check_real(lib, handle, line, line->number % 2 == 0 ? "seconds" : "time", line->service.seconds);
    check_real(lib, handle, line, line->number % 2 == 0 ? "joules" : "energy", line->service.joules);
    check_whole(lib, handle, line, way, "steps", line->service.steps, NULL);
    for (int32_t i = 0; i < the_plan.properties; i++) {
        check_property(lib, handle, line, way, i);
    }
    return 9 + the_plan.properties;
}

static int replay_reset(const library *lib, lw_handle handle, way way)
{
    if (way == WAY_PLAIN) {
        same_code(LW_OK, lib->reset(handle), "lw_reset");
    } else {
        UF_Value arg = value_integer(handle);
        same(LW_OK, call_integer(lib->reset_value, &arg, "reset"), "reset");
    }
    return 1;
}

int replay(const library *lib, lw_handle handle, const line *line, way way)
{
    switch (line->kind) {
    case LINE_RESET:
        return replay_reset(lib, handle, way);
    case LINE_STEP: {
        int calls = replay_step(lib, handle, line);
        if (way != WAY_PLAIN) {
            check_verdict(lib, handle, line, way);
            calls += 3;
            if (line->code == LW_OK && the_plan.outputs > 0) {
                check_output(lib, handle, line, way);
                calls += 3;
            }
        }
        return calls;
    }
    case LINE_OPERATION:
        break;
    }
    return way == WAY_PLAIN ? replay_plain(lib, handle, line) : replay_values(lib, handle, line, way);
}
