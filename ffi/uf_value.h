/* UF_Value: what Plant Simulation passes to an exported function, and what it gets back.
 *
 * UNVERIFIED. The vendor's header `cwinfunc.h` is not public. Known are the fields `.type` and `.value.real` and the tag
 * `UF_REAL`; everything else here (numeric tags, packing, integer width, strings) is an assumption of this program, the
 * profile "default". Every assumption can be set on the compiler's command line:
 *
 *     LW_UF_TAG_INTEGER, LW_UF_TAG_REAL, LW_UF_TAG_STRING   numeric tags
 *     LW_UF_INTEGER                                          the type of an integer
 *     LW_UF_PACKING                                          #pragma pack around the structure
 *
 * With -DUF_USE_VENDOR_HEADER the vendor's own header is compiled instead, and the names of its tags and fields, where they
 * differ from the ones below, are given as LW_UF_TAG_... and LW_UF_FIELD_... */
#ifndef LW_UF_VALUE_H
#define LW_UF_VALUE_H

#include <stdint.h>

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

#else

#ifndef LW_UF_TAG_INTEGER
#define LW_UF_TAG_INTEGER 1
#endif
#ifndef LW_UF_TAG_REAL
#define LW_UF_TAG_REAL 2
#endif
#ifndef LW_UF_TAG_STRING
#define LW_UF_TAG_STRING 3
#endif
#ifndef LW_UF_INTEGER
#define LW_UF_INTEGER int32_t
#endif

#ifdef LW_UF_PACKING
#pragma pack(push, LW_UF_PACKING)
#endif
typedef struct UF_Value {
    int type;
    union {
        LW_UF_INTEGER integer;
        double real;
        const char *string;
    } value;
} UF_Value;
#ifdef LW_UF_PACKING
#pragma pack(pop)
#endif

#endif

#ifndef LW_UF_INTEGER
#define LW_UF_INTEGER int
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

#endif
