/* A library's exports, and the values that go through those of the Plant Simulation adapter. */
#include "host.h"

#include <stdio.h>
#include <string.h>

typedef struct export_name {
    const char *name;
    size_t place;
} export_name;

/* Every function of station.h and of plant_simulation.c. */
static const export_name EXPORTS[] = {
    {"lw_abi_version", offsetof(library, abi_version)},
    {"lw_describe", offsetof(library, describe)},
    {"lw_plant_count", offsetof(library, plant_count)},
    {"lw_output_count", offsetof(library, output_count)},
    {"lw_property_count", offsetof(library, property_count)},
    {"lw_operation_count", offsetof(library, operation_count)},
    {"lw_create", offsetof(library, create)},
    {"lw_destroy", offsetof(library, destroy)},
    {"lw_reset", offsetof(library, reset)},
    {"lw_step", offsetof(library, step)},
    {"lw_simulate", offsetof(library, simulate)},
    {"lw_last_error", offsetof(library, last_error)},
    {"lw_last_rule", offsetof(library, last_rule)},
    {"instantiate", offsetof(library, instantiate_value)},
    {"simulate", offsetof(library, simulate_value)},
    {"get_real", offsetof(library, get_real_value)},
    {"get_integer", offsetof(library, get_integer_value)},
    {"get_string", offsetof(library, get_string_value)},
    {"reset", offsetof(library, reset_value)},
    {"deinstantiate", offsetof(library, deinstantiate_value)},
    {"last_error", offsetof(library, last_error_value)},
    {"station_describe", offsetof(library, describe_value)},
};

void library_open(library *lib, const char *path)
{
    size_t missing = 0;
    memset(lib, 0, sizeof *lib);
    lib->path = path;
    lib->module = module_load(path);
    if (lib->module == NULL) {
        fail("%s cannot be loaded", path);
    }
    for (size_t i = 0; i < sizeof EXPORTS / sizeof EXPORTS[0]; i++) {
        if (!module_find(lib->module, EXPORTS[i].name, (char *)lib + EXPORTS[i].place)) {
            printf("%s is not exported\n", EXPORTS[i].name);
            missing++;
        }
    }
    if (missing > 0) {
        fail("%d exports are missing", (int)missing);
    }
}

void library_close(library *lib)
{
    module_unload(lib->module);
    if (module_present(lib->path)) {
        fail("%s is still loaded after it was unloaded", lib->path);
    }
    lib->module = NULL;
}

/* ---- Values ------------------------------------------------------------------------------------------------------ */

UF_Value value_of_tag(int tag)
{
    UF_Value value;
    memset(&value, 0, sizeof value);
    value.type = tag;
    return value;
}

UF_Value value_integer(int64_t integer)
{
    UF_Value value = value_of_tag(LW_UF_TAG_INTEGER);
    value.value.LW_UF_FIELD_INTEGER = (LW_UF_INTEGER)integer;
    return value;
}

UF_Value value_real(double real)
{
    UF_Value value = value_of_tag(LW_UF_TAG_REAL);
    value.value.LW_UF_FIELD_REAL = real;
    return value;
}

UF_Value value_string(const char *string)
{
    UF_Value value = value_of_tag(LW_UF_TAG_STRING);
    value.value.LW_UF_FIELD_STRING = string;
    return value;
}

static UF_Value call(value_export *export, UF_Value *arg, int tag, const char *what)
{
    UF_Value answer = value_of_tag(-1234);
    export(&answer, arg);
    if (answer.type != tag) {
        fail("%s: expected an answer with the tag %d, saw the tag %d", what, tag, (int)answer.type);
    }
    return answer;
}

int64_t call_integer(value_export *export, UF_Value *arg, const char *what)
{
    return (int64_t)call(export, arg, LW_UF_TAG_INTEGER, what).value.LW_UF_FIELD_INTEGER;
}

double call_real(value_export *export, UF_Value *arg, const char *what)
{
    return call(export, arg, LW_UF_TAG_REAL, what).value.LW_UF_FIELD_REAL;
}

const char *call_string(value_export *export, UF_Value *arg, const char *what)
{
    return call(export, arg, LW_UF_TAG_STRING, what).value.LW_UF_FIELD_STRING;
}
