/* A mock of Plant Simulation that runs the probe's SimTalk, which the test has put into `calls.inc` as C. First it prints its
 * own layout. */
#include "mock.h"

static int layout(void)
{
    UF_Value v[2];
    memset(v, 0, sizeof v);
    printf("size %d\nvalue %d\ninteger_bits %d\ntag %d\ntag_bits %d\n", (int)((char *)&v[1] - (char *)&v[0]),
           (int)offsetof(UF_Value, value), 8 * (int)sizeof(MOCK_INTEGER), (int)offsetof(UF_Value, type),
           8 * (int)sizeof(MOCK_TAG));
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return 2;
    }
    (void)layout();
    (void)string;
    (void)truth;
    (void)duration;
    (void)real;
    (void)integer;
    (void)mock_same;
    mock_load(argv[1]);
#include "calls.inc"
    mock_free();
    printf("HOST PASSED\n");
    return 0;
}
