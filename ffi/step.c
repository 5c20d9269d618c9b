/* Steps and operations of a machine, and the texts of its errors.
 *
 * Included at the end of a generated machine file, whose tables it interprets:
 * `lw_component_table`, `lw_plant_table`, `lw_operation_table`, `lw_justice_table`,
 * `lw_property_names`, `lw_property_ranges`, `machine_done` and `machine_write`. The semantics of a
 * step and an operation, and the order of the checks, are documented in
 * `crates/station/src/interpret.rs`; the two implementations are tested against each other. This
 * file does not depend on instances, threads or the platform. */
#include "machine.h"

#include <string.h>

/* ---- Errors ---------------------------------------------------------------------------------- */

#define LW_TEXT_SIZE 1024
#define LW_PIECES 8
#define LW_NAME_SIZE 64

/* An error: a list of text constants, with at most one integer, one real number and one name from
 * the host among them. The list becomes one text only when a host reads the error. */
typedef struct lw_error {
    int pieces;
    const char *piece[LW_PIECES];
    int64_t integer;
    double real;
    char name[LW_NAME_SIZE];
    const char *rule; /* name of the broken rule, or null */
} lw_error;

/* Placeholders among the pieces, recognized by their addresses. */
static const char lw_integer_slot[] = "(integer)";
static const char lw_real_slot[] = "(real)";
static const char lw_name_slot[] = "(name)";

static void lw_append(lw_error *error, const char *text)
{
    if (error->pieces < LW_PIECES) {
        error->piece[error->pieces] = text;
        error->pieces++;
    }
}

static void lw_append_integer(lw_error *error, int64_t value)
{
    error->integer = value;
    lw_append(error, lw_integer_slot);
}

static void lw_append_real(lw_error *error, double value)
{
    error->real = value;
    lw_append(error, lw_real_slot);
}

/* Appends a text that the host can free later: copies it, shortened if it is too long. */
LW_MAY_BE_UNUSED static void lw_append_name(lw_error *error, const char *name)
{
    size_t length = 0;
    while (name[length] != '\0' && length + 1 < LW_NAME_SIZE) {
        error->name[length] = name[length];
        length++;
    }
    if (name[length] != '\0') {
        /* Do not cut within a UTF-8 character. */
        while (length > 0 && ((unsigned char)name[length] & 0xC0U) == 0x80U) {
            length--;
        }
    }
    error->name[length] = '\0';
    lw_append(error, lw_name_slot);
    if (name[length] != '\0') {
        lw_append(error, "...");
    }
}

static int32_t lw_fail(lw_error *error, int32_t code, const char *text)
{
    error->pieces = 0;
    error->rule = NULL;
    lw_append(error, text);
    return code;
}

static int32_t lw_fail_name(lw_error *error, int32_t code, const char *before, const char *name, const char *after)
{
    lw_fail(error, code, before);
    lw_append(error, name);
    lw_append(error, after);
    return code;
}

static int32_t lw_fail_domain(lw_error *error, const char *component, const char *what, const char *name, int64_t value,
                              const char *domain)
{
    lw_fail(error, LW_ERROR_DOMAIN, component);
    lw_append(error, what);
    lw_append(error, name);
    lw_append(error, "` is ");
    lw_append_integer(error, value);
    lw_append(error, ", outside its domain ");
    lw_append(error, domain);
    return LW_ERROR_DOMAIN;
}

static int32_t lw_fail_operation(lw_error *error, int64_t operation)
{
    lw_fail(error, LW_ERROR_OPERATION, "there is no operation ");
    lw_append_integer(error, operation);
    return LW_ERROR_OPERATION;
}

static int32_t lw_fail_rule(lw_error *error, int32_t code, const lw_rule *rule)
{
    lw_fail(error, code, rule->message);
    error->rule = rule->rule;
    return code;
}

/* A text buffer. Numbers are formatted without printf, which depends on the host's locale and can
 * allocate memory. */
typedef struct lw_text {
    size_t length;
    char text[LW_TEXT_SIZE];
} lw_text;

