/* Instances: how many there can be at a time, how often a place can be used, and what is left when the library goes. */
#include "host.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* As station.h promises. */
#define MOST_INSTANCES 1024

/* How often each of their places can be used. */
#define GENERATIONS 2047

#define TEXT_ROOM 4096

/* So few that two million handles hardly ever agree by chance. */
#define QUICK_LOADS 8

lw_handle instance(const library *lib)
{
    lw_handle handle = lib->create();
    if (handle <= 0) {
        fail("lw_create: expected a handle above 0, saw %d", (int)handle);
    }
    return handle;
}

static void end(const library *lib, lw_handle handle)
{
    same_code(LW_OK, lib->destroy(handle), "lw_destroy");
}

/* The first lines of the plan, which begin before step 0. */
static void first_lines(const library *lib, lw_handle handle, int lines)
{
    for (int i = 0; i < lines && i < the_plan.line_count; i++) {
        replay(lib, handle, &the_plan.lines[i], i % 2 == 0 ? WAY_PLAIN : WAY_VALUES);
    }
}

/* An instance has no text, rule, verdict or result before its first call, and is before step 0 then. */
static void nothing_yet(const library *lib, lw_handle handle)
{
    char rule[TEXT_ROOM];
    UF_Value arg[2];
    arg[0] = value_integer(handle);
    arg[1] = value_string("verdict");
    if (call_string(lib->last_error_value, arg, "last_error")[0] != '\0') {
        fail("last_error: expected no text of an instance on which nothing was called");
    }
    same(0, lib->last_rule(handle, rule, sizeof rule), "the rule of an instance on which nothing was called");
    same(LW_OK, call_integer(lib->get_integer_value, arg, "get_integer"), "the verdict of such an instance");
    arg[1] = value_string("time");
    same(LW_ERROR_ARGUMENT, call_integer(lib->get_real_value, arg, "get_real"), "the time of such an instance");
    holds(call_string(lib->last_error_value, arg, "last_error"), "no operation has ended yet", "last_error");
    /* The plan begins with a reset; what comes after it needs none here. */
    if (the_plan.line_count > 1 && the_plan.lines[0].kind == LINE_RESET) {
        replay(lib, handle, &the_plan.lines[1], WAY_PLAIN);
    }
}

/* So it is whatever another instance was asked last, and whatever the instance before it in its place did. */
static void check_new_instances(const library *lib)
{
    double properties[MOST_VALUES] = {0.0};
    lw_handle refused = instance(lib);
    lw_handle handle = instance(lib);
    UF_Value arg = value_integer(refused);
    same_code(LW_ERROR_OPERATION, lib->simulate(refused, -1, properties, (size_t)the_plan.properties, NULL), "lw_simulate");
    holds(call_string(lib->last_error_value, &arg, "last_error"), "there is no operation", "last_error");
    nothing_yet(lib, handle);
    for (int i = 0; i < the_plan.line_count; i++) {
        const line *line = &the_plan.lines[i];
        replay(lib, handle, line, WAY_PLAIN);
        if ((line->code != LW_OK && line->rule[0] != '\0') || (line->kind == LINE_OPERATION && line->code == LW_OK)) {
            end(lib, handle);
            handle = instance(lib);
            nothing_yet(lib, handle);
            /* What follows in the plan follows a reset. */
            while (i + 1 < the_plan.line_count && the_plan.lines[i + 1].kind != LINE_RESET) {
                i++;
            }
        }
    }
    end(lib, refused);
    end(lib, handle);
}

/* The text of a call without an instance is that of the last one that was refused. */
static void check_text_without_an_instance(const library *lib)
{
    char text[TEXT_ROOM];
    UF_Value wrong = value_real(0.0);
    lw_handle handle = instance(lib);
    same(LW_ERROR_ARGUMENT, call_integer(lib->reset_value, &wrong, "reset"), "reset with a real number");
    end(lib, handle);
    lib->last_error(0, text, sizeof text);
    holds(text, "the handle must be an integer", "lw_last_error after an instance was ended");
    same_code(LW_ERROR_HANDLE, lib->destroy(handle), "lw_destroy of an instance that has ended");
    lib->last_error(0, text, sizeof text);
    holds(text, "the handle was never issued", "lw_last_error after lw_destroy was refused");
    same(LW_ERROR_ARGUMENT, call_integer(lib->reset_value, &wrong, "reset"), "reset with a real number");
    same_code(LW_ERROR_HANDLE, lib->reset(handle), "lw_reset of an instance that has ended");
    lib->last_error(0, text, sizeof text);
    holds(text, "the handle was never issued", "lw_last_error after lw_reset was refused");
}

