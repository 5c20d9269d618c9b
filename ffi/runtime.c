/* The runtime of a station library: its instances, and the exports of station.h.
 *
 * Instances live in a fixed array, so no memory is allocated and an old handle never points to
 * freed memory. The table's lock guards which slots are in use; each slot has a lock for its
 * instance. */
#include "step.c"

#if defined(_WIN32)
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <windows.h>
typedef SRWLOCK lw_lock;
#define LW_LOCK_INITIALIZER SRWLOCK_INIT
#define lw_lock_create(lock) InitializeSRWLock(lock)
#define lw_lock_take(lock) AcquireSRWLockExclusive(lock)
#define lw_lock_give(lock) ReleaseSRWLockExclusive(lock)
#define lw_read(at) InterlockedCompareExchange((at), 0, 0)
#define lw_set(at, value) ((void)InterlockedExchange((at), (value)))
typedef volatile LONG lw_count;

/* A number that depends on the finest clock and on the process. */
static uint64_t lw_entropy(void)
{
    LARGE_INTEGER ticks;
    FILETIME now;
    QueryPerformanceCounter(&ticks);
    GetSystemTimeAsFileTime(&now);
    /* The two clocks can advance in step: their sum then still changes, but the exclusive or of
     * their bits might not. */
    return (uint64_t)ticks.QuadPart + ((uint64_t)now.dwHighDateTime << 32 | now.dwLowDateTime)
           + ((uint64_t)GetCurrentProcessId() << 44);
}
#else
#include <pthread.h>
#include <sys/time.h>
#include <unistd.h>
typedef pthread_mutex_t lw_lock;
#define LW_LOCK_INITIALIZER PTHREAD_MUTEX_INITIALIZER
#define lw_lock_create(lock) ((void)pthread_mutex_init((lock), NULL))
#define lw_lock_take(lock) ((void)pthread_mutex_lock(lock))
#define lw_lock_give(lock) ((void)pthread_mutex_unlock(lock))
#define lw_read(at) __atomic_load_n((at), __ATOMIC_ACQUIRE)
#define lw_set(at, value) __atomic_store_n((at), (value), __ATOMIC_RELEASE)
typedef int lw_count;

/* A number that depends on the time in microseconds (reloading a library takes longer) and on the
 * process. */
static uint64_t lw_entropy(void)
{
    struct timeval now = {0, 0};
    (void)gettimeofday(&now, NULL);
    return ((uint64_t)now.tv_sec * 1000000U + (uint64_t)now.tv_usec) ^ (uint64_t)getpid() << 44;
}
#endif

/* For the tests: a library without locks, in which a thread sanitizer must find data races. */
#ifdef LW_NO_LOCKS
#undef lw_lock_take
#undef lw_lock_give
#define lw_lock_take(lock) ((void)(lock))
#define lw_lock_give(lock) ((void)(lock))
#endif

/* ---- Instances ------------------------------------------------------------------------------- */

/* A handle consists of 10 bits of the machine's mark, 11 bits of generation and 10 bits of place. A
 * place whose generations are used up waits until those of all free places are; then they begin
 * again. A model can hold handles that were saved in another process, or before the library was
 * reloaded; such a handle must not reach an instance. Generation and place therefore begin at other
 * numbers each time the library is loaded: the probability that an old handle equals the handle of
 * a given new instance is one in two million. */
#define LW_SLOTS 1024
#define LW_GENERATIONS 2047

typedef struct lw_slot {
    lw_lock lock;
    int live;
    int32_t generation; /* 0 if the place has used no generation yet, or begins again */
    int32_t verdict; /* result of the last step or operation: 0 or an error code */
    int has_results; /* whether the results below are those of an operation */
    lw_stored_state state;
    lw_service service;
    double control; /* seconds of `service` in which no action was active */
    double properties[LW_PROPERTIES + 1];
    lw_error error;
} lw_slot;

static lw_slot lw_slots[LW_SLOTS];
/* Number of slots that have a lock. It only grows, and a slot is initialized before it is
 * counted. */