static void lw_write(lw_text *out, const char *text)
{
    size_t i = 0;
    while (text[i] != '\0' && out->length + 1 < LW_TEXT_SIZE) {
        out->text[out->length] = text[i];
        out->length++;
        i++;
    }
    if (text[i] != '\0') {
        while (out->length > 0 && ((unsigned char)text[i] & 0xC0U) == 0x80U && i > 0) {
            out->length--;
            i--;
        }
    }
    out->text[out->length] = '\0';
}

static void lw_write_integer(lw_text *out, int64_t value)
{
    char digits[24];
    int at = (int)sizeof digits - 1;
    uint64_t rest = value < 0 ? (uint64_t)0 - (uint64_t)value : (uint64_t)value;
    digits[at] = '\0';
    do {
        at--;
        digits[at] = (char)('0' + (int)(rest % 10U));
        rest /= 10U;
    } while (rest != 0);
    if (value < 0) {
        at--;
        digits[at] = '-';
    }
    lw_write(out, &digits[at]);
}

/* Writes a number with up to six decimals, without trailing zeros. */
static void lw_write_real(lw_text *out, double value)
{
    if (!(fabs(value) < 1e12)) {
        lw_write(out, "out of range");
        return;
    }
    double millionths = round(fabs(value) * 1e6);
    int64_t whole = (int64_t)millionths / 1000000;
    int64_t part = (int64_t)millionths % 1000000;
    if (value < 0 && (whole != 0 || part != 0)) {
        lw_write(out, "-");
    }
    lw_write_integer(out, whole);
    if (part != 0) {
        char decimals[8];
        int length = 6;
        decimals[0] = '.';
        for (int i = 6; i >= 1; i--) {
            decimals[i] = (char)('0' + (int)(part % 10));
            part /= 10;
        }
        while (decimals[length] == '0') {
            length--;
        }
        decimals[length + 1] = '\0';
        lw_write(out, decimals);
    }
}

/* Writes the text of an error; empty if there was no error. */
static void lw_format_error(const lw_error *error, lw_text *out)
{
    out->length = 0;
    out->text[0] = '\0';
    for (int i = 0; i < error->pieces; i++) {
        const char *piece = error->piece[i];
        if (piece == lw_integer_slot) {
            lw_write_integer(out, error->integer);
        } else if (piece == lw_real_slot) {
            lw_write_real(out, error->real);
        } else {
            lw_write(out, piece == lw_name_slot ? error->name : piece);
        }
    }
}

/* ---- One step -------------------------------------------------------------------------------- */

/* Checks one side of a contract: the initial conditions in step 0 or safety in a later step, then
 * the invariants. Returns the first formula that is broken, or null. */
LW_INLINE const lw_rule *lw_first_broken(const lw_side *side, int started, const int64_t *previous, const int64_t *current)
{
    const lw_formulas *first = started ? &side->safety : &side->initial;
    if (first->check != NULL) {
        int broken = first->check(previous, current);
        if (broken >= 0) {
            return &first->rules[broken];
        }
    }
    if (side->invariants.check != NULL) {
        int broken = side->invariants.check(previous, current);
        if (broken >= 0) {
            return &side->invariants.rules[broken];
        }
    }
    return NULL;
}

/* Finds the answer of a component in a place, for inputs that keep its assumptions. */
LW_INLINE const lw_leaf *lw_find_leaf(const lw_component *component, int place, const int64_t *current)
{
    int branch = component->root[place];
    while (branch >= 0) {
        const lw_split *split = &component->splits[branch];
        branch = current[split->variable] <= split->bound ? split->at_most : split->above;
    }
    return &component->leaves[-1 - branch];
}

LW_INLINE void lw_set_outputs(const lw_component *component, int answer, int64_t *current)
{
    const lw_number *values = &component->answers[answer * component->outputs];
    LW_UNROLL
    for (int i = 0; i < component->outputs; i++) {
        current[component->output[i]] = values[i];
    }
}

#ifdef LW_MAX_SHIFTED
static int lw_holds(const lw_functions *functions, uint32_t edge, const int64_t *const *values)
{
    uint32_t holds = edge & 1U;
    while (edge > 1U) {
        const lw_node *node = &functions->nodes[edge / 2U - 1U];
        uint64_t value = (uint64_t)values[node->from][node->value];
        edge = (value >> node->shift & 1U) != 0 ? node->high : node->low;
        holds ^= edge & 1U;
    }
    return (int)holds;
}

