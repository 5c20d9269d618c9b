/* Calls that a clumsy or hostile host makes: each has to be answered with its code and a text, and to change nothing. That nothing
 * changed is seen by what comes after it: mistakes are made between the lines of the plan. */
#include "host.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TEXT_ROOM 4096

/* What a mistake is made with. */
typedef struct scene {
    const library *lib;
    lw_handle handle;
    int64_t plant[MOST_VALUES];
    int64_t outputs[MOST_VALUES];
    double properties[MOST_VALUES];
    UF_Value arg[MOST_VALUES + 2];
    lw_service service;
} scene;

/* The code, and a part of the text that the instance then has. */
static void refused(const scene *scene, int32_t expected, int32_t seen, const char *part, const char *what)
{
    char text[TEXT_ROOM];
    char rule[TEXT_ROOM];
    same_code(expected, seen, what);
    scene->lib->last_error(scene->handle, text, sizeof text);
    holds(text, part, what);
    same(0, scene->lib->last_rule(scene->handle, rule, sizeof rule), "the length of a rule where there is none");
}

/* What must not have been written to. */
static void untouched(const scene *scene, const char *what)
{
    for (int32_t i = 0; i < the_plan.outputs; i++) {
        same(-77, scene->outputs[i], what);
    }
    for (int32_t i = 0; i < the_plan.properties; i++) {
        if (scene->properties[i] > 0.25 || scene->properties[i] < 0.25) {
            fail("%s: property %d was written", what, (int)i);
        }
    }
    same(-5, scene->service.steps, what);
}

/* ---- Steps ------------------------------------------------------------------------------------------------------- */

#define PLANT_TEXT "the plant values are missing"
#define ROOM_TEXT "the size of the output array"

static void bad_step(const scene *scene, const int64_t *plant, int64_t plant_count, int64_t *outputs,
                     int64_t output_count, const char *part)
{
    int32_t seen =
        scene->lib->step(scene->handle, plant, (size_t)plant_count, outputs, (size_t)output_count);
    refused(scene, LW_ERROR_ARGUMENT, seen, part, "lw_step");
    untouched(scene, "lw_step");
}

static void step_with_too_many_inputs(scene *s)
{
    bad_step(s, s->plant, the_plan.plant + 1, s->outputs, the_plan.outputs, PLANT_TEXT);
}

static void step_with_too_few_inputs(scene *s)
{
    /* One less than none is as many as there can be. */
    bad_step(s, s->plant, (int64_t)the_plan.plant - 1, s->outputs, the_plan.outputs, PLANT_TEXT);
}

static void step_without_inputs(scene *s)
{
    if (the_plan.plant > 0) {
        bad_step(s, NULL, the_plan.plant, s->outputs, the_plan.outputs, PLANT_TEXT);
        bad_step(s, NULL, 0, s->outputs, the_plan.outputs, PLANT_TEXT);
    }
}

static void step_with_the_wrong_room(scene *s)
{
    bad_step(s, s->plant, the_plan.plant, s->outputs, (int64_t)the_plan.outputs + 1, ROOM_TEXT);
    bad_step(s, s->plant, the_plan.plant, s->outputs, -1, ROOM_TEXT);
    if (the_plan.outputs > 0) {
        bad_step(s, s->plant, the_plan.plant, s->outputs, (int64_t)the_plan.outputs - 1, ROOM_TEXT);
        bad_step(s, s->plant, the_plan.plant, s->outputs, 0, ROOM_TEXT);
        bad_step(s, s->plant, the_plan.plant, NULL, the_plan.outputs, ROOM_TEXT);
    }
}

/* Every input, one value beside its domain and the largest ones there are. */
static void step_outside_the_domain(scene *s)
{
    char name[TEXT_ROOM];
    for (int32_t i = 0; i < the_plan.plant; i++) {
        const port *port = &the_plan.plant_ports[i];
        const int64_t outside[4] = {port->low - 1, port->high + 1, INT64_MIN, INT64_MAX};
        for (int k = 0; k < 4; k++) {
            int32_t seen;
            s->plant[i] = outside[k];
            seen = s->lib->step(s->handle, s->plant, (size_t)the_plan.plant, s->outputs, (size_t)the_plan.outputs);
            snprintf(name, sizeof name, "plant input `%s` is %s", port->name, outside[k] < 0 ? "-" : "");
            refused(s, LW_ERROR_DOMAIN, seen, name, "lw_step");
            untouched(s, "lw_step");
        }
        s->plant[i] = port->low;
    }
}

