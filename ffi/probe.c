/* The probe: finds the host's layout of UF_Value without accessing a field of it.
 *
 * Each export has the signature `void name(UF_Value *ret, UF_Value *arg)`. The accompanying SimTalk
 * method calls it with values that are known here. The export appends the raw bytes at `arg` and
 * `ret` to a dump, and the bytes to which addresses among them point; `linewright doctor --probe`
 * derives the layout from the dump. In the first round the probe writes nothing to `ret`, because
 * its layout is unknown. In the second round the probe is built with the profile that was found;
 * then it also returns values (the lw_confirm_... exports) and receives them back as arguments.
 *
 * The host does not pass the number of arguments, so the number of readable bytes after `arg` is
 * unknown. The probe therefore lets the system copy the bytes, because the system reports an error
 * for unreadable memory: on Windows with ReadProcessMemory, page by page and only if VirtualQuery
 * reports a readable page (a guard page must not be accessed); elsewhere with write() into a pipe,
 * which every sandbox allows. The probe reads at most LW_PROBE_ARGUMENT bytes for each argument and
 * for one more.
 *
 * The dump is the file that the environment variable LINEWRIGHT_PROBE_DUMP names, else the path of
 * the library with `.dump.txt` appended, else `linewright_probe.dump.txt` in the folder for
 * temporary files. The probe appends each call as a whole and closes the file again, so the dump
 * survives if the next call ends the host. The probe does not support several threads. */
#if !defined(_WIN32) && !defined(_GNU_SOURCE)
#define _GNU_SOURCE 1
#endif

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <windows.h>
#define LW_PROBE_EXPORT __declspec(dllexport)
#else
#include <dlfcn.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/syscall.h>
#endif
#define LW_PROBE_EXPORT __attribute__((visibility("default")))
#endif

#if !defined(LW_PROBE_CALLS)
#error "include probe.c from an emitted file, after the list of its calls"
#endif

#define LW_PROBE_PAGE 4096U
#define LW_PROBE_ARGUMENT 64U /* maximum size of a UF_Value */
#define LW_PROBE_MAX 512U
#define LW_PROBE_TEXT 96U    /* maximum number of bytes copied from an address */
#define LW_PROBE_POINTERS 64 /* maximum number of addresses followed in one call */

/* ---- Reading memory that can be unreadable --------------------------------------------------- */

#if defined(_WIN32)

/* Copies up to `size` bytes within one page, and returns their number. */
static size_t lw_probe_copy(uintptr_t from, unsigned char *to, size_t size)
{
    MEMORY_BASIC_INFORMATION page;
    SIZE_T copied = 0;
    if (VirtualQuery((const void *)from, &page, sizeof page) == 0 || page.State != MEM_COMMIT ||
        (page.Protect & (PAGE_NOACCESS | PAGE_GUARD)) != 0) {
        return 0;
    }
    if (!ReadProcessMemory(GetCurrentProcess(), (const void *)from, to, size, &copied)) {
        return 0;
    }
    return copied;
}

#else

static size_t lw_probe_copy(uintptr_t from, unsigned char *to, size_t size)
{
    int ends[2];
    size_t copied = 0;
    if (pipe(ends) != 0) {
        return 0;
    }
#if defined(__linux__)
    /* The system call is made directly, because a sanitizer in the host would check the bytes that
     * are passed to write(). */
    long written = syscall(SYS_write, ends[1], from, size);
#else
    ssize_t written = write(ends[1], (const void *)from, size);
#endif
    if (written > 0) {
        ssize_t got = read(ends[0], to, (size_t)written);
        copied = got > 0 ? (size_t)got : 0;
    }
    close(ends[0]);
    close(ends[1]);
    return copied;
}

#endif

/* Copies up to `size` bytes, until the first unreadable one, and returns their number. */
static size_t lw_probe_read(uintptr_t from, unsigned char *to, size_t size)
{
    size_t done = 0;
    while (done < size) {
        size_t within = LW_PROBE_PAGE - (size_t)((from + done) % LW_PROBE_PAGE);
        size_t wanted = size - done < within ? size - done : within;
        size_t copied = lw_probe_copy(from + done, to + done, wanted);
        done += copied;
        if (copied < wanted) {
            break;
        }
    }
    return done;
}

