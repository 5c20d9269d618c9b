/* The order of it all; host.h says what this program is. */
#include "host.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* So much may a process grow that does nothing but call: the library allocates nothing, and neither does this program. */
#define MOST_GROWTH (512 * 1024)

/* From so many calls on, what takes long is done as well. */
#define MANY_CALLS 300000

void fail(const char *format, ...)
{
    va_list arguments;
    /* Never given back: what another thread finds wrong now comes too late. */
    lock_take();
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    printf("\nHOST FAILED\n");
    fflush(stdout);
    _Exit(1);
}

void say(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    printf("\n");
    fflush(stdout);
}

void same(int64_t expected, int64_t seen, const char *what)
{
    if (expected != seen) {
        fail("%s: expected %" PRId64 ", saw %" PRId64, what, expected, seen);
    }
}

void same_code(int32_t expected, int32_t seen, const char *what)
{
    same(expected, seen, what);
}

void holds(const char *text, const char *part, const char *what)
{
    if (text == NULL || strstr(text, part) == NULL) {
        fail("%s: expected a text with `%s`, saw `%s`", what, part, text == NULL ? "(none)" : text);
    }
}

uint32_t draw(uint64_t *state, uint32_t below)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 33) % below;
}

/* What the library says of itself is what the plan says. */
static void check_description(const library *lib)
{
    same(LW_ABI_VERSION, lib->abi_version(), "lw_abi_version");
    same(the_plan.plant, lib->plant_count(), "lw_plant_count");
    same(the_plan.outputs, lib->output_count(), "lw_output_count");
    same(the_plan.properties, lib->property_count(), "lw_property_count");
    same(the_plan.operations, lib->operation_count(), "lw_operation_count");
    if (strcmp(lib->describe(), the_plan.description) != 0) {
        fail("lw_describe: expected `%s`, saw `%s`", the_plan.description, lib->describe());
    }
    holds(call_string(lib->describe_value, NULL, "station_describe"), the_plan.description, "station_describe");
}

/* Lines of the plan by the code that they are answered with. */
static void say_plan(void)
{
    int codes[10] = {0};
    for (int i = 0; i < the_plan.line_count; i++) {
        int32_t code = the_plan.lines[i].code;
        codes[code <= 0 && code > -10 ? -code : 9]++;
    }
    printf("%s: %d lines, %d succeed", the_plan.machine, the_plan.line_count, codes[0]);
    for (int code = 1; code < 10; code++) {
        if (codes[code] > 0) {
            printf(", %d with code -%d", codes[code], code);
        }
    }
    printf("\n");
}

/* Two instances go through the plan, one some lines behind the other, and mistakes are made on both in between. Gives how many
 * calls that took; stops at `most`. */
static int64_t two_instances(const library *lib, lw_handle first, lw_handle second, int64_t most)
{
    const int behind = 7;
    const int between = 5;
    int64_t calls = 0;
    int mistake = 0;
    for (int i = 0; i < the_plan.line_count + behind && calls < most; i++) {
        if (i < the_plan.line_count) {
            calls += replay(lib, first, &the_plan.lines[i], i % 2 == 0 ? WAY_PLAIN : WAY_VALUES);
        }
        if (i >= behind) {
            calls += replay(lib, second, &the_plan.lines[i - behind], i % 2 == 0 ? WAY_VALUES : WAY_PLAIN);
        }
        if (i % between == 0) {
            calls += make_mistake(lib, mistake % 2 == 0 ? first : second, mistake / 2 % mistake_count());
            mistake++;
        }
    }
    return calls;
}

static void check_plan(const library *lib)
{
    lw_handle first = instance(lib);
    lw_handle second = instance(lib);
    /* Every mistake before step 0, and before any operation has ended. */
    for (int i = 0; i < mistake_count(); i++) {
        make_mistake(lib, first, i);
    }
    two_instances(lib, first, second, INT64_MAX);
    for (int i = 0; i < mistake_count(); i++) {
        make_mistake(lib, second, i);
    }
    same_code(LW_OK, lib->destroy(first), "lw_destroy");
    same_code(LW_OK, lib->destroy(second), "lw_destroy");
}

/* So many calls of all kinds, in which the process must not grow. */
static void check_many_calls(const library *lib, int64_t calls)
{
    int64_t done = 0;
    int64_t before = memory_in_use();
    int64_t growth;
    while (done < calls) {
        lw_handle first = instance(lib);
        lw_handle second = instance(lib);
        done += two_instances(lib, first, second, calls - done);
        same_code(LW_OK, lib->destroy(first), "lw_destroy");
        same_code(LW_OK, lib->destroy(second), "lw_destroy");
    }
    growth = memory_in_use() - before;
    if (growth > MOST_GROWTH) {
        fail("%ld calls: expected a process that does not grow, saw %ld bytes more", (long)done, (long)growth);
    }
    say("%ld calls", (long)done);
}

int main(int argc, char **argv)
{
    library lib;
    library other;
    int64_t calls;
    if (argc != 5) {
        fail("usage: host LIBRARY PLAN CALLS OTHER_LIBRARY");
    }
    calls = (int64_t)strtol(argv[3], NULL, 10);
    plan_read(argv[2]);
    say_plan();
    library_open(&lib, argv[1]);
    library_open(&other, argv[4]);
    check_description(&lib);
    say("all exports");
    check_plan(&lib);
    say("two instances through the plan");
    check_handles(&lib, &other);
    check_room(&lib);
    check_generations(&lib);
    say("handles");
    check_many_calls(&lib, calls);
    check_reload(&lib);
    say("unloaded and loaded anew");
    check_threads(&lib, calls / 10);
    if (calls >= MANY_CALLS) {
        library_close(&lib);
        library_open(&lib, argv[1]);
        use_up_generations(&lib);
        library_close(&lib);
        library_open(&lib, argv[1]);
        check_plan(&lib);
    }
    library_close(&lib);
    library_close(&other);
    printf("HOST PASSED\n");
    return 0;
}
