#define LW_FMI_FIRST_OPERATION @{first_operation}
#define LW_FMI_IDLE_WATTS @{idle_watts}
/* The communication step, which makes one step of the machine. */
#define LW_FMI_STEP_SECONDS @{step_seconds}
#define LW_FMI_STEP_TEXT @{step_text}

/* Type of every wire, and its value before the first step. */
static const lw_fmi_wire lw_fmi_wire_table[] = {
@ for wire in wires
    { @{wire.kind}, @{wire.before} }, /* @{wire.about} */
@ else
    { 0, 0 }
@ endfor
};

/* Start values of properties and parameters. */
static const double lw_fmi_defaults[] = {
@ for property in properties
    @{property.default}, /* @{property.about} */
@ else
    0.0
@ endfor
};

