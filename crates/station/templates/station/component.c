/* ---- @{title} @{dashes} */

/* The component's variables, in the order of its contract. */
@ if variables
enum {
@ for variable in variables
    @{variable.name}, /* @{variable.about} */
@ endfor
};

@ endif
static const lw_input @{prefix}_input[] = {
@ for input in inputs
    { @{input.name}, @{input.domain}, @{input.variable}, @{input.low}, @{input.high} },
@ else
    { 0 }
@ endfor
};

static const int @{prefix}_output[] = {
@ for variable in outputs
    @{variable},
@ else
    0
@ endfor
};

@ if decisions
/* The controller. A split is { variable, target if it is at most the bound, target if it is greater, bound }; a target is the number of
 * a split, or -1 - n for leaf n. A leaf is { answer, next place }; place 0 is before step 0, place s + 1 is state s. */
static const lw_split @{prefix}_splits[] = {
@ for split in decisions.splits
    { @{split.variable}, @{split.at_most}, @{split.above}, @{split.bound} }, /* @{split.about} */
@ else
    { 0 }
@ endfor
};

static const lw_leaf @{prefix}_leaves[] = {
@ for leaf in decisions.leaves
    { @{leaf.answer}, @{leaf.place} },
@ else
    { 0, -1 }
@ endfor
};

static const lw_number @{prefix}_answers[] = {
@ for answer in decisions.answers
    @{answer.values} /* @{answer.about} */
@ else
    0
@ endfor
};

static const int @{prefix}_root[] = {
@ for root in decisions.roots
@ if loop.first
    @{root}, /* before step 0 */
@ else
    @{root}, /* state @{loop.index0 - 1} */
@ endif
@ else
    0
@ endfor
};

@ if decisions.moore
static const int @{prefix}_first_answer[] = {
@ for answer in decisions.first_answers
    @{answer},
@ else
    -1
@ endfor
};

@ endif
@ endif
@ if functions
/* The controller as functions of @{functions.signals} signals. Walks compute all outputs; the first mode of a goal whose condition
 * holds selects the walks. */
static const lw_node @{prefix}_walk[] = {
@{functions.walk}
};

static const lw_node @{prefix}_nodes[] = {
@{functions.nodes}
};

/* First rows of the walks: those of step 0, then those of the modes. */
static const uint32_t @{prefix}_walks[] = {
@{functions.walks}
};

static const lw_mode @{prefix}_modes[] = {
@{functions.modes}
};

static const lw_goal @{prefix}_goals[] = {
@{functions.goals}
};

/* Variables whose domains do not begin at 0: { variable, whether it is an output, lowest value }. */
static const lw_shifted @{prefix}_shifted[] = {
@ for shifted in functions.shifted
    { @{shifted.variable}, @{shifted.output}, @{shifted.lowest} },
@ else
    { 0 }
@ endfor
};

static const lw_functions @{prefix}_functions = {
    @{prefix}_nodes, @{prefix}_shifted, @{functions.shifted_count}, @{prefix}_walk, @{prefix}_walks, @{prefix}_modes, @{prefix}_goals, @{functions.goal_count}
};

@ endif
static void @{prefix}_bind(const int64_t *values, int64_t *current)
{
@ for name in unused_by_bindings
    (void)@{name};
@ endfor
@ for statement in bindings
    @{statement}
@ endfor
}

@ for side in sides
/* @{side.title}. */
static const lw_rule @{prefix}_@{side.name}_rules[] = {
@ for rule in side.rules
    { @{rule.name},
      @{rule.message} },
@ endfor
};

static int @{prefix}_@{side.name}(const int64_t *previous, const int64_t *current)
{
@ for name in side.unused
    (void)@{name};
@ endfor
@ for check in side.checks
    /* @{check.about} */
    if (!(@{check.holds})) {
        return @{loop.index0};
    }
@ endfor
    return -1;
}

@ endfor
@ if justice
/* Assumptions about what happens infinitely often. */
static void @{prefix}_justice(const int64_t *previous, const int64_t *current, int earlier, int64_t step, int64_t *held)
{
@ for name in justice.unused
    (void)@{name};
@ endfor
@ for check in justice.checks
    /* @{check.about} */
    if (@{check.holds}) {
        held[@{loop.index0}] = step;
    }
@ endfor
}

@ endif
@ if action
/* Whether the action is active in this step. */
static int @{prefix}_active(const int64_t *values)
{
@ for name in action.active.unused
    (void)@{name};
@ endfor
    return @{action.active.value};
}

/* Duration of @{action.time_of}, in seconds. */
static double @{prefix}_seconds(const double *properties, const int64_t *values)
{
@ for name in action.seconds.unused
    (void)@{name};
@ endfor
    return @{action.seconds.value};
}

/* Power of the active action, in watts. */
static double @{prefix}_watts(const double *properties, const int64_t *values)
{
@ for name in action.watts.unused
    (void)@{name};
@ endfor
    return @{action.watts.value};
}

@ endif
