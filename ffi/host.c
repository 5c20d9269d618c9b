/* A complete host for a station library, in plain C: loads it, runs one operation, and destroys the
 * instance.
 *
 *     cc -std=c99 host.c -o host          (older systems: add -ldl)
 *     ./host ./assembly_cell.so 0 90 1    operation 0 with the properties 90 and 1
 *
 * The last line of its output is HOST PASSED if everything succeeded; an error of the machine is
 * printed with its code and text. */
#if !defined(_WIN32) && !defined(_POSIX_C_SOURCE)
#define _POSIX_C_SOURCE 200809L
#endif
#include "station.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#define MAX_PROPERTIES 256

/* Copies a pointer to a function of the library into `function`; ends the program if the library
 * does not export the function. */
static void find(void *library, const char *name, void *function, size_t size)
{
#if defined(_WIN32)
    FARPROC symbol = GetProcAddress((HMODULE)library, name);
#else
    void *symbol = dlsym(library, name);
#endif
    if (symbol == NULL || size != sizeof symbol) {
        fprintf(stderr, "host: %s is not exported\n", name);
        exit(2);
    }
    memcpy(function, &symbol, size);
}

int main(int argc, char **argv)
{
    lw_handle (*create)(void);
    int32_t (*destroy)(lw_handle);
    int32_t (*property_count)(void);
    int32_t (*simulate)(lw_handle, int32_t, double *, size_t, lw_service *);
    int32_t (*last_error)(lw_handle, char *, size_t);
    const char *(*describe)(void);
    double properties[MAX_PROPERTIES];
    lw_service service = {0.0, 0.0, 0};
    char text[1024];
    int count;

    if (argc < 3) {
        fprintf(stderr, "usage: host LIBRARY OPERATION PROPERTY...\n");
        return 2;
    }
#if defined(_WIN32)
    void *library = (void *)LoadLibraryA(argv[1]);
#else
    void *library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
#endif
    if (library == NULL) {
        fprintf(stderr, "host: %s cannot be loaded\n", argv[1]);
        return 2;
    }
    find(library, "lw_create", (void *)&create, sizeof create);
    find(library, "lw_destroy", (void *)&destroy, sizeof destroy);
    find(library, "lw_property_count", (void *)&property_count, sizeof property_count);
    find(library, "lw_simulate", (void *)&simulate, sizeof simulate);
    find(library, "lw_last_error", (void *)&last_error, sizeof last_error);
    find(library, "lw_describe", (void *)&describe, sizeof describe);

    printf("%s\n", describe());
    count = argc - 3;
    if (count != property_count() || count > MAX_PROPERTIES) {
        fprintf(stderr, "host: the machine has %d properties\n", (int)property_count());
        return 2;
    }
    for (int i = 0; i < count; i++) {
        properties[i] = strtod(argv[3 + i], NULL);
    }
    lw_handle handle = create();
    if (handle < 0) {
        last_error(0, text, sizeof text);
        fprintf(stderr, "host: code %d: %s\n", (int)handle, text);
        return 1;
    }
    int32_t code = simulate(handle, (int32_t)strtol(argv[2], NULL, 10), properties, (size_t)count, &service);
    if (code < 0) {
        last_error(handle, text, sizeof text);
        fprintf(stderr, "host: code %d: %s\n", (int)code, text);
        destroy(handle);
        return 1;
    }
    printf("%.3f s, %.3f J, %ld steps\n", service.seconds, service.joules, (long)service.steps);
    for (int i = 0; i < count; i++) {
        printf("property %d: %.6g\n", i, properties[i]);
    }
    if (destroy(handle) != LW_OK || destroy(handle) != LW_ERROR_HANDLE) {
        fprintf(stderr, "host: the handle must be valid until it is destroyed, and invalid afterwards\n");
        return 1;
    }
    printf("HOST PASSED\n");
    return 0;
}
