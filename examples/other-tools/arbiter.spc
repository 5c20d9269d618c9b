# Two clients and one tool, for gr1c. A request stays until it is granted; nobody waits for ever.
ENV: request_a request_b;
SYS: grant_a grant_b waited [0,3];

ENVINIT: !request_a & !request_b;
ENVTRANS: [](request_a & !grant_a -> request_a')
        & [](request_b & !grant_b -> request_b');

SYSINIT: !grant_a & !grant_b & waited = 0;
SYSTRANS: [](!(grant_a' & grant_b'))
        & [](grant_a' -> request_a') & [](grant_b' -> request_b')
        & [](request_b & !grant_b & waited = 0 -> waited' = 1)
        & [](request_b & !grant_b & waited = 1 -> waited' = 2)
        & [](request_b & !grant_b & waited >= 2 -> waited' = 3)
        & [](!request_b | grant_b -> waited' = 0);
SYSGOAL: []<>(request_a -> grant_a) & []<>(waited < 2);