/* ---- The dump -------------------------------------------------------------------------------- */

static char lw_probe_block[32768];
static size_t lw_probe_length;

static void lw_probe_append(const char *text)
{
    size_t length = strlen(text);
    if (lw_probe_length + length < sizeof lw_probe_block) {
        memcpy(lw_probe_block + lw_probe_length, text, length);
        lw_probe_length += length;
    }
}

static void lw_probe_append_number(size_t number)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = '\0';
    do {
        digits[--at] = (char)('0' + number % 10U);
        number /= 10U;
    } while (number > 0);
    lw_probe_append(digits + at);
}

static void lw_probe_append_hex(const unsigned char *bytes, size_t size)
{
    static const char digits[] = "0123456789abcdef";
    char pair[3] = {0, 0, 0};
    for (size_t i = 0; i < size; i++) {
        pair[0] = digits[bytes[i] >> 4];
        pair[1] = digits[bytes[i] & 15];
        lw_probe_append(pair);
    }
}

#if defined(_WIN32)

static FILE *lw_probe_open(void)
{
    static const wchar_t ending[] = L".dump.txt";
    static const wchar_t name[] = L"linewright_probe.dump.txt";
    wchar_t path[1200];
    HMODULE own = NULL;
    FILE *file = NULL;
    DWORD length = GetEnvironmentVariableW(L"LINEWRIGHT_PROBE_DUMP", path, 1000);
    if (length > 0 && length < 1000) {
        return _wfopen(path, L"ab");
    }
    if (GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                           (const wchar_t *)(const void *)lw_probe_block, &own)) {
        length = GetModuleFileNameW(own, path, 1000);
        if (length > 0 && length < 1000) {
            memcpy(path + length, ending, sizeof ending);
            file = _wfopen(path, L"ab");
        }
    }
    if (file == NULL) {
        length = GetTempPathW(1000, path);
        if (length > 0 && length < 1000) {
            memcpy(path + length, name, sizeof name);
            file = _wfopen(path, L"ab");
        }
    }
    return file;
}

#else

static FILE *lw_probe_open(void)
{
    char path[4200];
    Dl_info own;
    FILE *file = NULL;
    const char *named = getenv("LINEWRIGHT_PROBE_DUMP");
    if (named != NULL && named[0] != '\0') {
        return fopen(named, "ab");
    }
    if (dladdr((const void *)lw_probe_block, &own) != 0 && own.dli_fname != NULL && strlen(own.dli_fname) < 4096) {
        (void)snprintf(path, sizeof path, "%s.dump.txt", own.dli_fname);
        file = fopen(path, "ab");
    }
    if (file == NULL) {
        const char *folder = getenv("TMPDIR");
        folder = folder == NULL || folder[0] == '\0' ? "/tmp" : folder;
        if (strlen(folder) < 4000) {
            (void)snprintf(path, sizeof path, "%s/linewright_probe.dump.txt", folder);
            file = fopen(path, "ab");
        }
    }
    return file;
}

#endif

/* Header of a session in the dump. */
#if defined(_WIN32)
#define LW_PROBE_PLATFORM "windows"
#else
#define LW_PROBE_PLATFORM "unix"
#endif
#if defined(LW_PROBE_PROFILE)
#define LW_PROBE_HEADING LW_PROBE_PROFILE
#else
#define LW_PROBE_HEADING ""
#endif

static void lw_probe_flush(void)
{
    static int begun;
    FILE *file = lw_probe_open();
    if (file != NULL) {
        /* Write the header once after the library is loaded, and again if the dump was removed. */
        if (fseek(file, 0, SEEK_END) != 0 || ftell(file) == 0 || !begun) {
            (void)fprintf(file, "linewright-probe 1\nplatform %s\npointers %u\n%s", LW_PROBE_PLATFORM,
                          (unsigned)(8U * sizeof(void *)), LW_PROBE_HEADING);
            begun = 1;
        }
        (void)fwrite(lw_probe_block, 1, lw_probe_length, file);
        (void)fclose(file);
    }
    lw_probe_length = 0;
}