static lw_count lw_slots_used;
static lw_lock lw_table_lock = LW_LOCK_INITIALIZER;
/* First generation and place of handles; the generation is 0 until the first instance. */
static int32_t lw_first_generation;
static int lw_first_place;

/* Errors of calls without a valid handle. Each text is a constant, so a text that was passed to a
 * host never changes. */
enum lw_library_error { LW_LIBRARY_OK, LW_LIBRARY_HANDLE, LW_LIBRARY_ARGUMENT, LW_LIBRARY_FULL, LW_LIBRARY_ERRORS };
static const char *const lw_library_texts[LW_LIBRARY_ERRORS] = {
    "",
    "the handle was never issued by this library, or its instance was destroyed",
    "the handle must be an integer",
    "all slots for instances are in use",
};
static enum lw_library_error lw_last_library_error;

/* Mixes the bits of a number: the finalizer of SplitMix64 (Steele, Lea and Flood 2014). */
static uint64_t lw_mix(uint64_t number)
{
    number += UINT64_C(0x9E3779B97F4A7C15);
    number = (number ^ number >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    number = (number ^ number >> 27) * UINT64_C(0x94D049BB133111EB);
    return number ^ number >> 31;
}

/* Chooses the first place and generation. On systems that randomize the memory layout, the
 * addresses differ between processes. */
static void lw_begin_handles(void)
{
    uint64_t chosen = lw_mix(lw_entropy());
    chosen = lw_mix(chosen ^ (uint64_t)(uintptr_t)lw_slots ^ (uint64_t)(uintptr_t)&chosen << 20);
    lw_first_place = (int)(chosen % LW_SLOTS);
    lw_first_generation = (int32_t)(chosen / LW_SLOTS % LW_GENERATIONS) + 1;
}

/* The generation that follows another one. */
static int32_t lw_next_generation(int32_t generation)
{
    return generation == 0 ? lw_first_generation : generation % LW_GENERATIONS + 1;
}

/* Whether the generations of a place are used up: the next one would be the first. */
static int lw_is_used_up(const lw_slot *slot)
{
    return slot->generation != 0 && lw_next_generation(slot->generation) == lw_first_generation;
}

/* The first place below `used` that is free and not used up; `used` if there is none. The table is
 * locked. */
static int lw_free_place(int used)
{
    int place = 0;
    while (place < used && (lw_slots[place].live || lw_is_used_up(&lw_slots[place]))) {
        place++;
    }
    return place;
}

/* Lets the generations of all free places that are used up begin again. The table is locked. */
static void lw_renew_places(void)
{
    for (int place = 0; place < LW_SLOTS; place++) {
        lw_slot *slot = &lw_slots[place];
        lw_lock_take(&slot->lock);
        if (!slot->live && lw_is_used_up(slot)) {
            slot->generation = 0;
        }
        lw_lock_give(&slot->lock);
    }
}

/* Expands the stored state of an instance for computations. */
static void lw_load_state(const lw_slot *slot, lw_state *state)
{
    state->started = slot->state.started;
    for (int c = 0; c < LW_COMPONENTS; c++) {
        state->place[c] = slot->state.place[c];
    }
    for (int i = 0; i < LW_VALUES; i++) {
        state->values[i] = slot->state.values[i];
    }
}

/* Stores the state of an instance in compact form. */
static void lw_store_state(lw_slot *slot, const lw_state *state)
{
    slot->state.started = state->started;
    for (int c = 0; c < LW_COMPONENTS; c++) {
        slot->state.place[c] = state->place[c];
    }
    for (int i = 0; i < LW_VALUES; i++) {
        slot->state.values[i] = (lw_number)state->values[i];
    }
}

/* Records an error of a call without a valid handle, and returns its code. */
static int32_t lw_fail_library(int32_t code, enum lw_library_error what)
{
    lw_lock_take(&lw_table_lock);
    lw_last_library_error = what;
    lw_lock_give(&lw_table_lock);
    return code;
}

/* Decodes a handle into the index of its slot. Returns 0 if it cannot be a handle of this library.
 * Slots are used in ascending order. */
static int lw_decode_handle(lw_handle handle, int *place)
{
    int used;
    if (handle <= 0 || (handle >> 21) != LW_HANDLE_MARK) {
        return 0;
    }
    /* The first place is chosen before the first slot is counted. */
    used = (int)lw_read(&lw_slots_used);
    if (used == 0) {
        return 0;
    }
    *place = (int)(((unsigned)handle - (unsigned)lw_first_place) & (LW_SLOTS - 1));
    return *place < used;
}

/* Locks and returns the instance of a handle; null if there is none. */
static lw_slot *lw_lock_instance(lw_handle handle)
{
    int place;
    if (lw_decode_handle(handle, &place)) {
        lw_slot *slot = &lw_slots[place];
        lw_lock_take(&slot->lock);
        if (slot->live && slot->generation == ((handle >> 10) & LW_GENERATIONS)) {
            return slot;
        }
        lw_lock_give(&slot->lock);
    }
    return NULL;
}

/* Like `lw_lock_instance`, but also records the library's error if there is no instance. */
static lw_slot *lw_require_instance(lw_handle handle)
{
    lw_slot *slot = lw_lock_instance(handle);
    if (slot == NULL) {
        lw_fail_library(LW_ERROR_HANDLE, LW_LIBRARY_HANDLE);
    }
    return slot;
}

int32_t lw_abi_version(void)
{
    return LW_ABI_VERSION;
}

const char *lw_describe(void)
{
    return lw_description;
}

int32_t lw_plant_count(void)
{
    return LW_PLANT;
}

int32_t lw_output_count(void)
{
    return LW_OUTPUTS;
}

int32_t lw_property_count(void)
{
    return LW_PROPERTIES;
}

int32_t lw_operation_count(void)
{
    return LW_OPERATIONS;
}

lw_handle lw_create(void)
{
    int place;
    int used;
    lw_handle handle;
    lw_lock_take(&lw_table_lock);
    used = (int)lw_read(&lw_slots_used);
    place = lw_free_place(used);
    if (place == LW_SLOTS) {
        lw_renew_places();
        place = lw_free_place(used);
    }
    if (place == LW_SLOTS) {
        lw_last_library_error = LW_LIBRARY_FULL;
        lw_lock_give(&lw_table_lock);
        return LW_ERROR_MEMORY;
    }
    lw_slot *slot = &lw_slots[place];
    if (place == used) {
        if (lw_first_generation == 0) {
            lw_begin_handles();
        }
        lw_lock_create(&slot->lock);
        lw_set(&lw_slots_used, used + 1);
    }
    lw_lock_take(&slot->lock);
    slot->live = 1;
    slot->generation = lw_next_generation(slot->generation);
    memset(&slot->state, 0, sizeof slot->state);
    slot->verdict = LW_OK;
    slot->has_results = 0;
    slot->error.pieces = 0;
    slot->error.rule = NULL;
    place = (place + lw_first_place) & (LW_SLOTS - 1);
    handle = (lw_handle)((LW_HANDLE_MARK << 21) | (slot->generation << 10) | place);
    lw_lock_give(&slot->lock);
    lw_lock_give(&lw_table_lock);
    return handle;
}

int32_t lw_destroy(lw_handle handle)
{
    /* lw_create reads `live` under the table's lock alone, so this function takes that lock
     * first. */
    int place;
    int32_t code = LW_ERROR_HANDLE;
    lw_lock_take(&lw_table_lock);
    if (lw_decode_handle(handle, &place)) {
        lw_slot *slot = &lw_slots[place];
        lw_lock_take(&slot->lock);
        if (slot->live && slot->generation == ((handle >> 10) & LW_GENERATIONS)) {
            slot->live = 0;
            code = LW_OK;
        }
        lw_lock_give(&slot->lock);
    }
    if (code != LW_OK) {
        lw_last_library_error = LW_LIBRARY_HANDLE;
    }
    lw_lock_give(&lw_table_lock);
    return code;
}

int32_t lw_reset(lw_handle handle)
{
    lw_slot *slot = lw_require_instance(handle);
    if (slot == NULL) {
        return LW_ERROR_HANDLE;
    }
    memset(&slot->state, 0, sizeof slot->state);
    lw_lock_give(&slot->lock);
    return LW_OK;
}

int32_t lw_step(lw_handle handle, const int64_t *plant, size_t plant_count, int64_t *outputs, size_t output_count)
{
    lw_slot *slot = lw_require_instance(handle);
    int32_t code;
    if (slot == NULL) {
        return LW_ERROR_HANDLE;
    }
    if (plant_count != (size_t)LW_PLANT || (plant == NULL && plant_count != 0)) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT,
                       "the plant values are missing, or their number differs from the machine's number of plant inputs");
    } else if (output_count != (outputs == NULL ? 0U : (size_t)LW_OUTPUTS)) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT,
                       "the size of the output array differs from the machine's number of outputs");
    } else {
        lw_state before;
        lw_state after;
        memset(&after, 0, sizeof after);
        lw_load_state(slot, &before);
        code = lw_check_plant(plant, &slot->error);
        if (code == LW_OK) {
            code = lw_advance(&before, plant, &after, &slot->error);
        }
        if (code == LW_OK) {
            lw_store_state(slot, &after);
            for (size_t i = 0; i < output_count; i++) {
                outputs[i] = after.values[lw_output_table[i].value];
            }
        }
    }
    slot->verdict = code;
    lw_lock_give(&slot->lock);
    return code;
}