/* Handles that are none: never given, of another library, of an instance that has ended. */
void check_handles(const library *lib, const library *other)
{
    static const lw_handle never[] = {0, -1, 1, 2, 1023, 1024, 1 << 21, INT32_MIN, INT32_MIN + 1, INT32_MAX, INT32_MAX - 1};
    lw_handle handle = instance(lib);
    lw_handle second = instance(lib);
    lw_handle foreign = instance(other);
    UF_Value arg;
    check_new_instances(lib);
    check_text_without_an_instance(lib);
    for (size_t i = 0; i < sizeof never / sizeof never[0]; i++) {
        refuse_handle(lib, never[i], "a handle that was never given");
    }
    /* One bit away from a handle is another one, or none. */
    for (int bit = 0; bit < 32; bit++) {
        lw_handle near = (lw_handle)((uint32_t)handle ^ ((uint32_t)1 << bit));
        if (near != second) {
            refuse_handle(lib, near, "a handle with a bit turned");
        }
    }
    refuse_handle(lib, foreign, "a handle of another library");
    refuse_handle(other, handle, "a handle of another library");
    end(other, foreign);
    refuse_handle(other, foreign, "a handle whose instance has ended");
    end(lib, handle);
    refuse_handle(lib, handle, "a handle whose instance has ended");
    /* The place is used again; the old handle stays dead, and the instance beside it is as it was. */
    for (int i = 0; i < 100; i++) {
        lw_handle again = instance(lib);
        if (again == handle || again == second) {
            fail("a handle was given twice: %d", (int)again);
        }
        first_lines(lib, again, 3);
        refuse_handle(lib, handle, "a handle whose place is used again");
        end(lib, again);
    }
    first_lines(lib, second, the_plan.line_count < 50 ? the_plan.line_count : 50);
    if (sizeof(LW_UF_INTEGER) > sizeof(lw_handle)) {
        /* Cut to 32 bits, these would be handles. */
        arg = value_integer((int64_t)second + (INT64_C(1) << 32));
        same(LW_ERROR_HANDLE, call_integer(lib->reset_value, &arg, "reset"), "a handle above 32 bits");
        arg = value_integer((int64_t)second - (INT64_C(1) << 32));
        same(LW_ERROR_HANDLE, call_integer(lib->deinstantiate_value, &arg, "deinstantiate"), "a handle below 32 bits");
    }
    /* An instance made through one interface is an instance of the other. */
    arg = value_integer(second);
    same(LW_OK, call_integer(lib->deinstantiate_value, &arg, "deinstantiate"), "deinstantiate");
    refuse_handle(lib, second, "a handle whose instance has ended");
    handle = (lw_handle)call_integer(lib->instantiate_value, NULL, "instantiate");
    first_lines(lib, handle, 10);
    end(lib, handle);
}

/* All instances that there can be, and one more. */
void check_room(const library *lib)
{
    lw_handle handles[MOST_INSTANCES];
    char text[TEXT_ROOM];
    /* These take no place, since nobody gets their handles. */
    for (int i = 0; i < 10; i++) {
        lib->instantiate_value(NULL, NULL);
    }
    for (int i = 0; i < MOST_INSTANCES; i++) {
        handles[i] = instance(lib);
    }
    for (int round = 0; round < 2; round++) {
        same_code(LW_ERROR_MEMORY, lib->create(), "lw_create with all places taken");
        lib->last_error(0, text, sizeof text);
        holds(text, "all slots for instances are in use", "lw_create with all places taken");
        same(LW_ERROR_MEMORY, call_integer(lib->instantiate_value, NULL, "instantiate"), "instantiate");
        holds(call_string(lib->last_error_value, NULL, "last_error"), "all slots for instances are in use", "last_error");
        /* One place in the middle is free again. */
        end(lib, handles[500]);
        handles[500] = instance(lib);
    }
    /* Each is an instance of its own: they are at different lines of the plan. */
    for (int i = 0; i < MOST_INSTANCES; i++) {
        first_lines(lib, handles[i], i % 7);
    }
    for (int i = MOST_INSTANCES - 1; i >= 0; i--) {
        for (int l = i % 7; l < i % 7 + 2 && l < the_plan.line_count; l++) {
            replay(lib, handles[i], &the_plan.lines[l], WAY_PLAIN);
        }
    }
    for (int i = 0; i < MOST_INSTANCES; i++) {
        end(lib, handles[i]);
    }
}

