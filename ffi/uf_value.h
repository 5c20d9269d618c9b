/* UF_Value: the type of the arguments and results of a function that Plant Simulation calls.
 *
 * The vendor's header `cwinfunc.h` is not public, so the layout is a setting: `uf_profile.h`, which
 * is emitted with every package, defines the positions of tag and value, the tags, the width of an
 * integer, and the encoding of strings. Fields are copied byte by byte out of a structure without
 * alignment, so every layout can be expressed and no access is misaligned; compilers turn each copy
 * into one load or store.
 *
 * With -DUF_USE_VENDOR_HEADER the vendor's own header is compiled instead. Only its fields `.type`
 * and `.value.real` and its tag `UF_REAL` are known. If other names differ from the ones below,
 * define LW_UF_TAG_... and LW_UF_FIELD_..., and the encoding of strings as LW_UF_ENCODING. */
#ifndef LW_UF_VALUE_H
#define LW_UF_VALUE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Encodings of strings. */
#define LW_UF_UTF_8 1
#define LW_UF_LATIN_1 2
#define LW_UF_WINDOWS_1252 3
#define LW_UF_UTF_16 4

#if defined(__GNUC__)
#define LW_UF_MAY_BE_UNUSED __attribute__((unused))
#else
#define LW_UF_MAY_BE_UNUSED
#endif

/* Kind of a value. */
enum lw_uf_kind { LW_UF_OTHER, LW_UF_IS_INTEGER, LW_UF_IS_REAL, LW_UF_IS_STRING, LW_UF_IS_BOOLEAN };

#ifdef UF_USE_VENDOR_HEADER

#include "cwinfunc.h"

#ifndef LW_UF_TAG_INTEGER
#define LW_UF_TAG_INTEGER UF_INTEGER
#endif
#ifndef LW_UF_TAG_REAL
#define LW_UF_TAG_REAL UF_REAL
#endif
#ifndef LW_UF_TAG_STRING
#define LW_UF_TAG_STRING UF_STRING
#endif
#ifndef LW_UF_INTEGER
#define LW_UF_INTEGER int
#endif
#ifndef LW_UF_ENCODING
#define LW_UF_ENCODING LW_UF_UTF_8
#endif
#ifndef LW_UF_FIELD_INTEGER
#define LW_UF_FIELD_INTEGER integer
#endif
#ifndef LW_UF_FIELD_REAL
#define LW_UF_FIELD_REAL real
#endif
#ifndef LW_UF_FIELD_STRING
#define LW_UF_FIELD_STRING string
#endif
#ifndef LW_UF_FIELD_BOOLEAN
#define LW_UF_FIELD_BOOLEAN boolean
#endif

#define LW_UF_TAG_OF(at) ((at)->type)
#define LW_UF_READ(at, field, type) ((type)(at)->value.field)
#define LW_UF_WRITE(at, tag, field, data) ((void)((at)->type = (tag), (at)->value.field = (data)))
#define lw_uf_real_of(at) LW_UF_READ(at, LW_UF_FIELD_REAL, double)
#define lw_uf_integer_of(at) LW_UF_READ(at, LW_UF_FIELD_INTEGER, int64_t)
#define lw_uf_boolean_of(at) (LW_UF_READ(at, LW_UF_FIELD_BOOLEAN, int) != 0)
#define lw_uf_pointer_of(at) ((const void *)(at)->value.LW_UF_FIELD_STRING)
#define lw_uf_set_real(at, data) LW_UF_WRITE(at, LW_UF_TAG_REAL, LW_UF_FIELD_REAL, data)
#define lw_uf_set_integer(at, data) LW_UF_WRITE(at, LW_UF_TAG_INTEGER, LW_UF_FIELD_INTEGER, (LW_UF_INTEGER)(data))
#define lw_uf_set_pointer(at, data) LW_UF_WRITE(at, LW_UF_TAG_STRING, LW_UF_FIELD_STRING, (void *)(data))

#else

#include "uf_profile.h"

typedef struct UF_Value {
    unsigned char bytes[LW_UF_SIZE];
} UF_Value;

#define LW_UF_TAG_OF(value) lw_uf_tag_of(value)

LW_UF_MAY_BE_UNUSED static LW_UF_TAG lw_uf_tag_of(const UF_Value *value)
{
    LW_UF_TAG tag;
    memcpy(&tag, value->bytes + LW_UF_TAG_OFFSET, sizeof tag);
    return tag;
}

LW_UF_MAY_BE_UNUSED static int64_t lw_uf_integer_of(const UF_Value *value)
{
    LW_UF_INTEGER integer;
    memcpy(&integer, value->bytes + LW_UF_VALUE_OFFSET, sizeof integer);
    return (int64_t)integer;
}

LW_UF_MAY_BE_UNUSED static double lw_uf_real_of(const UF_Value *value)
{
    double real;
    memcpy(&real, value->bytes + LW_UF_VALUE_OFFSET, sizeof real);
    return real;
}

