/* What the mock hosts share: variables as a simulator has them, passed as UF_Value, and read back from one. */
#ifndef MOCK_H
#define MOCK_H

#if !defined(_WIN32) && !defined(_GNU_SOURCE)
#define _GNU_SOURCE 1
#endif

#include "cwinfunc.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

typedef void mock_export(UF_Value *ret, UF_Value *arg);

static void *mock_library;

static void mock_load(const char *path)
{
#if defined(_WIN32)
    mock_library = (void *)LoadLibraryA(path);
#else
    mock_library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
#endif
    if (mock_library == NULL) {
        printf("%s cannot be loaded\n", path);
        exit(2);
    }
}

static void mock_free(void)
{
#if defined(_WIN32)
    FreeLibrary((HMODULE)mock_library);
#else
    dlclose(mock_library);
#endif
}

static mock_export *mock_find(const char *name)
{
    mock_export *found;
#if defined(_WIN32)
    FARPROC symbol = GetProcAddress((HMODULE)mock_library, name);
#else
    void *symbol = dlsym(mock_library, name);
#endif
    if (symbol == NULL) {
        printf("%s is not exported\n", name);
        exit(2);
    }
    memcpy(&found, &symbol, sizeof found);
    return found;
}

/* ---- Texts, in the host's encoding; this program's own are UTF-8 ------------------------------------------------------- */

static unsigned long mock_point(const unsigned char **at)
{
    unsigned long first = *(*at)++;
    int more = first < 0x80 ? 0 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3;
    unsigned long point = more == 0 ? first : first & (0x7FUL >> (more + 1));
    while (more-- > 0) {
        point = (point << 6) | (*(*at)++ & 0x3FUL);
    }
    return point;
}

static unsigned long mock_windows(unsigned long point)
{
    switch (point) { /* those that the tests use */
    case 0x20AC: return 0x80;
    case 0x201E: return 0x84;
    case 0x2026: return 0x85;
    case 0x2013: return 0x96;
    default: return point < 0x80 || (point >= 0xA0 && point < 0x100) ? point : '?';
    }
}

/* A text as the host holds it; it stays until the program ends. */
static const mock_char *mock_text(const char *utf8)
{
    const unsigned char *at = (const unsigned char *)utf8;
    mock_char *text = (mock_char *)calloc(strlen(utf8) + 2, sizeof(mock_char));
    size_t length = 0;
    if (text == NULL) {
        exit(2);
    }
#if MOCK_ENCODING == 1
    (void)at;
    (void)mock_point;
    (void)mock_windows;
    length = strlen(utf8);
    memcpy(text, utf8, length);
#else
    while (*at != 0) {
        unsigned long point = mock_point(&at);
#if MOCK_ENCODING == 4
        (void)mock_windows;
        if (point > 0xFFFF) {
            text[length++] = (mock_char)(0xD800 + ((point - 0x10000) >> 10));
            point = 0xDC00 + ((point - 0x10000) & 0x3FF);
        }
        text[length++] = (mock_char)point;
#elif MOCK_ENCODING == 3
        text[length++] = (mock_char)mock_windows(point);
#else
        (void)mock_windows;
        text[length++] = (mock_char)(point < 0x100 ? point : '?');
#endif
    }
#endif
    text[length] = 0;
    return text;
}

static int mock_same(const mock_char *a, const mock_char *b)
{
    while (*a != 0 && *a == *b) {
        a++;
        b++;
    }
    return *a == *b;
}

/* ---- Variables --------------------------------------------------------------------------------------------------------- */

enum { MOCK_NOTHING, MOCK_IS_INTEGER, MOCK_IS_REAL, MOCK_IS_STRING, MOCK_IS_BOOLEAN, MOCK_IS_TIME, MOCK_IS_JUNK };

typedef struct variable {
    int kind;
    long long integer;
    double real;
    const mock_char *string;
} variable;

static variable integer(long long value)
{
    variable v = {MOCK_IS_INTEGER, 0, 0.0, NULL};
    v.integer = value;
    return v;
}

static variable real(double value)
{
    variable v = {MOCK_IS_REAL, 0, 0.0, NULL};
    v.real = value;
    return v;
}

static variable string(const char *utf8)
{
    variable v = {MOCK_IS_STRING, 0, 0.0, NULL};
    v.string = mock_text(utf8);
    return v;
}

static variable truth(int value)
{
    variable v = {MOCK_IS_BOOLEAN, 0, 0.0, NULL};
    v.integer = value;
    return v;
}

