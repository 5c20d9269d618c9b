/* A stand-in for the vendor's header, with a layout that is given on the compiler's command line: a mock of Plant Simulation.
 *
 *     MOCK_PACKING  MOCK_TAG  MOCK_INTEGER          #pragma pack, the types of tag and integer
 *     MOCK_VALUE_FIRST  MOCK_OWNER                  the value comes before the tag; a pointer comes before both
 *     MOCK_TAGS                                     the numbers of integer, real and string, with commas
 *     MOCK_BOOLEAN  MOCK_TIME                       the tags of truth values and times, where they have their own
 *     MOCK_ENCODING                                 1 UTF-8, 2 ISO 8859-1, 3 windows-1252, 4 UTF-16
 *
 * Nothing of it is the program's: it is written so that the program's own declarations are judged by another. */
#ifndef CWINFUNC_H
#define CWINFUNC_H

#include <stdint.h>

#if MOCK_ENCODING == 4
typedef uint16_t mock_char;
#else
typedef char mock_char;
#endif

/* Not every compiler expands a macro within this line. */
#if MOCK_PACKING == 1
#pragma pack(push, 1)
#elif MOCK_PACKING == 4
#pragma pack(push, 4)
#else
#pragma pack(push, 8)
#endif
typedef union mock_value {
    MOCK_INTEGER integer;
    double real;
    const mock_char *string;
    uint8_t boolean;
} mock_value;

typedef struct UF_Value {
#if defined(MOCK_OWNER)
    void *owner;
#endif
#if defined(MOCK_VALUE_FIRST)
    mock_value value;
    MOCK_TAG type;
#else
    MOCK_TAG type;
    mock_value value;
#endif
} UF_Value;
#pragma pack(pop)

#define MOCK_FIRST(a, b, c) a
#define MOCK_SECOND(a, b, c) b
#define MOCK_THIRD(a, b, c) c
#define MOCK_PICK(which, tags) which tags
#define UF_INTEGER MOCK_PICK(MOCK_FIRST, (MOCK_TAGS))
#define UF_REAL MOCK_PICK(MOCK_SECOND, (MOCK_TAGS))
#define UF_STRING MOCK_PICK(MOCK_THIRD, (MOCK_TAGS))

#endif
