/* The runtime of a station library: its instances, and the exports of station.h.
 *
 * Instances live in a fixed array, so nothing is allocated and an old handle never points at freed
 * memory. The table's lock guards which places are taken; each place has a lock for its instance.
 */
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

/* The finest clock there is, and the process. */
static uint64_t lw_moment(void)
{
    LARGE_INTEGER ticks;
    FILETIME now;
    QueryPerformanceCounter(&ticks);
    GetSystemTimeAsFileTime(&now);
    /* Both may tick alike: their sum changes with them, which the difference of their bits need
     * not. */
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

/* The time in microseconds, in which no library is unloaded and loaded again, and the process. */
static uint64_t lw_moment(void)
{
    struct timeval now = {0, 0};
    (void)gettimeofday(&now, NULL);
    return ((uint64_t)now.tv_sec * 1000000U + (uint64_t)now.tv_usec) ^ (uint64_t)getpid() << 44;
}
#endif

/* For the tests: a library without locks, which a thread sanitizer must complain about. */
#ifdef LW_NO_LOCKS
#undef lw_lock_take
#undef lw_lock_give
#define lw_lock_take(lock) ((void)(lock))
#define lw_lock_give(lock) ((void)(lock))
#endif

/* ---- Instances ------------------------------------------------------------------------------- */

/* A handle: 10 bits of the machine's mark, 11 bits of generation, 10 bits of place. A place whose
 * generations are used up is not given again. A model that was saved with handles of another
 * process, or that has kept those of a library that was unloaded since, must not end instances with
 * them. So both begin somewhere else each time that the library is loaded: of two million handles
 * that an instance may get, it is one that it had before by chance alone. */
#define LW_SLOTS 1024
#define LW_GENERATIONS 2047

typedef struct lw_slot {
    lw_lock lock;
    int live;
    int32_t generation;
    int32_t verdict; /* of the last step or operation: 0 or the code of its error */
    int ended;       /* an operation has ended: the two after the state hold its results */
    lw_rest state;
    lw_service service;
    double properties[LW_PROPERTIES + 1];
    lw_error error;
} lw_slot;

static lw_slot lw_slots[LW_SLOTS];
/* How many places have a lock. It only grows, and a place is ready before it is counted. */
static lw_count lw_slots_used;
static lw_lock lw_table_lock = LW_LOCK_INITIALIZER;
/* Where this process begins; the generation is 0 until the first instance. */
static int32_t lw_first_generation;
static int lw_first_place;

/* What can be wrong with a call that has no instance. Each text is a constant, so that one that was
 * given to a host stays as it is. */
enum lw_alone { LW_ALONE_FINE, LW_ALONE_HANDLE, LW_ALONE_KIND, LW_ALONE_ROOM, LW_ALONE_COUNT };
static const char *const lw_alone_texts[LW_ALONE_COUNT] = {
    "",
    "the handle was never given by this library, or its instance has been destroyed",
    "the handle must be an integer",
    "there is no free place for an instance",
};
static enum lw_alone lw_last_alone;

/* Bits that depend on all bits of a number: the finalizer of SplitMix64 (Steele, Lea and Flood
 * 2014). */
static uint64_t lw_mix(uint64_t number)
{
    number += UINT64_C(0x9E3779B97F4A7C15);
    number = (number ^ number >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    number = (number ^ number >> 27) * UINT64_C(0x94D049BB133111EB);
    return number ^ number >> 31;
}

/* Chooses where handles begin. The addresses differ from process to process where a system lays
 * memory out at random. */
static void lw_begin_handles(void)
{
    uint64_t chosen = lw_mix(lw_moment());
    chosen = lw_mix(chosen ^ (uint64_t)(uintptr_t)lw_slots ^ (uint64_t)(uintptr_t)&chosen << 20);
    lw_first_place = (int)(chosen % LW_SLOTS);
    lw_first_generation = (int32_t)(chosen / LW_SLOTS % LW_GENERATIONS) + 1;
}

/* The generation after another, and the one before the first: a place is used up when it comes to
 * that one. */
static int32_t lw_after(int32_t generation)
{
    return generation % LW_GENERATIONS + 1;
}

static int32_t lw_last_generation(void)
{
    return lw_first_generation == 1 ? LW_GENERATIONS : lw_first_generation - 1;
}

/* The state of an instance, to work with. */
static void lw_wake(const lw_slot *slot, lw_state *state)
{
    state->started = slot->state.started;
    for (int c = 0; c < LW_COMPONENTS; c++) {
        state->place[c] = slot->state.place[c];
    }
    for (int i = 0; i < LW_VALUES; i++) {
        state->values[i] = slot->state.values[i];
    }
}

/* Puts it back. */
static void lw_lay_down(lw_slot *slot, const lw_state *state)
{
    slot->state.started = state->started;
    for (int c = 0; c < LW_COMPONENTS; c++) {
        slot->state.place[c] = state->place[c];
    }
    for (int i = 0; i < LW_VALUES; i++) {
        slot->state.values[i] = (lw_number)state->values[i];
    }
}

/* An error of a call that has no instance. */
static int32_t lw_fail_alone(int32_t code, enum lw_alone what)
{
    lw_lock_take(&lw_table_lock);
    lw_last_alone = what;
    lw_lock_give(&lw_table_lock);
    return code;
}

/* Whether a handle may be one of this library's, and the place in its array then. Places are used
 * from the first one on. */
static int lw_is_ours(lw_handle handle, int *place)
{
    int used;
    if (handle <= 0 || (handle >> 21) != LW_HANDLE_MARK) {
        return 0;
    }
    /* The first place is chosen before any is counted. */
    used = (int)lw_read(&lw_slots_used);
    if (used == 0) {
        return 0;
    }
    *place = (int)(((unsigned)handle - (unsigned)lw_first_place) & (LW_SLOTS - 1));
    return *place < used;
}

/* The instance of a handle, locked; or null. */
static lw_slot *lw_enter_quietly(lw_handle handle)
{
    int place;
    if (lw_is_ours(handle, &place)) {
        lw_slot *slot = &lw_slots[place];
        lw_lock_take(&slot->lock);
        if (slot->live && slot->generation == ((handle >> 10) & LW_GENERATIONS)) {
            return slot;
        }
        lw_lock_give(&slot->lock);
    }
    return NULL;
}

/* The same, and the library's own error says why there is none. */
static lw_slot *lw_enter(lw_handle handle)
{
    lw_slot *slot = lw_enter_quietly(handle);
    if (slot == NULL) {
        lw_fail_alone(LW_ERROR_HANDLE, LW_ALONE_HANDLE);
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
    int place = 0;
    int used;
    lw_handle handle;
    lw_lock_take(&lw_table_lock);
    used = (int)lw_read(&lw_slots_used);
    while (place < used && (lw_slots[place].live || lw_slots[place].generation == lw_last_generation())) {
        place++;
    }
    if (place == LW_SLOTS) {
        lw_last_alone = LW_ALONE_ROOM;
        lw_lock_give(&lw_table_lock);
        return LW_ERROR_MEMORY;
    }
    lw_slot *slot = &lw_slots[place];
    if (place == used) {
        if (lw_first_generation == 0) {
            lw_begin_handles();
        }
        slot->generation = lw_last_generation();
        lw_lock_create(&slot->lock);
        lw_set(&lw_slots_used, used + 1);
    }
    lw_lock_take(&slot->lock);
    slot->live = 1;
    slot->generation = lw_after(slot->generation);
    memset(&slot->state, 0, sizeof slot->state);
    slot->verdict = LW_OK;
    slot->ended = 0;
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
    /* `live` is read by lw_create under the table's lock alone, so that one is taken first here. */
    int place;
    int32_t code = LW_ERROR_HANDLE;
    lw_lock_take(&lw_table_lock);
    if (lw_is_ours(handle, &place)) {
        lw_slot *slot = &lw_slots[place];
        lw_lock_take(&slot->lock);
        if (slot->live && slot->generation == ((handle >> 10) & LW_GENERATIONS)) {
            slot->live = 0;
            code = LW_OK;
        }
        lw_lock_give(&slot->lock);
    }
    if (code != LW_OK) {
        lw_last_alone = LW_ALONE_HANDLE;
    }
    lw_lock_give(&lw_table_lock);
    return code;
}

int32_t lw_reset(lw_handle handle)
{
    lw_slot *slot = lw_enter(handle);
    if (slot == NULL) {
        return LW_ERROR_HANDLE;
    }
    memset(&slot->state, 0, sizeof slot->state);
    lw_lock_give(&slot->lock);
    return LW_OK;
}

int32_t lw_step(lw_handle handle, const int64_t *plant, size_t plant_count, int64_t *outputs, size_t output_count)
{
    lw_slot *slot = lw_enter(handle);
    int32_t code;
    if (slot == NULL) {
        return LW_ERROR_HANDLE;
    }
    if (plant_count != (size_t)LW_PLANT || (plant == NULL && plant_count != 0)) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT,
                       "the plant's values are missing, or are not as many as the machine's plant inputs");
    } else if (output_count != (outputs == NULL ? 0U : (size_t)LW_OUTPUTS)) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT,
                       "the room for outputs is not as large as the machine's outputs");
    } else {
        lw_state before;
        lw_state after;
        memset(&after, 0, sizeof after);
        lw_wake(slot, &before);
        code = lw_check_plant(plant, &slot->error);
        if (code == LW_OK) {
            code = lw_advance(&before, plant, &after, &slot->error);
        }
        if (code == LW_OK) {
            lw_lay_down(slot, &after);
            for (size_t i = 0; i < output_count; i++) {
                outputs[i] = after.values[lw_output_table[i].value];
            }
        }
    }
    slot->verdict = code;
    lw_lock_give(&slot->lock);
    return code;
}