static void lw_shift(const lw_functions *functions, const int64_t *previous, const int64_t *current, int64_t *shifted)
{
    for (int i = 0; i < functions->shifted_count; i++) {
        const lw_shifted *variable = &functions->shifted[i];
        shifted[2 * i] = (int64_t)((uint64_t)previous[variable->value] - (uint64_t)variable->low);
        shifted[2 * i + 1] = (int64_t)((uint64_t)current[variable->value] - (uint64_t)variable->low);
    }
}

/* Follows a walk, which sets output bits. These bits must be 0 beforehand. */
static void lw_walk(const lw_node *walk, uint32_t place, const int64_t *const *values, int64_t *const *results)
{
    while (place > 0U) {
        const lw_node *at = &walk[place - 1U];
        if (at->from < LW_PUT) {
            uint64_t value = (uint64_t)values[at->from][at->value];
            place = (value >> at->shift & 1U) != 0 ? at->high : at->low;
        } else {
            results[at->from - LW_PUT][at->value] |= (int64_t)((uint64_t)at->low << at->shift);
            place = at->high;
        }
    }
}

/* Computes the outputs of a step from a component's functions. */
static void lw_compute(const lw_component *component, int place, const int64_t *previous, int64_t *current)
{
    const lw_functions *functions = component->functions;
    uint32_t first = 0;
    int64_t shifted[2 * LW_MAX_SHIFTED + 1];
    const int64_t *const values[] = { previous, current, shifted };
    int64_t *const results[] = { NULL, current, shifted };

    lw_shift(functions, previous, current, shifted);
    if (place > 0) {
        const lw_mode *mode = &functions->modes[functions->goals[place - 1].mode];
        while (!lw_holds(functions, mode->when, values)) {
            mode++;
        }
        first = mode->first;
    }
    for (int i = 0; i < component->outputs; i++) {
        current[component->output[i]] = 0;
    }
    for (int i = 0; i < functions->shifted_count; i++) {
        if (functions->shifted[i].computed) {
            shifted[2 * i + 1] = 0;
        }
    }
    for (const uint32_t *place = &functions->walks[first]; *place > 0U; place++) {
        lw_walk(functions->walk, *place, values, results);
    }
    for (int i = 0; i < functions->shifted_count; i++) {
        const lw_shifted *variable = &functions->shifted[i];
        if (variable->computed) {
            current[variable->value] = variable->low + shifted[2 * i + 1];
        }
    }
}

/* Returns the place after a step whose outputs are known: the goal that is pursued next. */
static int lw_next_goal(const lw_component *component, int place, const int64_t *previous, const int64_t *current)
{
    const lw_functions *functions = component->functions;
    int64_t shifted[2 * LW_MAX_SHIFTED + 1];
    const int64_t *const values[] = { previous, current, shifted };

    if (place == 0) {
        return 1;
    }
    lw_shift(functions, previous, current, shifted);
    return lw_holds(functions, functions->goals[place - 1].reached, values) ? place % functions->goal_count + 1 : place;
}
#endif

/* Sets the outputs of a component, and returns its next place, or -1 if there is no transition. */
LW_INLINE int lw_respond(const lw_component *component, int place, const int64_t *previous, int64_t *current)
{
#ifdef LW_MAX_SHIFTED
    if (component->functions != NULL) {
        if (!component->moore) {
            lw_compute(component, place, previous, current);
        }
        return lw_next_goal(component, place, previous, current);
    }
#else
    (void)previous;
#endif
    const lw_leaf *leaf = lw_find_leaf(component, place, current);
    if (leaf->to >= 0) {
        lw_set_outputs(component, leaf->answer, current);
    }
    return leaf->to;
}

/* Sets the outputs of a Moore component before its inputs are known. Returns 0 if the component has
 * no outputs in its current place. */