/* ---- Operations -------------------------------------------------------------------------------------------------- */

static void bad_operation(scene *s, int32_t operation, double *properties, int64_t count, int32_t code,
                          const char *part)
{
    int32_t seen = s->lib->simulate(s->handle, operation, properties, (size_t)count, &s->service);
    refused(s, code, seen, part, "lw_simulate");
    untouched(s, "lw_simulate");
    s->arg[1] = value_string("verdict");
    same_code(code, (int32_t)call_integer(s->lib->get_integer_value, s->arg, "get_integer"), "the verdict");
}

static void operation_with_wrong_counts(scene *s)
{
    const char *part = "the property values are missing";
    bad_operation(s, 0, s->properties, (int64_t)the_plan.properties + 1, LW_ERROR_ARGUMENT, part);
    bad_operation(s, 0, s->properties, (int64_t)the_plan.properties - 1, LW_ERROR_ARGUMENT, part);
    if (the_plan.properties > 0) {
        bad_operation(s, 0, NULL, the_plan.properties, LW_ERROR_ARGUMENT, part);
        bad_operation(s, 0, NULL, 0, LW_ERROR_ARGUMENT, part);
    }
}

static void operation_that_is_not_there(scene *s)
{
    const int32_t none[5] = {-1, the_plan.operations, 1000000, INT32_MIN, INT32_MAX};
    for (int k = 0; k < 5; k++) {
        char text[64];
        snprintf(text, sizeof text, "there is no operation %ld", (long)none[k]);
        bad_operation(s, none[k], s->properties, the_plan.properties, LW_ERROR_OPERATION, text);
        s->arg[1] = value_integer(none[k]);
        refused(s, LW_ERROR_OPERATION, (int32_t)call_real(s->lib->simulate_value, s->arg, "simulate"), text, "simulate");
    }
}

static void operation_of_another_name(scene *s)
{
    const char *const names[4] = {"", "no such operation", "\xC3\xA4%s%n", "lw_simulate"};
    for (int k = 0; k < 4; k++) {
        s->arg[1] = value_string(names[k]);
        refused(s, LW_ERROR_OPERATION, (int32_t)call_real(s->lib->simulate_value, s->arg, "simulate"), names[k],
                "simulate");
    }
}

/* A name of which a text keeps the first 63 bytes, or fewer where a character would be cut in two. */
static void operation_of_a_name_to_cut(scene *s, const char *name)
{
    char expected[TEXT_ROOM];
    char text[TEXT_ROOM];
    size_t kept = strlen(name);
    if (kept > 63) {
        kept = 63;
        while (kept > 0 && ((unsigned char)name[kept] & 0xC0U) == 0x80U) {
            kept--;
        }
    }
    snprintf(expected, sizeof expected, "there is no operation `%.*s%s`", (int)kept, name,
             name[kept] == '\0' ? "" : "...");
    s->arg[1] = value_string(name);
    refused(s, LW_ERROR_OPERATION, (int32_t)call_real(s->lib->simulate_value, s->arg, "simulate"), "there is no operation `",
            "simulate");
    s->lib->last_error(s->handle, text, sizeof text);
    if (strcmp(text, expected) != 0) {
        fail("a name of %d bytes: expected `%s`, saw `%s`", (int)strlen(name), expected, text);
    }
}

static void operation_of_a_name_about_as_long(scene *s)
{
    const char *const characters[3] = {"y", "\xC3\xA4", "\xE2\x86\x92"};
    char name[200];
    for (int k = 0; k < 3; k++) {
        for (size_t length = 60; length < 68; length++) {
            size_t end = length % 4;
            memset(name, 'x', end);
            while (end < length) {
                memcpy(name + end, characters[k], strlen(characters[k]));
                end += strlen(characters[k]);
            }
            name[end] = '\0';
            operation_of_a_name_to_cut(s, name);
        }
    }
    /* No character begins in this one. */
    memset(name, 0x80, 70);
    name[70] = '\0';
    operation_of_a_name_to_cut(s, name);
}

