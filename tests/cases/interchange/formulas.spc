# Formulas, and who may refer to what.
ENV: a b x [0,3];
SYS: c y [0,3];
ENVINIT: a & c & b';
#~^ LW202 LW201
SYSINIT: c & x = 1;
#~^ LW006
ENVTRANS: [](a -> b') & [](c' -> a');
#~^ LW209
SYSTRANS: [](d | cc)
#~^ LW101 LW101
 & [](x) & [](x & a)
#~^ LW103 LW103
 & [](x = y) & [](3 < x)
#~^ LW002 LW002
 & [](a & ) & [](a b) & [](a') ')
#~^ LW002 LW002 LW002
 & [](a | b & c)
#~^ LW005
 & [](a -> b -> c) & [](x < 2.5)
#~^ LW005 LW110
 & []() & []((a) & []((a))) ;
#~^ LW002 LW201
SYSGOAL: []<>(c & c');
#~^ LW006
