/* A host for FMI units, in plain C: plays a tape, or makes every call wrong that can be wrong.
 *
 *     cc -DFMI=2 host.c -o host -ldl         (and -DFMI=3; with a compiler for Windows as well)
 *     host play LIBRARY TOKEN STEP TAPE
 *     host check LIBRARY TOKEN STEP
 *
 * `tape.rs` says what a tape is. Exit codes through Wine are not to be trusted: what went well ends with `HOST PASSED`. */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static HMODULE library;
static void load(const char *path) { library = LoadLibraryA(path); }
static void *symbol(const char *name) { return (void *)(intptr_t)GetProcAddress(library, name); }
#else
#include <dlfcn.h>
static void *library;
static void load(const char *path) { library = dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *symbol(const char *name) { return dlsym(library, name); }
#endif

typedef unsigned int vr_t;
static double step_size;
static char said[4096];
static int said_count;

static void fail(const char *what)
{
    printf("FAILED: %s (the unit says: %s)\n", what, said);
    exit(1);
}

static void *need(const char *name)
{
    void *found = symbol(name);
    if (found == NULL) {
        fail(name);
    }
    return found;
}

/* One function pointer of each call that is made; `F(name)(...)` calls it. */
#define CALL(result, name, arguments) result (*name) arguments = (result (*) arguments)need(#name)

#if FMI == 2

typedef int whole_t;
typedef int truth_t;
typedef struct { void *logger, *allocate, *release, *finished, *environment; } callbacks_t;

static void logger(void *environment, const char *name, int status, const char *category, const char *format, ...)
{
    va_list rest;
    (void)environment; (void)status;
    if (strcmp(category, "logStatusError") != 0 || name == NULL) { fail("the category of a message"); }
    va_start(rest, format);
    vsnprintf(said, sizeof said, format, rest);
    va_end(rest);
    said_count++;
}

static callbacks_t callbacks = { (void *)logger, NULL, NULL, NULL, NULL };

static void *instantiate(const char *name, const char *token)
{
    CALL(void *, fmi2Instantiate, (const char *, int, const char *, const char *, callbacks_t *, int, int));
    return fmi2Instantiate(name, 1, token, "file:///nowhere", &callbacks, 0, 0);
}
static int initialize(void *c, double start, int ends, double end)
{
    CALL(int, fmi2SetupExperiment, (void *, int, double, double, int, double));
    CALL(int, fmi2EnterInitializationMode, (void *));
    CALL(int, fmi2ExitInitializationMode, (void *));
    int status = fmi2SetupExperiment(c, 0, 0.0, start, ends, end);
    status |= fmi2EnterInitializationMode(c);
    return status | fmi2ExitInitializationMode(c);
}
static int do_step(void *c, double at, double size)
{
    CALL(int, fmi2DoStep, (void *, double, double, int));
    return fmi2DoStep(c, at, size, 1);
}
static int get_real(void *c, const vr_t *r, size_t n, double *v)
{
    CALL(int, fmi2GetReal, (void *, const vr_t *, size_t, double *));
    return fmi2GetReal(c, r, n, v);
}
static int set_real(void *c, const vr_t *r, size_t n, const double *v)
{
    CALL(int, fmi2SetReal, (void *, const vr_t *, size_t, const double *));
    return fmi2SetReal(c, r, n, v);
}
/* Whole numbers of any type, by the type's letter. */
static int get_whole(void *c, vr_t r, char type, int64_t *v)
{
    CALL(int, fmi2GetInteger, (void *, const vr_t *, size_t, int *));
    CALL(int, fmi2GetBoolean, (void *, const vr_t *, size_t, int *));
    int value = 0, status;
    if (type == 'l') {
        double real = 0.0;
        status = get_real(c, &r, 1, &real);
        *v = (int64_t)real;
        return status;
    }
    status = type == 'b' ? fmi2GetBoolean(c, &r, 1, &value) : fmi2GetInteger(c, &r, 1, &value);
    *v = value;
    return status;
}
static int set_whole(void *c, vr_t r, char type, int64_t v)
{
    CALL(int, fmi2SetInteger, (void *, const vr_t *, size_t, const int *));
    CALL(int, fmi2SetBoolean, (void *, const vr_t *, size_t, const int *));
    int value = (int)v;
    if (type == 'l') {
        double real = (double)v;
        return set_real(c, &r, 1, &real);
    }
    return type == 'b' ? fmi2SetBoolean(c, &r, 1, &value) : fmi2SetInteger(c, &r, 1, &value);
}
#define NAME(two, three) two

#else

static void logger(void *environment, int status, const char *category, const char *message)
{
    (void)environment; (void)status;
    if (strcmp(category, "logStatusError") != 0) { fail("the category of a message"); }
    snprintf(said, sizeof said, "%s", message);
    said_count++;
}

static void *instantiate(const char *name, const char *token)
{
    CALL(void *, fmi3InstantiateCoSimulation, (const char *, const char *, const char *, bool, bool, bool, bool,
                                               const vr_t *, size_t, void *, void *, void *));
    return fmi3InstantiateCoSimulation(name, token, "/nowhere/", false, false, false, false, NULL, 0, NULL, (void *)logger, NULL);
}
static int initialize(void *c, double start, int ends, double end)
{
    CALL(int, fmi3EnterInitializationMode, (void *, bool, double, double, bool, double));
    CALL(int, fmi3ExitInitializationMode, (void *));
    int status = fmi3EnterInitializationMode(c, false, 0.0, start, ends != 0, end);
    return status | fmi3ExitInitializationMode(c);
}
static int do_step(void *c, double at, double size)
{
    CALL(int, fmi3DoStep, (void *, double, double, bool, bool *, bool *, bool *, double *));
    bool events, terminate, early;
    double reached;
    return fmi3DoStep(c, at, size, true, &events, &terminate, &early, &reached);
}
static int get_real(void *c, const vr_t *r, size_t n, double *v)
{
    CALL(int, fmi3GetFloat64, (void *, const vr_t *, size_t, double *, size_t));
    return fmi3GetFloat64(c, r, n, v, n);
}
static int set_real(void *c, const vr_t *r, size_t n, const double *v)
{
    CALL(int, fmi3SetFloat64, (void *, const vr_t *, size_t, const double *, size_t));
    return fmi3SetFloat64(c, r, n, v, n);
}
static int get_whole(void *c, vr_t r, char type, int64_t *v)
{
    CALL(int, fmi3GetInt32, (void *, const vr_t *, size_t, int32_t *, size_t));
    CALL(int, fmi3GetInt64, (void *, const vr_t *, size_t, int64_t *, size_t));
    CALL(int, fmi3GetBoolean, (void *, const vr_t *, size_t, bool *, size_t));
    int status;
    if (type == 'b') {
        bool value = false;
        status = fmi3GetBoolean(c, &r, 1, &value, 1);
        *v = value;
    } else if (type == 'i') {
        int32_t value = 0;
        status = fmi3GetInt32(c, &r, 1, &value, 1);
        *v = value;
    } else {
        status = fmi3GetInt64(c, &r, 1, v, 1);
    }
    return status;
}
static int set_whole(void *c, vr_t r, char type, int64_t v)
{
    CALL(int, fmi3SetInt32, (void *, const vr_t *, size_t, const int32_t *, size_t));
    CALL(int, fmi3SetInt64, (void *, const vr_t *, size_t, const int64_t *, size_t));
    CALL(int, fmi3SetBoolean, (void *, const vr_t *, size_t, const bool *, size_t));
    if (type == 'b') {
        bool value = v != 0;
        return fmi3SetBoolean(c, &r, 1, &value, 1);
    }
    if (type == 'i') {
        int32_t value = (int32_t)v;
        return fmi3SetInt32(c, &r, 1, &value, 1);
    }
    return fmi3SetInt64(c, &r, 1, &v, 1);
}
#define NAME(two, three) three

#endif

/* What both versions have under names that differ a little. */
static int state_call(const char *name, void *c, void **state) { return ((int (*)(void *, void **))need(name))(c, state); }
static int get_state(void *c, void **s) { return state_call(NAME("fmi2GetFMUstate", "fmi3GetFMUState"), c, s); }
static int free_state(void *c, void **s) { return state_call(NAME("fmi2FreeFMUstate", "fmi3FreeFMUState"), c, s); }
static int set_state(void *c, void *s)
{
    return ((int (*)(void *, void *))need(NAME("fmi2SetFMUstate", "fmi3SetFMUState")))(c, s);
}
static int state_size(void *c, void *s, size_t *n)
{
    return ((int (*)(void *, void *, size_t *))need(NAME("fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize")))(c, s, n);
}
static int to_bytes(void *c, void *s, char *b, size_t n)
{
    return ((int (*)(void *, void *, char *, size_t))need(NAME("fmi2SerializeFMUstate", "fmi3SerializeFMUState")))(c, s, b, n);
}
static int from_bytes(void *c, const char *b, size_t n, void **s)
{
    return ((int (*)(void *, const char *, size_t, void **))need(NAME("fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState")))(c, b, n, s);
}
static int plain(const char *name, void *c) { return ((int (*)(void *))need(name))(c); }
static int reset(void *c) { return plain(NAME("fmi2Reset", "fmi3Reset"), c); }
static int terminate(void *c) { return plain(NAME("fmi2Terminate", "fmi3Terminate"), c); }
static void free_instance(void *c) { ((void (*)(void *))need(NAME("fmi2FreeInstance", "fmi3FreeInstance")))(c); }

/* A state of its own memory, by way of its bytes. */
static void rewrite(void *c, void **state)
{
    size_t size = 0;
    void *other = NULL;
    char *bytes;
    if (state_size(c, *state, &size) != 0 || size == 0) { fail("size of a state"); }
    bytes = malloc(size);
    if (to_bytes(c, *state, bytes, size) != 0 || free_state(c, state) != 0 || *state != NULL
        || from_bytes(c, bytes, size, &other) != 0) {
        fail("a state as bytes");
    }
    free(bytes);
    *state = other;
}

static void play(const char *token, FILE *tape)
{
    static vr_t watched[2000];
    static char types[2000];
    static void *instances[16], *states[16];
    static double times[16], saved_times[16];
    int count = 0, now = 0;
    char line[256], type;
    unsigned reference;
    int n;
    uint64_t bits;
    int64_t whole;
    while (fgets(line, sizeof line, tape) != NULL) {
        void *c = instances[now];
        if (sscanf(line, "watch %u %c", &reference, &type) == 2) {
            watched[count] = reference;
            types[count] = type;
            count++;
        } else if (sscanf(line, "new %d", &n) == 1) {
            char name[32];
            snprintf(name, sizeof name, "unit %d", n);
            now = n;
            times[n] = 0.0;
            instances[n] = instantiate(name, token);
            if (instances[n] == NULL || initialize(instances[n], 0.0, 0, 0.0) != 0) { fail("a new instance"); }
        } else if (sscanf(line, "use %d", &n) == 1) {
            now = n;
        } else if (sscanf(line, "set %u r %" SCNx64, &reference, &bits) == 2) {
            double value;
            memcpy(&value, &bits, sizeof value);
            if (set_real(c, &reference, 1, &value) != 0) { fail(line); }
        } else if (sscanf(line, "set %u %c %" SCNd64, &reference, &type, &whole) == 3) {
            if (set_whole(c, reference, type, whole) != 0) { fail(line); }
        } else if (sscanf(line, "step %d", &n) == 1) {
            int before = said_count;
            int status = do_step(c, times[now], n * step_size);
            if (status == 0) { times[now] += n * step_size; }
            if (said_count > before) { printf("! %s\n", said); }
            printf("=%d", status);
            for (int i = 0; i < count; i++) {
                if (types[i] == 'r') {
                    double value = 0.0;
                    if (get_real(c, &watched[i], 1, &value) != 0) { fail("a value"); }
                    memcpy(&bits, &value, sizeof bits);
                    printf(" %016" PRIx64, bits);
                } else {
                    if (get_whole(c, watched[i], types[i], &whole) != 0) { fail("a value"); }
                    printf(" %" PRId64, whole);
                }
            }
            printf("\n");
        } else if (strncmp(line, "reset", 5) == 0) {
            times[now] = 0.0;
            if (reset(c) != 0 || initialize(c, 0.0, 0, 0.0) != 0) { fail("reset"); }
        } else if (sscanf(line, "save %d", &n) == 1) {
            saved_times[n] = times[now];
            if (get_state(c, &states[n]) != 0) { fail("a saved state"); }
        } else if (sscanf(line, "load %d", &n) == 1) {
            times[now] = saved_times[n];
            if (set_state(c, states[n]) != 0) { fail("a state set back"); }
        } else if (sscanf(line, "bytes %d", &n) == 1) {
            rewrite(c, &states[n]);
        } else {
            fail(line);
        }
    }
    for (int i = 0; i < 16; i++) {
        if (states[i] != NULL) { free_state(instances[0], &states[i]); }
    }
    for (int i = 0; i < 16; i++) {
        if (instances[i] != NULL) { free_instance(instances[i]); }
    }
}

/* A call must be refused, with a word about it. */
#define REFUSED(call, part)                                                                     \
    do {                                                                                        \
        int words = said_count;                                                                 \
        if ((call) != 3) { fail("not refused: " #call); }                                       \
        if (said_count != words + 1 || strstr(said, part) == NULL) { fail("no word: " #call); } \
    } while (0)
/* The same where there is no instance that could say something. */
#define LOST(call)                                              \
    do {                                                        \
        if ((call) != 3) { fail("not refused: " #call); }       \
    } while (0)
#define GOOD(call)                                              \
    do {                                                        \
        if ((call) != 0) { fail("refused: " #call); }           \
    } while (0)

/* Value references of a machine with operations, a signal at wire 1 and properties. */
enum { ENABLED = 1, SECONDS = 2, STEPS = 4, VERDICT = 5, OPERATION = 6, GIVEN = 0x200000, RESULTS = 0x300000, WIRES = 0x400000 };

static void check(const char *token)
{
    static void *many[1100];
    double h = step_size, value = 0.0;
    int64_t whole = 0;
    vr_t reference, unknown[] = { 12, 4242, 0x0fffff, 0x1fffff, 0x2fffff, 0x4fffff, 0x500000, 0xffffffffU };
    size_t size = 0;
    void *state = NULL, *other = NULL;
    char *bytes;
    int count = 0;

    if (instantiate("unit", "{00000000-0000-0000-0000-000000000000}") != NULL || strstr(said, token) == NULL) { fail("a wrong token"); }
    if (instantiate("unit", NULL) != NULL || instantiate("", token) != NULL || instantiate(NULL, token) != NULL) { fail("no name"); }
    void *c = instantiate("100 % unit", token);
    if (c == NULL) { fail("an instance"); }

    /* Before the initialization. */
    REFUSED(do_step(c, 0.0, h), "before the initialization");
    REFUSED(terminate(c), "before the initialization");
    GOOD(set_whole(c, OPERATION, 'e', 1));
    GOOD(initialize(c, 0.0, 1, 1000 * h));
    REFUSED(plain(NAME("fmi2ExitInitializationMode", "fmi3ExitInitializationMode"), c), "after the initialization");

    /* Pointers that are no instances. */
    LOST(do_step(NULL, 0.0, h));
    LOST(do_step((void *)1, 0.0, h));
    LOST(do_step((void *)(intptr_t)-1, 0.0, h));
    LOST(do_step((char *)c + 1, 0.0, h));
    LOST(do_step(&h, 0.0, h));
    LOST(reset((void *)token));
    free_instance(NULL);
    free_instance(&h);

    /* Steps of a wrong size, at a wrong time. */
    double sizes[] = { 0.0, -h, 0.5 * h, 1.5 * h, h * 1.001, -HUGE_VAL, (double)NAN };
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        REFUSED(do_step(c, 0.0, sizes[i]), "integer multiple");
    }
    double lengths[] = { 1.1e9 * h, 1e300, HUGE_VAL };
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        REFUSED(do_step(c, 0.0, lengths[i]), "longer than 1000000000");
    }
    double places[] = { h, -h, 1e300, HUGE_VAL, (double)NAN };
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        REFUSED(do_step(c, places[i], h), "does not begin at the end");
    }
    REFUSED(do_step(c, 0.0, 2000 * h), "stop time");

    /* Values that are not there, of another type, not to be set, or outside their domain. */
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++) {
        reference = unknown[i];
        REFUSED(get_real(c, &reference, 1, &value), "no variable");
        REFUSED(set_real(c, &reference, 1, &value), "no variable");
        REFUSED(get_whole(c, reference, 'b', &whole), "no variable");
        REFUSED(set_whole(c, reference, 'i', 0), "no variable");
    }
    reference = ENABLED;
    REFUSED(get_real(c, &reference, 1, &value), "another type");
    REFUSED(get_whole(c, GIVEN, 'b', &whole), "another type");
    REFUSED(set_whole(c, SECONDS, 'i', 1), "another type");
    reference = SECONDS;
    REFUSED(set_real(c, &reference, 1, &value), "only inputs");
    REFUSED(set_whole(c, VERDICT, 'i', 1), "only inputs");
    REFUSED(set_whole(c, STEPS, 'l', 1), "only inputs");
    reference = RESULTS;
    REFUSED(set_real(c, &reference, 1, &value), "only inputs");
    REFUSED(set_whole(c, OPERATION, 'e', 0), "counts from 1");
    REFUSED(set_whole(c, OPERATION, 'e', 1000), "counts from 1");
    REFUSED(set_whole(c, OPERATION, 'e', -2147483647 - 1), "counts from 1");
    REFUSED(get_real(c, NULL, 1, &value), "missing");
    REFUSED(get_real(c, &reference, 1, NULL), "missing");
    GOOD(get_real(c, NULL, 0, NULL));
    double odd[] = { (double)NAN, HUGE_VAL, -HUGE_VAL };
    reference = GIVEN;
    for (size_t i = 0; i < 3; i++) {
        REFUSED(set_real(c, &reference, 1, &odd[i]), "not a finite number");
    }
#if FMI == 2
    REFUSED(set_whole(c, ENABLED, 'b', 2), "enabled");
    REFUSED(plain("fmi2CancelStep", c), "does not support");
    {
        CALL(int, fmi2GetRealStatus, (void *, int, double *));
        CALL(int, fmi2GetBooleanStatus, (void *, int, int *));
        CALL(int, fmi2GetString, (void *, const vr_t *, size_t, const char **));
        CALL(void *, fmi2Instantiate, (const char *, int, const char *, const char *, callbacks_t *, int, int));
        const char *text;
        int truth = 7;
        GOOD(fmi2GetRealStatus(c, 2, &value));
        GOOD(fmi2GetBooleanStatus(c, 3, &truth));
        if (value != 0.0 || truth != 0) { fail("status"); }
        REFUSED(fmi2GetRealStatus(c, 0, &value), "kind");
        REFUSED(fmi2GetString(c, &reference, 1, &text), "another type");
        if (fmi2Instantiate("unit", 0, token, NULL, &callbacks, 0, 0) != NULL || strstr(said, "only co-simulation") == NULL) {
            fail("model exchange");
        }
        /* A host without callbacks is told nothing. */
        if (fmi2Instantiate("unit", 1, "wrong", NULL, NULL, 0, 0) != NULL) { fail("no callbacks"); }
    }
    if (strcmp(((const char *(*)(void))need("fmi2GetVersion"))(), "2.0") != 0
        || strcmp(((const char *(*)(void))need("fmi2GetTypesPlatform"))(), "default") != 0) { fail("version"); }
#else
    REFUSED(plain("fmi3EnterEventMode", c), "does not support");
    REFUSED(plain("fmi3EnterConfigurationMode", c), "does not support");
    {
        CALL(int, fmi3GetFloat64, (void *, const vr_t *, size_t, double *, size_t));
        CALL(int, fmi3GetString, (void *, const vr_t *, size_t, const char **, size_t));
        CALL(int, fmi3DoStep, (void *, double, double, bool, bool *, bool *, bool *, double *));
        const char *text;
        REFUSED(fmi3GetFloat64(c, &reference, 1, &value, 2), "the number of values differs");
        REFUSED(fmi3GetString(c, &reference, 1, &text, 1), "another type");
        REFUSED(fmi3DoStep(c, 0.0, h, true, NULL, NULL, NULL, NULL), "missing");
    }
    if (strcmp(((const char *(*)(void))need("fmi3GetVersion"))(), "3.0") != 0) { fail("version"); }
#endif

    /* After all that the unit is as it was, and steps. */
    reference = SECONDS;
    GOOD(get_real(c, &reference, 1, &value));
    if (value != 0.0) { fail("something was changed"); }
    GOOD(do_step(c, 0.0, h));
    GOOD(do_step(c, h, 3 * h));
    GOOD(get_whole(c, STEPS, 'l', &whole));
    if (whole != 4) { fail("four steps"); }

    /* States that are none. */
    GOOD(get_state(c, &state));
    GOOD(state_size(c, state, &size));
    bytes = malloc(size);
    GOOD(to_bytes(c, state, bytes, size));
    REFUSED(set_state(c, NULL), "does not belong to this unit");
    REFUSED(set_state(c, (void *)memset(malloc(size), 0, size)), "does not belong to this unit");
    REFUSED(to_bytes(c, state, bytes, size - 1), "too small");
    REFUSED(to_bytes(c, state, NULL, size), "too small");
    REFUSED(get_state(c, NULL), "the pointer for the state");
    REFUSED(from_bytes(c, bytes, size - 1, &other), "do not have the size");
    for (size_t i = 0; i < size; i += 97) {
        bytes[i] = (char)(bytes[i] ^ 1);
        REFUSED(from_bytes(c, bytes, size, &other), "do not belong to this unit");
        bytes[i] = (char)(bytes[i] ^ 1);
    }
    GOOD(from_bytes(c, bytes, size, &other));
    GOOD(do_step(c, 4 * h, h));
    GOOD(set_state(c, other));
    GOOD(get_whole(c, STEPS, 'l', &whole));
    if (whole != 4) { fail("a state set back"); }
    GOOD(free_state(c, &state));
    GOOD(free_state(c, &state));
    GOOD(free_state(c, &other));
    GOOD(free_state(c, NULL));

    /* The end, and a new beginning. */
    GOOD(terminate(c));
    REFUSED(do_step(c, 4 * h, h), "terminated");
    REFUSED(set_whole(c, ENABLED, 'b', 1), "terminated");
    GOOD(get_whole(c, STEPS, 'l', &whole));
    GOOD(reset(c));
    GOOD(initialize(c, 5.0, 0, 0.0));
    GOOD(do_step(c, 5.0, h));

    /* Many at once, and those that were freed stay dead. */
    while (count < 1100 && (many[count] = instantiate("one of many", token)) != NULL) {
        count++;
    }
    if (count < 1000 || count >= 1100 || strstr(said, "all slots") == NULL) { fail("a thousand instances"); }
    for (int i = 0; i < count; i++) {
        GOOD(initialize(many[i], 0.0, 0, 0.0));
        GOOD(set_whole(many[i], ENABLED, 'b', i % 2));
        GOOD(do_step(many[i], 0.0, h));
    }
    for (int i = 0; i < count; i++) {
        GOOD(get_whole(many[i], STEPS, 'l', &whole));
        if (whole != i % 2) { fail("instances are apart"); }
    }
    for (int i = 0; i < count; i++) {
        free_instance(many[i]);
    }
    for (int i = 0; i < 100; i++) {
        void *again = instantiate("again", token);
        LOST(do_step(many[i], h, h));
        GOOD(initialize(again, 0.0, 0, 0.0));
        free_instance(again);
        free_instance(again);
    }
    free_instance(c);
    LOST(do_step(c, 5.0 + h, h));
    free(bytes);
}

int main(int argc, char **argv)
{
    if (argc < 5) { fail("arguments: play|check LIBRARY TOKEN STEP [TAPE]"); }
    load(argv[2]);
    if (library == NULL) { fail("the library cannot be loaded"); }
    step_size = strtod(argv[4], NULL);
    if (strcmp(argv[1], "play") == 0) {
        FILE *tape = argc == 6 ? fopen(argv[5], "r") : NULL;
        if (tape == NULL) { fail("the tape cannot be read"); }
        play(argv[3], tape);
        fclose(tape);
    } else {
        check(argv[3]);
    }
    printf("HOST PASSED\n");
    return 0;
}