static int by_value(const void *a, const void *b)
{
    lw_handle x = *(const lw_handle *)a;
    lw_handle y = *(const lw_handle *)b;
    return x < y ? -1 : x > y;
}

static void all_different(lw_handle *handles, size_t count)
{
    qsort(handles, count, sizeof *handles, by_value);
    for (size_t i = 0; i + 1 < count; i++) {
        if (handles[i] == handles[i + 1]) {
            fail("a handle was given twice: %d", (int)handles[i]);
        }
    }
}

/* Instances that come and go get handles that were never there before. */
void check_generations(const library *lib)
{
    static lw_handle handles[5000];
    const int count = (int)(sizeof handles / sizeof handles[0]);
    for (int i = 0; i < count; i++) {
        handles[i] = instance(lib);
        end(lib, handles[i]);
    }
    for (int i = 0; i < count; i += 97) {
        refuse_handle(lib, handles[i], "a handle whose instance has ended");
    }
    all_different(handles, (size_t)count);
}

/* A library that was just loaded: until the generations of all places are used up, no handle comes twice. Then they come again in the same
 * order, apart from those of the second place, whose last instance is still there, and all places can be in use. */
void use_up_generations(const library *lib)
{
    const size_t most = (size_t)MOST_INSTANCES * GENERATIONS;
    const size_t kept = (size_t)2 * GENERATIONS - 1;
    lw_handle many[MOST_INSTANCES];
    char text[TEXT_ROOM];
    lw_handle *handles = malloc(most * sizeof *handles);
    if (handles == NULL) {
        fail("there is no memory for the handles");
    }
    for (size_t i = 0; i < most; i++) {
        handles[i] = instance(lib);
        if (i != kept) {
            end(lib, handles[i]);
        }
    }
    for (size_t i = 0; i < most; i += most / 97 + 1) {
        refuse_handle(lib, handles[i], "a handle whose instance has ended");
    }
    for (size_t i = 0; i < (size_t)3 * GENERATIONS; i++) {
        lw_handle handle = instance(lib);
        same(handles[i < GENERATIONS ? i : i + GENERATIONS], handle, "a handle after all generations were used");
        end(lib, handle);
    }
    for (int i = 1; i < MOST_INSTANCES; i++) {
        many[i] = instance(lib);
    }
    same(LW_ERROR_MEMORY, lib->create(), "lw_create with all places in use");
    lib->last_error(0, text, sizeof text);
    holds(text, "all slots for instances are in use", "lw_create with all places in use");
    for (int i = 1; i < MOST_INSTANCES; i++) {
        end(lib, many[i]);
    }
    first_lines(lib, handles[kept], 4);
    end(lib, handles[kept]);
    for (int i = 0; i < GENERATIONS; i++) {
        end(lib, instance(lib));
    }
    say("%ld instances one after the other, until all generations are used", (long)most);
    all_different(handles, most);
    free(handles);
}

/* What was there before a library was unloaded is not there afterwards. */
void check_reload(library *lib)
{
    const char *path = lib->path;
    lw_handle old[3];
    lw_handle quick[QUICK_LOADS];
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < 3; i++) {
            old[i] = instance(lib);
            first_lines(lib, old[i], 5);
        }
        library_close(lib);
        library_open(lib, path);
        for (int i = 0; i < 3; i++) {
            refuse_handle(lib, old[i], "a handle from before the library was loaded anew");
        }
    }
    old[0] = instance(lib);
    first_lines(lib, old[0], the_plan.line_count);
    end(lib, old[0]);
    /* As quickly as can be: what was given before is not given again. */
    for (int i = 0; i < QUICK_LOADS; i++) {
        quick[i] = instance(lib);
        library_close(lib);
        library_open(lib, path);
    }
    all_different(quick, QUICK_LOADS);
}