/* A name that is longer than any text has room for is cut, between two characters. */
static void operation_of_a_long_name(scene *s)
{
    char name[9001];
    char text[TEXT_ROOM];
    int32_t length;
    for (size_t i = 0; i + 1 < sizeof name; i += 2) {
        name[i] = '\xC3';
        name[i + 1] = '\xA4';
    }
    name[sizeof name - 1] = '\0';
    s->arg[1] = value_string(name);
    refused(s, LW_ERROR_OPERATION, (int32_t)call_real(s->lib->simulate_value, s->arg, "simulate"),
            "there is no operation `\xC3\xA4", "simulate");
    length = s->lib->last_error(s->handle, text, sizeof text);
    same((int64_t)strlen(text), length, "the length of a cut text");
    if (length > 0 && text[length - 1] == '\xC3') {
        fail("a text ends in half a character");
    }
}

static void operation_with_a_wrong_tag(scene *s)
{
    UF_Value wrong[5];
    wrong[0] = value_real(0.0);
    wrong[1] = value_string(NULL);
    wrong[2] = value_of_tag(0);
    wrong[3] = value_of_tag(77);
    wrong[4] = value_of_tag(-1);
    for (int k = 0; k < 5; k++) {
        s->arg[1] = wrong[k];
        refused(s, LW_ERROR_ARGUMENT, (int32_t)call_real(s->lib->simulate_value, s->arg, "simulate"),
                "the operation must be an integer or a string", "simulate");
    }
}

static void property_with_a_wrong_tag(scene *s)
{
    char text[TEXT_ROOM];
    UF_Value wrong[3];
    wrong[0] = value_string("1");
    wrong[1] = value_string(NULL);
    wrong[2] = value_of_tag(77);
    if (the_plan.operations == 0) {
        return;
    }
    for (int32_t i = 0; i < the_plan.properties; i++) {
        UF_Value kept = s->arg[2 + i];
        snprintf(text, sizeof text, "property `%s` must be a real number or an integer", the_plan.property_ports[i].name);
        for (int k = 0; k < 3; k++) {
            s->arg[2 + i] = wrong[k];
            refused(s, LW_ERROR_ARGUMENT, (int32_t)call_real(s->lib->simulate_value, s->arg, "simulate"), text,
                    "simulate");
        }
        s->arg[2 + i] = kept;
    }
}

static void property_that_is_no_number(scene *s)
{
    char text[TEXT_ROOM];
    const double none[3] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    if (the_plan.operations == 0) {
        return;
    }
    for (int32_t i = 0; i < the_plan.properties; i++) {
        snprintf(text, sizeof text, "property `%s` is not a finite number", the_plan.property_ports[i].name);
        for (int k = 0; k < 3; k++) {
            s->properties[i] = none[k];
            refused(s, LW_ERROR_DOMAIN,
                    s->lib->simulate(s->handle, 0, s->properties, (size_t)the_plan.properties, &s->service), text,
                    "lw_simulate");
            s->properties[i] = 0.25;
            untouched(s, "lw_simulate");
            s->arg[2 + i] = value_real(none[k]);
            refused(s, LW_ERROR_DOMAIN, (int32_t)call_real(s->lib->simulate_value, s->arg, "simulate"), text,
                    "simulate");
        }
        s->arg[2 + i] = value_real(0.25);
    }
}

/* ---- Results ----------------------------------------------------------------------------------------------------- */

static void bad_result(scene *s, UF_Value name, const char *part)
{
    value_export *const getters[3] = {s->lib->get_real_value, s->lib->get_integer_value, s->lib->get_string_value};
    s->arg[1] = name;
    for (int k = 0; k < 3; k++) {
        refused(s, LW_ERROR_ARGUMENT, (int32_t)call_integer(getters[k], s->arg, "a getter"), part, "a getter");
    }
}

static void result_with_a_wrong_tag(scene *s)
{
    const char *part = "the name must be a string";
    bad_result(s, value_integer(0), part);
    bad_result(s, value_real(0.0), part);
    bad_result(s, value_string(NULL), part);
    bad_result(s, value_of_tag(77), part);
}

/* What is said depends on whether an operation has ended, but it is refused at any time. */
static void result_of_another_name(scene *s)
{
    static const char *const names[] = {"",        "property.",    "property",      "output.",     "output",
                                        "Verdict", "output.verdict", "no such result", "time ",      "%s%n"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        bad_result(s, value_string(names[k]), "no");
    }
}

