# Sections, declarations, and the operators in front of formulas.
ENV: a [0,3] b a;
#~^ LW102
SYS: c d [1,3] e [0;
#~^ LW104 LW002
SYSINIT: c;
SYSINIT: !c;
#~^ LW002
SYSINIT: ;
#~^ LW002
nonsense
#~^ LW002
ENVTRANS: b;
#~^ LW002
ENVGOAL: []b;
#~^ LW002
SYSGOAL: []<>c & <>c;
#~^ LW002
SYSTRANS: [](c & []b)
#~^ LW201 LW002