/* The width of a Boolean does not matter, because its lowest byte comes first. */
LW_UF_MAY_BE_UNUSED static int lw_uf_boolean_of(const UF_Value *value)
{
    return value->bytes[LW_UF_VALUE_OFFSET] != 0;
}

LW_UF_MAY_BE_UNUSED static const void *lw_uf_pointer_of(const UF_Value *value)
{
    const void *pointer;
    memcpy(&pointer, value->bytes + LW_UF_VALUE_OFFSET, sizeof pointer);
    return pointer;
}

LW_UF_MAY_BE_UNUSED static void lw_uf_set(UF_Value *ret, uint64_t number, const void *data, size_t size)
{
    LW_UF_TAG tag = (LW_UF_TAG)number;
    memcpy(ret->bytes + LW_UF_TAG_OFFSET, &tag, sizeof tag);
    memcpy(ret->bytes + LW_UF_VALUE_OFFSET, data, size);
}

LW_UF_MAY_BE_UNUSED static void lw_uf_set_integer(UF_Value *ret, int64_t number)
{
    LW_UF_INTEGER integer = (LW_UF_INTEGER)number;
    lw_uf_set(ret, LW_UF_TAG_INTEGER, &integer, sizeof integer);
}

LW_UF_MAY_BE_UNUSED static void lw_uf_set_real(UF_Value *ret, double real)
{
    lw_uf_set(ret, LW_UF_TAG_REAL, &real, sizeof real);
}

LW_UF_MAY_BE_UNUSED static void lw_uf_set_pointer(UF_Value *ret, const void *pointer)
{
    lw_uf_set(ret, LW_UF_TAG_STRING, &pointer, sizeof pointer);
}

#endif

LW_UF_MAY_BE_UNUSED static enum lw_uf_kind lw_uf_kind_of(const UF_Value *value)
{
    if (LW_UF_TAG_OF(value) == LW_UF_TAG_INTEGER) {
        return LW_UF_IS_INTEGER;
    }
    if (LW_UF_TAG_OF(value) == LW_UF_TAG_REAL) {
        return LW_UF_IS_REAL;
    }
    if (LW_UF_TAG_OF(value) == LW_UF_TAG_STRING) {
        return LW_UF_IS_STRING;
    }
#ifdef LW_UF_MORE_REAL
    if (LW_UF_MORE_REAL(LW_UF_TAG_OF(value))) {
        return LW_UF_IS_REAL;
    }
#endif
#ifdef LW_UF_TAG_BOOLEAN
    if (LW_UF_TAG_OF(value) == LW_UF_TAG_BOOLEAN) {
        return LW_UF_IS_BOOLEAN;
    }
#endif
    return LW_UF_OTHER;
}

/* Reads a number of any kind. Returns 0 if the value is not a number. */
LW_UF_MAY_BE_UNUSED static int lw_uf_number_of(const UF_Value *value, double *number)
{
    switch (lw_uf_kind_of(value)) {
    case LW_UF_IS_REAL:
        *number = lw_uf_real_of(value);
        return 1;
    case LW_UF_IS_INTEGER:
        *number = (double)lw_uf_integer_of(value);
        return 1;
#ifdef LW_UF_TAG_BOOLEAN
    case LW_UF_IS_BOOLEAN:
        *number = lw_uf_boolean_of(value) ? 1.0 : 0.0;
        return 1;
#endif
    default:
        return 0;
    }
}

/* Returns an integer to the host, or a real number if the integer is too large for the profile's
 * integers. */
LW_UF_MAY_BE_UNUSED static void lw_uf_give_integer(UF_Value *ret, int64_t number)
{
    if ((int64_t)(LW_UF_INTEGER)number == number) {
        lw_uf_set_integer(ret, number);
    } else {
        lw_uf_set_real(ret, (double)number);
    }
}

/* ---- Texts --------------------------------------------------------------------------------------
 *
 * Texts within a library are UTF-8. Texts from and to the host use the encoding of the profile; a
 * character that an encoding lacks becomes `?`. */

#if LW_UF_ENCODING == LW_UF_UTF_16
typedef uint16_t lw_uf_unit;
#else
typedef unsigned char lw_uf_unit;
#endif

#if LW_UF_ENCODING == LW_UF_WINDOWS_1252
/* The characters of the bytes 0x80 to 0x9F; 0 if a byte has no character. */
static const uint16_t lw_uf_windows[32] = {
    0x20AC, 0, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0, 0x017D, 0,
    0, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0, 0x017E, 0x0178,
};
#endif