/* What is measured is no whole number, whatever its value. */
static void result_of_another_kind(scene *s)
{
    s->arg[1] = value_string("time");
    refused(s, LW_ERROR_ARGUMENT, (int32_t)call_integer(s->lib->get_integer_value, s->arg, "get_integer"), "n",
            "get_integer");
    s->arg[1] = value_string("energy");
    refused(s, LW_ERROR_ARGUMENT, (int32_t)call_integer(s->lib->get_integer_value, s->arg, "get_integer"), "n",
            "get_integer");
}

/* ---- Handles ----------------------------------------------------------------------------------------------------- */

/* A handle that is no integer, or no argument at all. */
static void handle_with_a_wrong_tag(scene *s)
{
    const library *lib = s->lib;
    value_export *const exports[6] = {lib->simulate_value,    lib->get_real_value, lib->get_integer_value,
                                      lib->get_string_value,  lib->reset_value,    lib->deinstantiate_value};
    UF_Value wrong[4];
    char text[TEXT_ROOM];
    wrong[0] = value_real((double)s->handle);
    wrong[1] = value_string("1");
    wrong[2] = value_of_tag(77);
    wrong[3] = value_of_tag(0);
    s->arg[1] = value_integer(0);
    for (int k = 0; k < 5; k++) {
        UF_Value *arg = k < 4 ? s->arg : NULL;
        if (k < 4) {
            s->arg[0] = wrong[k];
        }
        for (int e = 0; e < 6; e++) {
            int32_t seen = e == 0 ? (int32_t)call_real(exports[e], arg, "a call with no handle")
                                  : (int32_t)call_integer(exports[e], arg, "a call with no handle");
            same_code(LW_ERROR_ARGUMENT, seen, "a call with no handle");
            lib->last_error(0, text, sizeof text);
            holds(text, "the handle must be an integer", "a call with no handle");
        }
        holds(call_string(lib->last_error_value, arg, "last_error"), "the handle must be an integer", "last_error");
    }
}

/* Nowhere to put the answer: the call is made, or refused, but nothing is written. */
static void answer_without_a_place(scene *s)
{
    const library *lib = s->lib;
    s->arg[1] = value_integer(-1);
    lib->simulate_value(NULL, s->arg);
    s->arg[1] = value_string("no such result");
    lib->get_real_value(NULL, s->arg);
    lib->get_integer_value(NULL, s->arg);
    lib->get_string_value(NULL, s->arg);
    s->arg[1] = value_string("verdict");
    lib->get_real_value(NULL, s->arg);
    lib->get_integer_value(NULL, s->arg);
    lib->get_string_value(NULL, s->arg);
    lib->last_error_value(NULL, s->arg);
    lib->last_error_value(NULL, NULL);
    lib->describe_value(NULL, NULL);
    lib->reset_value(NULL, NULL);
    lib->deinstantiate_value(NULL, NULL);
    lib->simulate_value(NULL, NULL);
    lib->get_real_value(NULL, NULL);
    lib->get_integer_value(NULL, NULL);
    lib->get_string_value(NULL, NULL);
}

/* A text is cut to the room there is, and its length is told whole. */
static void text_with_little_room(scene *s)
{
    char text[TEXT_ROOM];
    char cut[TEXT_ROOM];
    int32_t length;
    s->lib->simulate(s->handle, -1, s->properties, (size_t)the_plan.properties, NULL);
    length = s->lib->last_error(s->handle, text, sizeof text);
    same((int64_t)strlen(text), length, "the length of a text");
    for (size_t room = 0; room <= (size_t)length + 2; room++) {
        memset(cut, '#', sizeof cut);
        same(length, s->lib->last_error(s->handle, cut, room), "the length of a cut text");
        if (room > 0) {
            size_t kept = room <= (size_t)length ? room - 1 : (size_t)length;
            if (memcmp(cut, text, kept) != 0 || cut[kept] != '\0' || cut[kept + 1] != '#') {
                fail("a text in a room of %d bytes: expected %d bytes of `%s`", (int)room, (int)kept, text);
            }
        } else if (cut[0] != '#') {
            fail("a text in no room was written");
        }
    }
    same(length, s->lib->last_error(s->handle, NULL, 0), "the length of a text without room");
    same(length, s->lib->last_error(s->handle, NULL, 100), "the length of a text without a place");
    holds(call_string(s->lib->last_error_value, s->arg, "last_error"), text, "last_error");
}

