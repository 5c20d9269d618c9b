/* The plan's file. One line each:
 *
 *     machine NAME
 *     description TEXT                               what lw_describe answers
 *     plant LOW HIGH NAME                            a plant input, in order
 *     output LOW HIGH NAME                           an output, in order
 *     property LOW HIGH NAME                         a property, in order; 1 0 where any number will do
 *     label NAME                                     of the port before it: what its next number from 0 on is called
 *     operation NAME                                 an operation, in order
 *     reset
 *     step PLANT... = OUTPUTS...                     a step that succeeds
 *     step PLANT... ! CODE|RULE|TEXT                 one that is refused
 *     simulate OPERATION BEFORE... = SECONDS JOULES STEPS AFTER...
 *     simulate OPERATION BEFORE... ! CODE|RULE|TEXT
 *
 * Real numbers are the 16 hexadecimal digits of their bits, so that nothing is rounded on the way. CODE is a number, and
 * '|' is a tabulator. The names come before the first call. */
#include "host.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

plan the_plan;

static char *file_text;
static int line_number;
static size_t integers_used;
static size_t integers_room;
static size_t reals_used;
static size_t reals_room;
static int lines_room;
static port *last_port;

/* Room for one more of what is listed. */
static void *grown(void *list, size_t used, size_t *room, size_t size)
{
    if (used < *room) {
        return list;
    }
    *room = *room == 0 ? 64 : *room * 2;
    list = realloc(list, *room * size);
    if (list == NULL) {
        fail("there is no memory for the plan");
    }
    return list;
}

static void add_integer(int64_t value)
{
    the_plan.integers = grown(the_plan.integers, integers_used, &integers_room, sizeof *the_plan.integers);
    the_plan.integers[integers_used] = value;
    integers_used++;
}

static void add_real(double value)
{
    the_plan.reals = grown(the_plan.reals, reals_used, &reals_room, sizeof *the_plan.reals);
    the_plan.reals[reals_used] = value;
    reals_used++;
}

/* The next word of a line; it is cut off. */
static char *word(char **rest)
{
    char *begin = *rest;
    char *end = strchr(begin, ' ');
    if (*begin == '\0') {
        fail("the plan's line %d is too short", line_number);
    }
    if (end == NULL) {
        *rest = begin + strlen(begin);
    } else {
        *end = '\0';
        *rest = end + 1;
    }
    return begin;
}

static int64_t integer(char **rest)
{
    char *end;
    const char *text = word(rest);
    long long value = strtoll(text, &end, 10);
    if (*end != '\0') {
        fail("the plan's line %d has no number in `%s`", line_number, text);
    }
    return (int64_t)value;
}