LW_INLINE int lw_respond_first(const lw_component *component, int place, const int64_t *previous, int64_t *current)
{
#ifdef LW_MAX_SHIFTED
    if (component->functions != NULL) {
        lw_compute(component, place, previous, current);
        return 1;
    }
#else
    (void)previous;
#endif
    int answer = component->first_answer[place];
    if (answer < 0) {
        return 0;
    }
    lw_set_outputs(component, answer, current);
    return 1;
}

/* Steps one component: binds its inputs, checks their domains and its assumptions, sets its outputs
 * and checks its guarantees. */
LW_INLINE int32_t lw_answer(int index, int started, const lw_state *before, lw_state *after, lw_error *error)
{
    const lw_component *component = &lw_component_table[index];
    const int64_t *previous = &before->values[component->first_value];
    int64_t *current = &after->values[component->first_value];

    component->bind(after->values, current);
    LW_UNROLL
    for (int i = 0; i < component->inputs; i++) {
        const lw_input *input = &component->input[i];
        int64_t value = current[input->value];
        if (value < input->low || value > input->high) {
            return lw_fail_domain(error, component->name, ": input `", input->name, value, input->domain);
        }
    }
    const lw_rule *broken = lw_first_broken(&component->assumptions, started, previous, current);
    if (broken != NULL) {
        return lw_fail_rule(error, component->watches ? LW_ERROR_ORDER : LW_ERROR_ASSUMPTION, broken);
    }
    int to = lw_respond(component, before->place[index], previous, current);
    if (to < 0) {
        return lw_fail_name(error, LW_ERROR_INTERNAL, "", component->name,
                            ": there is no transition for inputs that keep the assumptions; please report this");
    }
    broken = lw_first_broken(&component->guarantees, started, previous, current);
    if (broken != NULL) {
        return lw_fail_rule(error, LW_ERROR_GUARANTEE, broken);
    }
    after->place[index] = to;
    return LW_OK;
}

/* Sets a Moore component's outputs before any component reads its inputs. */
LW_INLINE int32_t lw_answer_first(int index, const lw_state *before, lw_state *after, lw_error *error)
{
    const lw_component *component = &lw_component_table[index];
    const int64_t *previous = &before->values[component->first_value];
    int64_t *current = &after->values[component->first_value];
    if (!lw_respond_first(component, before->place[index], previous, current)) {
        /* A verified table has a row for every input that keeps the assumptions, so no input keeps
         * them in this place. */
        return lw_fail_name(error, LW_ERROR_ASSUMPTION, "", component->name,
                            ": its assumptions contradict each other here: no inputs keep them");
    }
    return LW_OK;
}

/* Checks the plant inputs of a step that the host requested. */
static int32_t lw_check_plant(const int64_t *plant, lw_error *error)
{
    for (int i = 0; i < LW_PLANT; i++) {
        const lw_plant_input *input = &lw_plant_table[i];
        if (plant[i] < input->low || plant[i] > input->high) {
            return lw_fail_domain(error, "", "plant input `", input->name, plant[i], input->domain);
        }
    }
    return LW_OK;
}

/* Makes one step from `before` to `after`. `LW_EACH_MOORE` and `LW_EACH_MEALY` list the components'
 * numbers as constants, so that the compiler also sees each component's tables as constants;
 * `started` is a constant for the same reason. */
LW_INLINE int32_t lw_make_step(int started, const lw_state *before, const int64_t *plant, lw_state *after,
                               lw_error *error)
{
    int32_t code = LW_OK;
    for (int i = 0; i < LW_PLANT; i++) {
        after->values[i] = plant[i];
    }
#define LW_ANSWER_FIRST(index) \
    if (code == LW_OK) { \
        code = lw_answer_first(index, before, after, error); \
    }
#define LW_ANSWER(index) \
    if (code == LW_OK) { \
        code = lw_answer(index, started, before, after, error); \
    }
    LW_EACH_MOORE(LW_ANSWER_FIRST)
    LW_EACH_MEALY(LW_ANSWER)
    LW_EACH_MOORE(LW_ANSWER)
#undef LW_ANSWER_FIRST
#undef LW_ANSWER
    after->started = 1;
    return code;
}