static variable duration(double value)
{
    variable v = {MOCK_IS_TIME, 0, 0.0, NULL};
    v.real = value;
    return v;
}

/* ---- Calls ------------------------------------------------------------------------------------------------------------- */

#define MOCK_MOST 16

/* What is in memory before a value is put there. */
static void mock_litter(void *place, size_t size)
{
    static unsigned long state = 12345;
    unsigned char *at = (unsigned char *)place;
    for (size_t i = 0; i < size; i++) {
        state = (state * 1103515245UL + 12345UL) & 0x7FFFFFFFUL;
#if defined(MOCK_CLEAN)
        at[i] = 0;
#else
        at[i] = (unsigned char)(state >> 16);
#endif
    }
}

/* Arguments that end where readable memory ends. */
static UF_Value *mock_arguments(size_t count)
{
#if defined(_WIN32)
    static unsigned char room[MOCK_MOST * sizeof(UF_Value)];
    mock_litter(room, sizeof room);
    return (UF_Value *)(void *)(room + (MOCK_MOST - count) * sizeof(UF_Value));
#else
    static unsigned char *pages;
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    if (pages == NULL) {
        pages = (unsigned char *)mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (pages == MAP_FAILED || mprotect(pages + page, page, PROT_NONE) != 0) {
            exit(2);
        }
    }
    /* An array is aligned as the host's compiler wants it. */
    size_t size = count * sizeof(UF_Value);
    size_t start = (page - size) / _Alignof(UF_Value) * _Alignof(UF_Value);
    mock_litter(pages + start - 64, page - start + 64);
    return (UF_Value *)(void *)(pages + start);
#endif
}

static void mock_put(UF_Value *to, variable from)
{
    switch (from.kind) {
    case MOCK_IS_INTEGER:
        to->type = UF_INTEGER;
        to->value.integer = (MOCK_INTEGER)from.integer;
        break;
    case MOCK_IS_REAL:
        to->type = UF_REAL;
        to->value.real = from.real;
        break;
    case MOCK_IS_STRING:
        to->type = UF_STRING;
        to->value.string = from.string;
        break;
    case MOCK_IS_BOOLEAN:
#if defined(MOCK_BOOLEAN)
        to->type = MOCK_BOOLEAN;
        to->value.boolean = (uint8_t)from.integer;
#else
        to->type = UF_INTEGER;
        to->value.integer = (MOCK_INTEGER)from.integer;
#endif
        break;
    case MOCK_IS_TIME:
#if defined(MOCK_TIME)
        to->type = MOCK_TIME;
#else
        to->type = UF_REAL;
#endif
        to->value.real = from.real;
        break;
    default:
        to->type = (MOCK_TAG)0x7B;
        to->value.integer = 0;
    }
}

static variable mock_take(const UF_Value *from)
{
    variable v = {MOCK_IS_JUNK, 0, 0.0, NULL};
    if (from->type == (MOCK_TAG)UF_INTEGER) {
        v.kind = MOCK_IS_INTEGER;
        v.integer = from->value.integer;
    } else if (from->type == (MOCK_TAG)UF_REAL) {
        v.kind = MOCK_IS_REAL;
        v.real = from->value.real;
    } else if (from->type == (MOCK_TAG)UF_STRING) {
        v.kind = MOCK_IS_STRING;
        v.string = from->value.string;
    } else if (from->type == (MOCK_TAG)0x7A) {
        v.kind = MOCK_NOTHING;
    }
    return v;
}

/* Calls an export with some variables; what it returned. Ends the program when it wrote beside its place. */
static variable mock_call(const char *name, size_t count, const variable *arguments)
{
    static UF_Value places[3];
    unsigned char before[sizeof places];
    UF_Value *values = mock_arguments(count);
    for (size_t i = 0; i < count; i++) {
        mock_put(&values[i], arguments[i]);
    }
    mock_litter(places, sizeof places);
    places[1].type = (MOCK_TAG)0x7A; /* nothing yet */
    memcpy(before, places, sizeof before);
    mock_find(name)(&places[1], values);
    if (memcmp(before, places, sizeof(UF_Value)) != 0 ||
        memcmp(before + 2 * sizeof(UF_Value), &places[2], sizeof(UF_Value)) != 0) {
        printf("%s wrote beside its answer\n", name);
        exit(3);
    }
    return mock_take(&places[1]);
}

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define CALL(name, ...) mock_call(name, COUNT(((variable[]){__VA_ARGS__})), (variable[]){__VA_ARGS__})
#define CALL_0(name) mock_call(name, 0, NULL)

#endif