int refuse_handle(const library *lib, lw_handle handle, const char *what)
{
    char text[TEXT_ROOM];
    int64_t plant[MOST_VALUES];
    int64_t outputs[MOST_VALUES];
    double properties[MOST_VALUES];
    UF_Value arg[MOST_VALUES + 2];
    memset(plant, 0, sizeof plant);
    memset(outputs, 0, sizeof outputs);
    for (int i = 0; i < MOST_VALUES; i++) {
        properties[i] = 0.0;
        arg[2 + i] = value_real(0.0);
    }
    same_code(LW_ERROR_HANDLE, lib->destroy(handle), what);
    same_code(LW_ERROR_HANDLE, lib->reset(handle), what);
    same_code(LW_ERROR_HANDLE,
              lib->step(handle, plant, (size_t)the_plan.plant, outputs, (size_t)the_plan.outputs), what);
    same_code(LW_ERROR_HANDLE, lib->simulate(handle, 0, properties, (size_t)the_plan.properties, NULL), what);
    lib->last_error(handle, text, sizeof text);
    holds(text, "the handle was never issued", what);
    same(0, lib->last_rule(handle, text, sizeof text), what);
    arg[0] = value_integer(handle);
    arg[1] = value_integer(0);
    same_code(LW_ERROR_HANDLE, (int32_t)call_real(lib->simulate_value, arg, what), what);
    same(LW_ERROR_HANDLE, call_integer(lib->reset_value, arg, what), what);
    same(LW_ERROR_HANDLE, call_integer(lib->deinstantiate_value, arg, what), what);
    arg[1] = value_string("verdict");
    same(LW_ERROR_HANDLE, call_integer(lib->get_real_value, arg, what), what);
    same(LW_ERROR_HANDLE, call_integer(lib->get_integer_value, arg, what), what);
    same(LW_ERROR_HANDLE, call_integer(lib->get_string_value, arg, what), what);
    holds(call_string(lib->last_error_value, arg, what), "the handle was never issued", what);
    return 13;
}

/* An instance's own text is not that of a call with a handle that is none. */
static void text_of_another_call(scene *s)
{
    char before[TEXT_ROOM];
    char after[TEXT_ROOM];
    s->lib->simulate(s->handle, -2, s->properties, (size_t)the_plan.properties, NULL);
    s->lib->last_error(s->handle, before, sizeof before);
    refuse_handle(s->lib, 0, "a handle of 0");
    s->lib->last_error(s->handle, after, sizeof after);
    if (strcmp(before, after) != 0) {
        fail("an instance's text was `%s`, and is `%s` after a call without a handle", before, after);
    }
}

static void (*const MISTAKES[])(scene *s) = {
    step_with_too_many_inputs,  step_with_too_few_inputs,  step_without_inputs,        step_with_the_wrong_room,
    step_outside_the_domain,    operation_with_wrong_counts, operation_that_is_not_there, operation_of_another_name,
    operation_of_a_name_about_as_long,
    operation_of_a_long_name,   operation_with_a_wrong_tag, property_with_a_wrong_tag,  property_that_is_no_number,
    result_with_a_wrong_tag,    result_of_another_name,    result_of_another_kind,     handle_with_a_wrong_tag,    answer_without_a_place,
    text_with_little_room,      text_of_another_call,
};

int mistake_count(void)
{
    return (int)(sizeof MISTAKES / sizeof MISTAKES[0]);
}

int make_mistake(const library *lib, lw_handle handle, int which)
{
    scene scene;
    memset(&scene, 0, sizeof scene);
    scene.lib = lib;
    scene.handle = handle;
    scene.service.steps = -5;
    scene.arg[0] = value_integer(handle);
    scene.arg[1] = value_integer(0);
    for (int i = 0; i < MOST_VALUES; i++) {
        scene.outputs[i] = -77;
        scene.properties[i] = 0.25;
        scene.arg[2 + i] = value_real(0.25);
    }
    for (int32_t i = 0; i < the_plan.plant; i++) {
        scene.plant[i] = the_plan.plant_ports[i].low;
    }
    MISTAKES[which](&scene);
    /* Each is at least one call and two questions. */
    return 3;
}