/* Makes one step with plant inputs that are within their domains. */
static int32_t lw_advance(const lw_state *before, const int64_t *plant, lw_state *after, lw_error *error)
{
    return before->started ? lw_make_step(1, before, plant, after, error)
                           : lw_make_step(0, before, plant, after, error);
}

/* ---- One operation --------------------------------------------------------------------------- */

/* Running totals of an operation. */
typedef struct lw_job {
    const double *properties;
    int running[LW_COMPONENTS + 1]; /* components that were active in the previous step */
    int64_t held[LW_JUSTICE + 1];   /* step, from 1, in which each justice assumption last held */
    double control;                 /* seconds of the steps in which no action was active */
    lw_service service;
} lw_job;

/* Computes the plant inputs of an operation. A value that comes from properties must be within 1e-9
 * of an integer of its domain. */
static int32_t lw_abstract(const lw_state *state, const double *properties, int64_t operation, int64_t *plant,
                           lw_error *error)
{
    for (int i = 0; i < LW_PROPERTIES; i++) {
        if (!isfinite(properties[i])) {
            return lw_fail_name(error, LW_ERROR_DOMAIN, "property `", lw_property_names[i], "` is not a finite number");
        }
    }
    for (int i = 0; i < LW_PLANT; i++) {
        const lw_plant_input *input = &lw_plant_table[i];
        plant[i] = input->source == LW_FROM_SCRIPT ? input->script[0] : operation;
        if (input->source == LW_FROM_PROPERTY) {
            double value = input->abstraction(properties, state->values);
            double nearest = round(value);
            if (!(fabs(value - nearest) <= 1e-9 && nearest >= (double)input->low && nearest <= (double)input->high)) {
                lw_fail(error, LW_ERROR_DOMAIN, input->about);
                lw_append(error, " would be ");
                lw_append_real(error, value);
                lw_append(error, ", not an integer of ");
                lw_append(error, input->domain);
                return LW_ERROR_DOMAIN;
            }
            plant[i] = (int64_t)nearest;
        }
    }
    return LW_OK;
}

/* Adds one component's share of a step: its justice, its power, and its time. All components work
 * at the same time, so the step takes as long as the slowest one. `*seconds` stays negative while
 * no component is active. */
LW_INLINE int32_t lw_charge_for(int index, lw_job *job, const lw_state *start, const lw_state *before,
                                const lw_state *after, double *seconds, double *watts, lw_error *error)
{
    const lw_component *component = &lw_component_table[index];
    const int64_t *previous = &before->values[component->first_value];
    const int64_t *current = &after->values[component->first_value];
    if (component->justice != NULL) {
        component->justice(previous, current, before->started, job->service.steps,
                           &job->held[component->first_justice]);
    }
    if (component->active == NULL || !component->active(after->values)) {
        job->running[index] = 0;
        return LW_OK;
    }
    double drawn = component->watts(job->properties, start->values);
    if (!isfinite(drawn)) {
        return lw_fail_name(error, LW_ERROR_DOMAIN, "", component->name, ": its power is not a finite number");
    }
    *watts += drawn;
    double takes = 0.0;
    if (component->time == LW_TIME_STEP || !job->running[index]) {
        takes = component->seconds(job->properties, start->values);
        if (!(isfinite(takes) && takes >= 0.0)) {
            return lw_fail_name(error, LW_ERROR_DOMAIN, "", component->name,
                                ": its time is not a finite number of at least 0");
        }
    }
    if (takes > *seconds) {
        *seconds = takes;
    }
    job->running[index] = 1;
    return LW_OK;
}

/* Adds the time, energy and justice of one step to the totals. */
static int32_t lw_charge(lw_job *job, const lw_state *start, const lw_state *before, const lw_state *after,
                         lw_error *error)
{
    int32_t code = LW_OK;
    double seconds = -1.0;
    double watts = LW_BASE_WATTS;
    job->service.steps++;
#define LW_CHARGE(index) \
    if (code == LW_OK) { \
        code = lw_charge_for(index, job, start, before, after, &seconds, &watts, error); \
    }
    LW_EACH_COMPONENT(LW_CHARGE)
#undef LW_CHARGE
    if (code == LW_OK) {
        double took = seconds < 0.0 ? LW_STEP_SECONDS : seconds;
        job->service.seconds += took;
        job->control += seconds < 0.0 ? took : 0.0;
        job->service.joules += took * watts;
    }
    return code;
}

