# What holds for ever from some step on is called by its name.
ENV: a;
SYS: b;
ENVGOAL: <>[]a;
#~^ LW201
SYSTRANS: []b' & <>[](a -> b);
#~^ LW201
SYSGOAL: []<>a & <>[] b & []<>(<>[]b);
#~^ LW201 LW201