/* Runs an operation and keeps its results in the instance. The caller holds the instance's lock. */
static int32_t lw_serve(lw_slot *slot, int32_t operation, const double *properties)
{
    double after[LW_PROPERTIES + 1];
    lw_service service;
    lw_state state;
    int32_t code;
    lw_wake(slot, &state);
    code = lw_perform(&state, operation, properties, after, &service, &slot->error);
    if (code == LW_OK || code == LW_ERROR_LIMIT) {
        lw_lay_down(slot, &state);
    }
    if (code == LW_OK) {
        slot->ended = 1;
        slot->service = service;
        for (int i = 0; i < LW_PROPERTIES; i++) {
            slot->properties[i] = after[i];
        }
    }
    slot->verdict = code;
    return code;
}

int32_t lw_simulate(lw_handle handle, int32_t operation, double *properties, size_t property_count, lw_service *service)
{
    lw_slot *slot = lw_enter(handle);
    int32_t code;
    if (slot == NULL) {
        return LW_ERROR_HANDLE;
    }
    if (property_count != (size_t)LW_PROPERTIES || (properties == NULL && property_count != 0)) {
        code = lw_fail(&slot->error, LW_ERROR_ARGUMENT,
                       "the values are missing, or are not as many as the machine's properties");
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

/* Which of the two texts of an error is wanted. */
static int32_t lw_read_error(lw_handle handle, int rule, char *text, size_t size)
{
    lw_text words;
    lw_slot *slot = lw_enter_quietly(handle);
    if (slot == NULL) {
        lw_lock_take(&lw_table_lock);
    }
    words.length = 0;
    words.text[0] = '\0';
    if (slot == NULL) {
        lw_write(&words, rule ? "" : lw_alone_texts[lw_last_alone]);
    } else if (rule) {
        lw_write(&words, slot->error.rule == NULL ? "" : slot->error.rule);
    } else {
        lw_put_into_words(&slot->error, &words);
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