/* Returns the next character of a UTF-8 text and advances `text`; invalid bytes give `?`. */
LW_UF_MAY_BE_UNUSED static uint32_t lw_uf_next(const char **text)
{
    const unsigned char *at = (const unsigned char *)*text;
    uint32_t point = at[0];
    int more = point < 0x80 ? 0 : point >= 0xC2 && point < 0xE0 ? 1 : point >= 0xE0 && point < 0xF0 ? 2
                                : point >= 0xF0 && point < 0xF5 ? 3 : -1;
    *text += 1;
    if (more < 0) {
        return '?';
    }
    if (more > 0) {
        point &= 0x3FU >> more;
    }
    for (int i = 1; i <= more; i++) {
        if ((at[i] & 0xC0) != 0x80) {
            return '?';
        }
        point = point << 6 | (at[i] & 0x3FU);
        *text += 1;
    }
    return point;
}

/* Writes a text in the profile's encoding, cut to `size` units including a final 0. */
LW_UF_MAY_BE_UNUSED static void lw_uf_encode(const char *text, lw_uf_unit *out, size_t size)
{
    size_t length = 0;
    while (*text != '\0') {
#if LW_UF_ENCODING == LW_UF_UTF_8
        const char *start = text;
        (void)lw_uf_next(&text);
        if (length + (size_t)(text - start) + 1 > size) {
            break;
        }
        memcpy(out + length, start, (size_t)(text - start));
        length += (size_t)(text - start);
#elif LW_UF_ENCODING == LW_UF_UTF_16
        uint32_t point = lw_uf_next(&text);
        if (length + (point > 0xFFFF ? 3U : 2U) > size) {
            break;
        }
        if (point > 0xFFFF) {
            out[length++] = (uint16_t)(0xD800U + ((point - 0x10000U) >> 10));
            point = 0xDC00U + ((point - 0x10000U) & 0x3FFU);
        }
        out[length++] = (uint16_t)point;
#else
        uint32_t point = lw_uf_next(&text);
        lw_uf_unit unit = (lw_uf_unit)(point < 0x80 || (point >= 0xA0 && point < 0x100) ? point : '?');
#if LW_UF_ENCODING == LW_UF_WINDOWS_1252
        for (unsigned i = 0; i < 32; i++) {
            if (lw_uf_windows[i] == point && point != 0) {
                unit = (lw_uf_unit)(0x80U + i);
            }
        }
#else
        unit = point >= 0x80 && point < 0xA0 ? (lw_uf_unit)point : unit;
#endif
        if (length + 2 > size) {
            break;
        }
        out[length++] = unit;
#endif
    }
    out[length] = 0;
}

/* Writes a character in UTF-8 and returns its number of bytes; 0 if it does not fit. */
LW_UF_MAY_BE_UNUSED static size_t lw_uf_put(uint32_t point, char *out, size_t room)
{
    size_t size = point < 0x80 ? 1 : point < 0x800 ? 2 : point < 0x10000 ? 3 : 4;
    static const unsigned char first[5] = {0, 0, 0xC0, 0xE0, 0xF0};
    if (size > room) {
        return 0;
    }
    for (size_t i = size; i-- > 1;) {
        out[i] = (char)(0x80U | (point & 0x3FU));
        point >>= 6;
    }
    out[0] = (char)(first[size] | point);
    return size;
}

/* Reads a text of the host as UTF-8, cut to `size` bytes including a final 0; a null pointer is the
 * empty text. Returns 0 if the text was cut. */
LW_UF_MAY_BE_UNUSED static int lw_uf_decode(const void *text, char *out, size_t size)
{
    const unsigned char *at = (const unsigned char *)text;
    size_t length = 0;
    out[0] = '\0';
    for (size_t i = 0; at != NULL; i++) {
#if LW_UF_ENCODING == LW_UF_UTF_16
        uint16_t unit;
        uint32_t point;
        memcpy(&unit, at + 2 * i, sizeof unit);
        point = unit;
        if (unit >= 0xD800 && unit < 0xDC00) {
            uint16_t low;
            memcpy(&low, at + 2 * i + 2, sizeof low);
            if (low >= 0xDC00 && low < 0xE000) {
                point = 0x10000U + ((uint32_t)(unit - 0xD800) << 10) + (uint32_t)(low - 0xDC00);
                i++;
            }
        }
        if (point >= 0xD800 && point < 0xE000) {
            point = '?';
        }
#else
        uint32_t point = at[i];
#if LW_UF_ENCODING == LW_UF_WINDOWS_1252
        if (point >= 0x80 && point < 0xA0) {
            point = lw_uf_windows[point - 0x80] == 0 ? '?' : lw_uf_windows[point - 0x80];
        }
#endif
#endif
        if (point == 0) {
            return 1;
        }
#if LW_UF_ENCODING == LW_UF_UTF_8
        if (length + 2 > size) {
            return 0;
        }
        out[length++] = (char)point;
#else
        size_t added = lw_uf_put(point, out + length, size - 1 - length);
        if (added == 0) {
            return 0;
        }
        length += added;
#endif
        out[length] = '\0';
    }
    return 1;
}

#endif
