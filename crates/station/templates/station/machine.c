@ if wires
/* Indices of the plant inputs and the components' outputs among all values. */
enum {
@ for wire in wires
    @{wire.name} = @{wire.value}, /* @{wire.about} */
@ endfor
};

@ endif
@ for component in definitions
@{component}

@ endfor
/* ---- The machine ---------------------------------------------------------------------------------------- */

@ for input in plant
@ if input.source == "script"
static const int64_t @{input.prefix}_script[] = {
@ for value in input.script
    @{value},
@ else
    0
@ endfor
};

@ endif
@ if input.source == "property"
/* The property abstraction of @{input.about}. */
static double @{input.prefix}(const double *properties, const int64_t *values)
{
@ for name in input.abstraction.unused
    (void)@{name};
@ endfor
    return @{input.abstraction.value};
}

@ endif
@ endfor
static const lw_plant_input lw_plant_table[] = {
@ for input in plant
    { @{input.name}, @{input.domain}, @{input.low}, @{input.high}, @{input.fields},
        @{input.message} },
@ else
    { 0 }
@ endfor
};

static const lw_operation lw_operation_table[] = {
@ for operation in operations
    { @{operation.name}, @{operation.value} },
@ else
    { NULL, 0 }
@ endfor
};

@ for list in output_labels
static const char *const @{list.name}[] = {
@ for label in list.labels
    @{label},
@ else
    NULL
@ endfor
};

@ endfor
static const lw_wire lw_output_table[] = {
@ for output in outputs
    { @{output.name}, @{output.wire}, @{output.labels} },
@ else
    { NULL, 0, NULL }
@ endfor
};

static const char *const lw_property_names[] = {
@ for property in properties
    @{property.name}, /* @{property.unit} */
@ else
    NULL
@ endfor
};

@ for list in property_labels
static const char *const @{list.name}[] = {
@ for label in list.labels
    @{label},
@ else
    NULL
@ endfor
};

@ endfor
static const lw_range lw_property_ranges[] = {
@ for property in properties
@ if property.range
    { 1, @{property.range.low}.0, @{property.range.high}.0, @{property.range.labels} }, /* @{property.range.about} */
@ else
    { 0, 0.0, 0.0, NULL },
@ endif
@ else
    { 0, 0.0, 0.0, NULL }
@ endfor
};

/* Whether the operation has ended. */
static int machine_done(const int64_t *values)
{
@ for name in done.unused
    (void)@{name};
@ endfor
    return @{done.value};
}

/* Computes the properties after an operation. */
static void machine_write(const double *properties, const int64_t *values, double *after)
{
@ for name in unused_by_writes
    (void)@{name};
@ endfor
@ for write in writes
    /* @{write.about} */
    @{write.statement}
@ endfor
}

static const lw_component lw_component_table[] = {
@ for component in components
    { @{component.name}, @{component.moore}, @{component.watches}, @{component.first_value}, @{component.inputs}, @{component.outputs},
        @{component.prefix}_input, @{component.prefix}_output, @{component.controller}, @{component.prefix}_bind,
        {
            @{component.assumes.initial},
            @{component.assumes.invariants},
            @{component.assumes.safety} },
        {
            @{component.guarantees.initial},
            @{component.guarantees.invariants},
            @{component.guarantees.safety} },
        @{component.justice}, @{component.first_justice}, @{component.active}, @{component.time}, @{component.seconds}, @{component.watts} },
@ else
    { 0 }
@ endfor
};

static const lw_rule lw_justice_table[] = {
@ for rule in justice
    { @{rule.name},
      @{rule.message} },
@ else
    { NULL, NULL }
@ endfor
};

