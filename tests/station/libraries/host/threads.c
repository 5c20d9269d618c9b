/* Several threads at once. What each of them may expect differs: on an instance of its own everything that the plan says, on one
 * that it shares only what no order of the calls could change. */
#include "host.h"

#include <stdio.h>
#include <string.h>

#define THREADS 4
#define TEXT_ROOM 4096

static const library *shared_library;
static lw_handle shared_handle;
static int rounds;

/* ---- An instance each -------------------------------------------------------------------------------------------- */

static void alone(int thread)
{
    const library *lib = shared_library;
    for (int done = 0; done < rounds;) {
        lw_handle handle = instance(lib);
        for (int i = 0; i < the_plan.line_count && done < rounds; i++) {
            done += replay(lib, handle, &the_plan.lines[i], (i + thread) % 2 == 0 ? WAY_PLAIN : WAY_NUMBERS);
        }
        same_code(LW_OK, lib->destroy(handle), "lw_destroy");
    }
}

/* ---- One instance for all ---------------------------------------------------------------------------------------- */

/* Whether any order of calls could be answered so: the instance is there, and the machine keeps its guarantees. */
static void plausible(int32_t code, const char *what)
{
    if (code > LW_OK || code == LW_ERROR_HANDLE || code == LW_ERROR_GUARANTEE || code == LW_ERROR_MEMORY ||
        code == LW_ERROR_INTERNAL || code < LW_ERROR_ORDER) {
        fail("%s on an instance that several threads share: saw code %d", what, (int)code);
    }
}

static void step_shared(const library *lib, const line *line)
{
    int64_t outputs[MOST_VALUES];
    int32_t code;
    memset(outputs, 0x55, sizeof outputs);
    code = lib->step(shared_handle, the_plan.integers + line->given, (size_t)the_plan.plant, outputs,
                     (size_t)the_plan.outputs);
    plausible(code, "lw_step");
    for (int32_t i = 0; i < the_plan.outputs && code == LW_OK; i++) {
        const port *port = &the_plan.output_ports[i];
        if (outputs[i] < port->low || outputs[i] > port->high) {
            fail("output `%s` is outside its domain after a step on an instance that several threads share", port->name);
        }
    }
}

static void simulate_shared(const library *lib, const line *line)
{
    double properties[MOST_VALUES];
    lw_service service = {-1.0, -1.0, -1};
    int32_t code;
    for (int32_t i = 0; i < the_plan.properties; i++) {
        properties[i] = the_plan.reals[line->given + (size_t)i];
    }
    code = lib->simulate(shared_handle, line->operation, properties, (size_t)the_plan.properties, &service);
    plausible(code, "lw_simulate");
    if (code == LW_OK && !(service.seconds >= 0.0 && service.joules >= 0.0 && service.steps > 0)) {
        fail("an operation on an instance that several threads share took %g s, %g J", service.seconds, service.joules);
    }
}

static void read_shared(const library *lib)
{
    char text[TEXT_ROOM];
    UF_Value arg[2];
    UF_Value answer = value_of_tag(0);
    int32_t length = lib->last_error(shared_handle, text, sizeof text);
    /* A text that is read while it is written would not be whole. */
    same((int64_t)strlen(text), length, "the length of a text on an instance that several threads share");
    arg[0] = value_integer(shared_handle);
    arg[1] = value_string("joules");
    lib->get_real_value(&answer, arg);
    if (answer.type == LW_UF_TAG_REAL) {
        if (!(answer.value.LW_UF_FIELD_REAL >= 0.0)) {
            fail("the energy on an instance that several threads share is %g", answer.value.LW_UF_FIELD_REAL);
        }
    } else {
        same(LW_ERROR_ARGUMENT, (int64_t)answer.value.LW_UF_FIELD_INTEGER, "get_real");
    }
}

static void together(int thread)
{
    const library *lib = shared_library;
    uint64_t state = (uint64_t)thread + 1;
    for (int done = 0; done < rounds; done++) {
        const line *line = &the_plan.lines[draw(&state, (uint32_t)the_plan.line_count)];
        if (line->kind == LINE_STEP) {
            step_shared(lib, line);
        } else if (line->kind == LINE_OPERATION) {
            simulate_shared(lib, line);
        } else {
            same_code(LW_OK, lib->reset(shared_handle), "lw_reset");
        }
        if (done % 3 == 0) {
            read_shared(lib);
        }
    }
}

/* ---- No instance ------------------------------------------------------------------------------------------------- */

/* What is said of calls without a valid handle belongs to all threads, so it may be about another one's call; but it stays unchanged
 * as long as it is read. */
