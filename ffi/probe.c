/* The probe: finds out how the host lays out a UF_Value, without touching a field of one.
 *
 * Each export has the signature `void name(UF_Value *ret, UF_Value *arg)` and is called by the
 * SimTalk text that comes with it, with values that are known here. It appends the raw bytes at
 * `arg` and `ret` to a dump, and what the addresses among them point to; `linewright doctor
 * --probe` reads the layout back from that. Nothing is written to `ret`: where would not be known.
 * In a second round the probe is built with the profile that was found; then it also returns values
 * (the lw_confirm_... exports), and gets them back as arguments.
 *
 * How much can be read behind `arg` is not known, since no count of arguments is passed. So the
 * system is asked to copy the bytes, and refuses where there are none: on Windows
 * ReadProcessMemory, page by page and only where VirtualQuery says that a page may be read (a guard
 * page must not be touched); elsewhere write() into a pipe, which any sandbox allows. No more than
 * LW_PROBE_ARGUMENT bytes for each argument and one more are read.
 *
 * The dump is the file that the environment variable LINEWRIGHT_PROBE_DUMP names, else
 * `....dump.txt` beside the library, else `linewright_probe.dump.txt` in the folder for temporary
 * files. Every call is appended as a whole and the file closed again, so what was written stays
 * when the host ends in the next call. The probe is not for several threads. */
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
#error "probe.c is included by an emitted file, after the list of its calls"
#endif

#define LW_PROBE_PAGE 4096U
#define LW_PROBE_ARGUMENT 64U /* no UF_Value is larger */
#define LW_PROBE_MOST 512U
#define LW_PROBE_TEXT 96U    /* bytes that are copied from where an address points */
#define LW_PROBE_POINTERS 64 /* addresses that are followed in one call */

/* ---- Reading what may not be there ----------------------------------------------------------- */

#if defined(_WIN32)

/* Copies up to `size` bytes within one page, and gives how many. */
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
    /* Not through write(): a sanitizer in the host would check the bytes first. */
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

/* Copies up to `size` bytes, as far as they can be read. */
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

static void lw_probe_say(const char *text)
{
    size_t length = strlen(text);
    if (lw_probe_length + length < sizeof lw_probe_block) {
        memcpy(lw_probe_block + lw_probe_length, text, length);
        lw_probe_length += length;
    }
}

static void lw_probe_number(size_t number)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = '\0';
    do {
        digits[--at] = (char)('0' + number % 10U);
        number /= 10U;
    } while (number > 0);
    lw_probe_say(digits + at);
}

static void lw_probe_hex(const unsigned char *bytes, size_t size)
{
    static const char digits[] = "0123456789abcdef";
    char pair[3] = {0, 0, 0};
    for (size_t i = 0; i < size; i++) {
        pair[0] = digits[bytes[i] >> 4];
        pair[1] = digits[bytes[i] & 15];
        lw_probe_say(pair);
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

/* What a session begins with. */
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
        /* Once in the library's life, and again where the dump was taken away. */
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

/* The bytes at an address of the host, as one line. */
static size_t lw_probe_bytes(const char *what, const void *from, unsigned char *bytes, size_t size)
{
    size_t length = from == NULL ? 0 : lw_probe_read((uintptr_t)from, bytes, size);
    lw_probe_say(what);
    lw_probe_say(" ");
    if (from == NULL) {
        lw_probe_say("null");
    } else {
        lw_probe_hex(bytes, length);
    }
    lw_probe_say("\n");
    return length;
}

/* What the bytes point to, wherever 8 of them could be an address. */
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
            lw_probe_say("points ");
            lw_probe_number(at);
            lw_probe_say(" ");
            lw_probe_hex(text, size);
            lw_probe_say("\n");
        }
    }
}

static void lw_probe_record(const char *name, const char *expects, size_t count, const void *ret, const void *arg)
{
    unsigned char bytes[LW_PROBE_MOST];
    size_t wanted = LW_PROBE_ARGUMENT * (count + 1U);
    size_t length;
    lw_probe_say("call ");
    lw_probe_say(name);
    lw_probe_say("\nexpects");
    lw_probe_say(expects);
    lw_probe_say("\n");
    (void)lw_probe_bytes("ret", ret, bytes, LW_PROBE_ARGUMENT);
    length = lw_probe_bytes("arg", arg, bytes, wanted < LW_PROBE_MOST ? wanted : LW_PROBE_MOST);
    lw_probe_follow(bytes, length);
    lw_probe_say("end ");
    lw_probe_say(name);
    lw_probe_say("\n");
    lw_probe_flush();
}

#define LW_PROBE_CALL(name, count, expects)              \
    LW_PROBE_EXPORT void name(void *ret, void *arg);     \
    LW_PROBE_EXPORT void name(void *ret, void *arg)      \
    {                                                    \
        lw_probe_record(#name, expects, count, ret, arg); \
    }

LW_PROBE_CALLS(LW_PROBE_CALL)

/* ---- The second round: what the host makes of values that are returned ----------------------- */

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