/* Runs an operation and stores its results in the instance. The caller holds the instance's
 * lock. */
static int32_t lw_serve(lw_slot *slot, int32_t operation, const double *properties)
{
    double after[LW_PROPERTIES + 1];
    lw_service service;
    double control = 0.0;
    lw_state state;
    int32_t code;
    lw_load_state(slot, &state);
    code = lw_perform(&state, operation, properties, after, &service, &control, &slot->error);
    if (code == LW_OK || code == LW_ERROR_LIMIT) {
        lw_store_state(slot, &state);
    }
    if (code == LW_OK) {
        slot->has_results = 1;
        slot->service = service;
        slot->control = control;
        for (int i = 0; i < LW_PROPERTIES; i++) {
            slot->properties[i] = after[i];
        }
    }
    slot->verdict = code;
    return code;
}

int32_t lw_simulate(lw_handle handle, int32_t operation, double *properties, size_t property_count, lw_service *service)
{
    lw_slot *slot = lw_require_instance(handle);
    int32_t code;
    if (slot == NULL) {
        return LW_ERROR_HANDLE;
    }
    if (property_count != (size_t)LW_PROPERTIES || (properties == NULL && property_count != 0)) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT,
                       "the property values are missing, or their number differs from the machine's number of properties");
    } else {
        code = lw_serve(slot, operation, properties);
        if (code == LW_OK) {
            for (size_t i = 0; i < property_count; i++) {
                properties[i] = slot->properties[i];
            }
            if (service != NULL) {
                *service = slot->service;
            }
        }
    }
    slot->verdict = code;
    lw_lock_give(&slot->lock);
    return code;
}

/* Copies the text of an error, or the name of its rule if `rule` is not 0. */
static int32_t lw_read_error(lw_handle handle, int rule, char *text, size_t size)
{
    lw_text words;
    lw_slot *slot = lw_lock_instance(handle);
    if (slot == NULL) {
        lw_lock_take(&lw_table_lock);
    }
    words.length = 0;
    words.text[0] = '\0';
    if (slot == NULL) {
        lw_write(&words, rule ? "" : lw_library_texts[lw_last_library_error]);
    } else if (rule) {
        lw_write(&words, slot->error.rule == NULL ? "" : slot->error.rule);
    } else {
        lw_format_error(&slot->error, &words);
    }
    lw_lock_give(slot == NULL ? &lw_table_lock : &slot->lock);
    if (text != NULL && size > 0) {
        size_t copied = words.length < size ? words.length : size - 1;
        memcpy(text, words.text, copied);
        text[copied] = '\0';
    }
    return (int32_t)words.length;
}

int32_t lw_last_error(lw_handle handle, char *text, size_t size)
{
    return lw_read_error(handle, 0, text, size);
}

int32_t lw_last_rule(lw_handle handle, char *text, size_t size)
{
    return lw_read_error(handle, 1, text, size);
}
