# A rule among the transitions binds the step that is left: g and h together are legal, and the end.
ENV: r;
SYS: g h;

ENVINIT: ;
ENVTRANS: ;
ENVGOAL: ;

SYSINIT: ;
SYSTRANS: [](!(g & h)) & []((r -> g) & (r -> h'));
SYSGOAL: []<>(g & h);
