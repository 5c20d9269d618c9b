/* What differs between Windows and POSIX: libraries, threads, and the memory of a process. */
#include "host.h"

#include <stdio.h>
#include <string.h>

#if defined(_WIN32)
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
/* The functions of psapi that kernel32 has, so that no further library is linked. */
#define PSAPI_VERSION 2
#include <windows.h>

#include <psapi.h>
#else
#include <dlfcn.h>
#include <pthread.h>
#include <unistd.h>
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#else
#define SANITIZED 0
#endif

/* ---- Libraries --------------------------------------------------------------------------------------------------- */

void *module_load(const char *path)
{
#if defined(_WIN32)
    return (void *)LoadLibraryA(path);
#else
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
#endif
}

void module_unload(void *module)
{
#if defined(_WIN32)
    if (!FreeLibrary((HMODULE)module)) {
        fail("FreeLibrary: error %lu", (unsigned long)GetLastError());
    }
#else
    if (dlclose(module) != 0) {
        fail("dlclose: %s", dlerror());
    }
#endif
}

int module_present(const char *path)
{
#if defined(_WIN32)
    return GetModuleHandleA(path) != NULL;
#else
    void *module = dlopen(path, RTLD_NOW | RTLD_NOLOAD);
    if (module == NULL) {
        return 0;
    }
    dlclose(module);
    return 1;
#endif
}

int module_find(void *module, const char *name, void *function)
{
    /* C99 knows no conversion between pointers to objects and to functions, so the bytes are copied. */
#if defined(_WIN32)
    FARPROC symbol = GetProcAddress((HMODULE)module, name);
#else
    void *symbol = dlsym(module, name);
#endif
    if (symbol == NULL) {
        return 0;
    }
    memcpy(function, &symbol, sizeof symbol);
    return 1;
}

/* ---- Memory ------------------------------------------------------------------------------------------------------ */

int64_t memory_in_use(void)
{
    int64_t bytes = 0;
    if (SANITIZED) {
        return 0;
    }
#if defined(_WIN32)
    PROCESS_MEMORY_COUNTERS counters;
    memset(&counters, 0, sizeof counters);
    if (GetProcessMemoryInfo(GetCurrentProcess(), &counters, (DWORD)sizeof counters)) {
        bytes = (int64_t)counters.PagefileUsage;
    }
#else
    long pages = 0;
    long resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file != NULL) {
        if (fscanf(file, "%ld %ld", &pages, &resident) == 2) {
            bytes = (int64_t)resident * (int64_t)sysconf(_SC_PAGESIZE);
        }
        fclose(file);
    }
#endif
    return bytes;
}

/* ---- Threads ----------------------------------------------------------------------------------------------------- */

typedef struct job {
    void (*work)(int thread);
    int thread;
} job;

#if defined(_WIN32)

static SRWLOCK host_lock = SRWLOCK_INIT;

void lock_take(void)
{
    AcquireSRWLockExclusive(&host_lock);
}

void lock_give(void)
{
    ReleaseSRWLockExclusive(&host_lock);
}

static DWORD WINAPI thread_main(LPVOID argument)
{
    const job *own = (const job *)argument;
    own->work(own->thread);
    return 0;
}

void threads_run(int threads, void (*work)(int thread))
{
    HANDLE running[MOST_THREADS];
    job jobs[MOST_THREADS];
    for (int i = 0; i < threads; i++) {
        jobs[i].work = work;
        jobs[i].thread = i;
        running[i] = CreateThread(NULL, 0, thread_main, &jobs[i], 0, NULL);
        if (running[i] == NULL) {
            fail("CreateThread: error %lu", (unsigned long)GetLastError());
        }
    }
    for (int i = 0; i < threads; i++) {
        WaitForSingleObject(running[i], INFINITE);
        CloseHandle(running[i]);
    }
}

#else

static pthread_mutex_t host_lock = PTHREAD_MUTEX_INITIALIZER;

void lock_take(void)
{
    pthread_mutex_lock(&host_lock);
}

void lock_give(void)
{
    pthread_mutex_unlock(&host_lock);
}

static void *thread_main(void *argument)
{
    const job *own = (const job *)argument;
    own->work(own->thread);
    return NULL;
}

void threads_run(int threads, void (*work)(int thread))
{
    pthread_t running[MOST_THREADS];
    job jobs[MOST_THREADS];
    for (int i = 0; i < threads; i++) {
        jobs[i].work = work;
        jobs[i].thread = i;
        if (pthread_create(&running[i], NULL, thread_main, &jobs[i]) != 0) {
            fail("a thread cannot be started");
        }
    }
    for (int i = 0; i < threads; i++) {
        pthread_join(running[i], NULL);
    }
}

#endif