static int32_t lw_fail_limit(const lw_job *job, const char *operation, lw_error *error)
{
    int longest = -1;
    lw_fail_name(error, LW_ERROR_LIMIT, "`", operation, "` did not end within " LW_STEP_LIMIT_TEXT " steps");
    for (int j = 0; j < LW_JUSTICE; j++) {
        if (longest < 0 || job->held[j] <= job->held[longest]) {
            longest = j;
        }
    }
    /* If all of them held in the last step, none is to blame. */
    if (longest >= 0 && job->held[longest] < job->service.steps) {
        int64_t silence = job->service.steps - job->held[longest];
        lw_append(error, "; for ");
        lw_append_integer(error, silence);
        lw_append(error, silence == 1 ? " step " : " steps ");
        lw_append(error, lw_justice_table[longest].message);
        error->rule = lw_justice_table[longest].rule;
    }
    return LW_ERROR_LIMIT;
}

/* Computes and checks the properties after an operation. */
static int32_t lw_write_properties(const double *properties, const int64_t *values, double *after, lw_error *error)
{
    for (int i = 0; i < LW_PROPERTIES; i++) {
        after[i] = properties[i];
    }
    machine_write(properties, values, after);
    for (int i = 0; i < LW_PROPERTIES; i++) {
        if (!isfinite(after[i])) {
            return lw_fail_name(error, LW_ERROR_DOMAIN, "property `", lw_property_names[i],
                                "` would get a value that is not a finite number");
        }
        if (lw_property_ranges[i].whole && after[i] != properties[i]
            && (after[i] < lw_property_ranges[i].low || after[i] > lw_property_ranges[i].high
                || after[i] != floor(after[i]))) {
            return lw_fail_name(error, LW_ERROR_DOMAIN, "property `", lw_property_names[i],
                                "` would get a value outside its range");
        }
    }
    return LW_OK;
}

/* Runs an operation from `state`. `state` changes only if the operation ends, or if the state is
 * reset at the step limit. `after` receives the properties, `control` the seconds of the steps in
 * which no action was active. */
static int32_t lw_perform(lw_state *state, int32_t operation, const double *properties, double *after,
                          lw_service *service, double *control, lw_error *error)
{
    lw_state states[2];
    lw_job job;
    int64_t plant[LW_PLANT + 1];
    int32_t code;

    if (operation < 0 || operation >= LW_OPERATIONS) {
        return lw_fail_operation(error, operation);
    }
    code = lw_abstract(state, properties, lw_operation_table[operation].value, plant, error);
    if (code != LW_OK) {
        return code;
    }
    memset(&job, 0, sizeof job);
    job.properties = properties;
    states[0] = *state;
    memset(&states[1], 0, sizeof states[1]);
    for (int64_t step = 0; step < LW_STEP_LIMIT; step++) {
        const lw_state *before = &states[step % 2];
        lw_state *next = &states[(step + 1) % 2];
        LW_UNROLL
        for (int i = 0; i < LW_PLANT; i++) {
            /* A script of one value is a constant, which lw_abstract has already set. */
            if (lw_plant_table[i].source == LW_FROM_SCRIPT && lw_plant_table[i].script_length > 1) {
                plant[i] = lw_plant_table[i].script[step % lw_plant_table[i].script_length];
            }
        }
        code = lw_advance(before, plant, next, error);
        if (code == LW_OK) {
            code = lw_charge(&job, state, before, next, error);
        }
        if (code != LW_OK) {
            return code;
        }
        if (machine_done(next->values)) {
            code = lw_write_properties(properties, next->values, after, error);
            if (code != LW_OK) {
                return code;
            }
            *service = job.service;
            *control = job.control;
            *state = *next;
            return LW_OK;
        }
    }
    memset(state, 0, sizeof *state);
    return lw_fail_limit(&job, lw_operation_table[operation].name, error);
}
