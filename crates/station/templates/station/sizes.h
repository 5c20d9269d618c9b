#define LW_COMPONENTS @{components}
#define LW_PLANT @{plant}
#define LW_OUTPUTS @{outputs}
#define LW_VALUES @{values}
#define LW_PROPERTIES @{properties}
#define LW_OPERATIONS @{operations}
#define LW_JUSTICE @{justice}
@ if max_shifted != none
#define LW_MAX_SHIFTED @{max_shifted}
@ endif
#define LW_NUMBER @{number}
#define LW_EACH_COMPONENT(DO)@% for component in each_component %@ DO(@{component})@% endfor %@
#define LW_EACH_MOORE(DO)@% for component in each_moore %@ DO(@{component})@% endfor %@
#define LW_EACH_MEALY(DO)@% for component in each_mealy %@ DO(@{component})@% endfor %@
#define LW_STEP_LIMIT @{step_limit}
#define LW_STEP_LIMIT_TEXT "@{step_limit_text}"
#define LW_STEP_SECONDS @{step_seconds}
#define LW_BASE_WATTS @{base_watts}