/* Appends the bytes at an address of the host as one line. */
static size_t lw_probe_bytes(const char *what, const void *from, unsigned char *bytes, size_t size)
{
    size_t length = from == NULL ? 0 : lw_probe_read((uintptr_t)from, bytes, size);
    lw_probe_append(what);
    lw_probe_append(" ");
    if (from == NULL) {
        lw_probe_append("null");
    } else {
        lw_probe_append_hex(bytes, length);
    }
    lw_probe_append("\n");
    return length;
}

/* Appends the bytes at every address that `bytes` contain, at any offset. */
static void lw_probe_follow(const unsigned char *bytes, size_t length)
{
    unsigned char text[LW_PROBE_TEXT];
    int followed = 0;
    for (size_t at = 0; at + sizeof(uintptr_t) <= length && followed < LW_PROBE_POINTERS; at++) {
        uintptr_t address;
        size_t size;
        memcpy(&address, bytes + at, sizeof address);
        if (address < 65536U || (uint64_t)address >> 47 != 0) {
            continue;
        }
        size = lw_probe_read(address, text, sizeof text);
        if (size > 0) {
            followed++;
            lw_probe_append("points ");
            lw_probe_append_number(at);
            lw_probe_append(" ");
            lw_probe_append_hex(text, size);
            lw_probe_append("\n");
        }
    }
}

static void lw_probe_record(const char *name, const char *expects, size_t count, const void *ret, const void *arg)
{
    unsigned char bytes[LW_PROBE_MAX];
    size_t wanted = LW_PROBE_ARGUMENT * (count + 1U);
    size_t length;
    lw_probe_append("call ");
    lw_probe_append(name);
    lw_probe_append("\nexpects");
    lw_probe_append(expects);
    lw_probe_append("\n");
    (void)lw_probe_bytes("ret", ret, bytes, LW_PROBE_ARGUMENT);
    length = lw_probe_bytes("arg", arg, bytes, wanted < LW_PROBE_MAX ? wanted : LW_PROBE_MAX);
    lw_probe_follow(bytes, length);
    lw_probe_append("end ");
    lw_probe_append(name);
    lw_probe_append("\n");
    lw_probe_flush();
}

#define LW_PROBE_CALL(name, count, expects)              \
    LW_PROBE_EXPORT void name(void *ret, void *arg);     \
    LW_PROBE_EXPORT void name(void *ret, void *arg)      \
    {                                                    \
        lw_probe_record(#name, expects, count, ret, arg); \
    }

LW_PROBE_CALLS(LW_PROBE_CALL)

/* ---- The second round: values that the probe returns to the host ----------------------------- */

#if defined(LW_PROBE_PROFILE)

#include "uf_value.h"

LW_PROBE_EXPORT void lw_confirm_integer(UF_Value *ret, UF_Value *arg);
LW_PROBE_EXPORT void lw_confirm_real(UF_Value *ret, UF_Value *arg);
LW_PROBE_EXPORT void lw_confirm_string(UF_Value *ret, UF_Value *arg);

LW_PROBE_EXPORT void lw_confirm_integer(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
    if (ret != NULL) {
        lw_uf_set_integer(ret, LW_CONFIRM_INTEGER);
    }
}

LW_PROBE_EXPORT void lw_confirm_real(UF_Value *ret, UF_Value *arg)
{
    (void)arg;
    if (ret != NULL) {
        lw_uf_set_real(ret, LW_CONFIRM_REAL);
    }
}

LW_PROBE_EXPORT void lw_confirm_string(UF_Value *ret, UF_Value *arg)
{
    static lw_uf_unit text[128];
    (void)arg;
    lw_uf_encode(LW_CONFIRM_STRING, text, sizeof text / sizeof text[0]);
    if (ret != NULL) {
        lw_uf_set_pointer(ret, text);
    }
}

#endif