static double real(char **rest)
{
    char *end;
    double value;
    const char *text = word(rest);
    unsigned long long digits = strtoull(text, &end, 16);
    uint64_t bits = (uint64_t)digits;
    if (*end != '\0' || strlen(text) != 16) {
        fail("the plan's line %d has no bits of a number in `%s`", line_number, text);
    }
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void read_port(port **ports, int32_t *count, char *rest)
{
    *ports = realloc(*ports, ((size_t)*count + 1) * sizeof **ports);
    if (*ports == NULL || *count == MOST_VALUES) {
        fail("the plan has too many names");
    }
    memset(&(*ports)[*count], 0, sizeof **ports);
    last_port = &(*ports)[*count];
    (*ports)[*count].low = integer(&rest);
    (*ports)[*count].high = integer(&rest);
    (*ports)[*count].name = rest;
    ++*count;
}

static void read_name(const char ***names, int32_t *count, const char *name)
{
    *names = realloc(*names, ((size_t)*count + 1) * sizeof **names);
    if (*names == NULL || *count == MOST_VALUES) {
        fail("the plan has too many names");
    }
    (*names)[*count] = name;
    ++*count;
}

static line *new_line(line_kind kind)
{
    line *made;
    size_t room = (size_t)lines_room;
    the_plan.lines = grown(the_plan.lines, (size_t)the_plan.line_count, &room, sizeof *the_plan.lines);
    lines_room = (int)room;
    made = &the_plan.lines[the_plan.line_count];
    memset(made, 0, sizeof *made);
    made->kind = kind;
    made->number = line_number;
    made->rule = "";
    made->text = "";
    the_plan.line_count++;
    return made;
}

/* Whether a call succeeds; where not, how it is refused. */
static int read_answer(line *made, char *rest)
{
    char *text;
    char *rule;
    if (rest[0] == '=') {
        return 1;
    }
    rule = strchr(rest, '\t');
    text = rule == NULL ? NULL : strchr(rule + 1, '\t');
    if (rest[0] != '!' || text == NULL) {
        fail("the plan's line %d says neither success nor error", line_number);
    }
    *rule = '\0';
    *text = '\0';
    made->code = (int32_t)strtol(rest + 2, NULL, 10);
    made->rule = rule + 1;
    made->text = text + 1;
    return 0;
}

static void read_step(char *rest)
{
    line *made = new_line(LINE_STEP);
    made->given = integers_used;
    for (int32_t i = 0; i < the_plan.plant; i++) {
        add_integer(integer(&rest));
    }
    made->got = integers_used;
    if (read_answer(made, rest)) {
        word(&rest);
        for (int32_t i = 0; i < the_plan.outputs; i++) {
            add_integer(integer(&rest));
        }
    }
}

static void read_operation(char *rest)
{
    line *made = new_line(LINE_OPERATION);
    made->operation = (int32_t)integer(&rest);
    made->given = reals_used;
    for (int32_t i = 0; i < the_plan.properties; i++) {
        add_real(real(&rest));
    }
    made->got = reals_used;
    if (read_answer(made, rest)) {
        word(&rest);
        made->service.seconds = real(&rest);
        made->service.joules = real(&rest);
        made->service.steps = integer(&rest);
        for (int32_t i = 0; i < the_plan.properties; i++) {
            add_real(real(&rest));
        }
    }
}

static void read_line(char *rest)
{
    const char *what = word(&rest);
    if (strcmp(what, "step") == 0) {
        read_step(rest);
    } else if (strcmp(what, "simulate") == 0) {
        read_operation(rest);
    } else if (strcmp(what, "reset") == 0) {
        new_line(LINE_RESET);
    } else if (strcmp(what, "machine") == 0) {
        the_plan.machine = rest;
    } else if (strcmp(what, "description") == 0) {
        the_plan.description = rest;
    } else if (strcmp(what, "plant") == 0) {
        read_port(&the_plan.plant_ports, &the_plan.plant, rest);
    } else if (strcmp(what, "output") == 0) {
        read_port(&the_plan.output_ports, &the_plan.outputs, rest);
    } else if (strcmp(what, "property") == 0) {
        read_port(&the_plan.property_ports, &the_plan.properties, rest);
    } else if (strcmp(what, "label") == 0 && last_port != NULL) {
        read_name(&last_port->labels, &last_port->label_count, rest);
    } else if (strcmp(what, "operation") == 0) {
        read_name(&the_plan.operation_names, &the_plan.operations, rest);
    } else {
        fail("the plan's line %d begins with `%s`", line_number, what);
    }
}

/* The whole file as text; it stays, since names and messages point into it. */
static char *read_file(const char *path)
{
    size_t used = 0;
    size_t room = 0;
    char *text = NULL;
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        fail("the plan %s cannot be opened", path);
    }
    for (;;) {
        size_t got;
        room += 1U << 20U;
        text = realloc(text, room + 1);
        if (text == NULL) {
            fail("there is no memory for the plan");
        }
        got = fread(text + used, 1, room - used, file);
        used += got;
        if (used < room) {
            break;
        }
    }
    if (ferror(file)) {
        fail("the plan %s cannot be read", path);
    }
    fclose(file);
    text[used] = '\0';
    return text;
}

void plan_read(const char *path)
{
    char *rest = read_file(path);
    file_text = rest;
    while (*rest != '\0') {
        char *end = strchr(rest, '\n');
        if (end == NULL) {
            fail("the plan's last line has no end");
        }
        *end = '\0';
        line_number++;
        read_line(rest);
        rest = end + 1;
    }
    if (the_plan.machine == NULL || the_plan.description == NULL || the_plan.line_count == 0) {
        fail("the plan is empty");
    }
}