static void without_an_instance(int thread)
{
    const library *lib = shared_library;
    UF_Value arg = value_integer(-1 - thread);
    UF_Value real = value_of_tag(LW_UF_TAG_REAL);
    for (int done = 0; done < rounds; done++) {
        const char *text;
        char copy[TEXT_ROOM];
        int32_t length;
        if (sizeof(LW_UF_INTEGER) >= sizeof(lw_handle) && (done + thread) % 2 == 0) {
            same(LW_ERROR_ARGUMENT, call_integer(lib->reset_value, &real, "reset"), "reset with a real number");
        } else {
            same_code(LW_ERROR_HANDLE, lib->destroy(-1 - thread), "lw_destroy of a handle that was never given");
        }
        text = call_string(lib->last_error_value, &arg, "last_error");
        if (strcmp(text, "the handle must be an integer") != 0) {
            holds(text, "never issued by this library", "last_error without an instance");
        }
        length = lib->last_error(-1, copy, sizeof copy);
        same((int64_t)strlen(copy), length, "the length of a copied text");
    }
}

/* ---- Instances that come and go ---------------------------------------------------------------------------------- */

#define SHELF 16

/* Handles that their owners have done with, and that anyone may use or end. */
static lw_handle shelf[SHELF];
static int created;
static int destroyed;

static lw_handle exchange(uint64_t *state, lw_handle handle)
{
    lw_handle other;
    lock_take();
    lw_handle *place = &shelf[draw(state, SHELF)];
    other = *place;
    *place = handle;
    created += handle != 0;
    lock_give();
    return other;
}

static lw_handle look(uint64_t *state)
{
    lw_handle handle;
    lock_take();
    handle = shelf[draw(state, SHELF)];
    lock_give();
    return handle;
}

static void end_shared(const library *lib, lw_handle handle)
{
    int32_t code = lib->destroy(handle);
    if (code == LW_OK) {
        lock_take();
        destroyed++;
        lock_give();
    } else {
        same_code(LW_ERROR_HANDLE, code, "lw_destroy of what another thread may have ended");
    }
}

static void own(const library *lib, uint64_t *state)
{
    lw_handle handle = instance(lib);
    lw_handle old;
    for (int i = 0; i < 5 && i < the_plan.line_count; i++) {
        replay(lib, handle, &the_plan.lines[i], WAY_PLAIN);
    }
    old = exchange(state, handle);
    if (old != 0) {
        end_shared(lib, old);
    }
}

/* Calls on an instance that may end at any moment. */
static void meddle(const library *lib, uint64_t *state)
{
    int64_t outputs[MOST_VALUES];
    char text[TEXT_ROOM];
    lw_handle handle = look(state);
    const line *line = &the_plan.lines[draw(state, (uint32_t)the_plan.line_count)];
    int32_t code = LW_OK;
    int32_t length;
    if (handle == 0) {
        return;
    }
    switch (draw(state, 4)) {
    case 0:
        if (line->kind == LINE_STEP) {
            code = lib->step(handle, the_plan.integers + line->given, (size_t)the_plan.plant, outputs,
                             (size_t)the_plan.outputs);
        }
        break;
    case 1:
        code = lib->reset(handle);
        break;
    case 2:
        length = lib->last_error(handle, text, sizeof text);
        same((int64_t)strlen(text), length, "the length of a text of an instance that may end");
        break;
    default:
        if (draw(state, 8) == 0) {
            end_shared(lib, handle);
        }
        break;
    }
    if (code != LW_ERROR_HANDLE) {
        plausible(code, "a call");
    }
}

static void coming_and_going(int thread)
{
    const library *lib = shared_library;
    uint64_t state = (uint64_t)thread + 100;
    for (int done = 0; done < rounds; done++) {
        if (thread % 2 == 0) {
            own(lib, &state);
        } else {
            for (int i = 0; i < 4; i++) {
                meddle(lib, &state);
            }
        }
    }
}

void check_threads(const library *lib, int64_t calls)
{
    int64_t share = calls / THREADS;
    shared_library = lib;
    rounds = share > 1000000 ? 1000000 : (int)share;
    threads_run(THREADS, alone);
    say("%d threads, an instance each", THREADS);

    shared_handle = instance(lib);
    threads_run(THREADS, together);
    /* The instance is as sound as before. */
    same_code(LW_OK, lib->reset(shared_handle), "lw_reset");
    for (int i = 0; i < the_plan.line_count; i++) {
        replay(lib, shared_handle, &the_plan.lines[i], WAY_PLAIN);
    }
    same_code(LW_OK, lib->destroy(shared_handle), "lw_destroy");
    say("%d threads, one instance", THREADS);

    rounds = rounds / 10 < 20000 ? rounds / 10 : 20000;
    threads_run(THREADS, without_an_instance);
    say("%d threads, no instance", THREADS);

    /* As many as leave generations for what comes after. */
    rounds = rounds / 2;
    created = 0;
    destroyed = 0;
    memset(shelf, 0, sizeof shelf);
    threads_run(THREADS, coming_and_going);
    for (int i = 0; i < SHELF; i++) {
        if (shelf[i] != 0) {
            end_shared(lib, shelf[i]);
        }
    }
    same(created, destroyed, "instances that were ended, of those that were made");
    say("%d threads, %d instances that come and go", THREADS, created);
}
