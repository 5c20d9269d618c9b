/* A mock of Plant Simulation that uses a station library as a model does, and as it should not: every export, both kinds of numbers,
 * names with umlauts, wrong tags, wrong values, stale handles. The machine is the one of the test. The last line is HOST PASSED. */
#include "mock.h"

static int failures;

static void check(int holds, const char *what, int line)
{
    if (!holds) {
        printf("line %d: %s\n", line, what);
        failures++;
        if (failures > 20) {
            exit(1);
        }
    }
}

#define CHECK(condition) check((condition) != 0, #condition, __LINE__)

/* A number that came back, of either kind; far outside where it is none. */
static double number(variable v)
{
    return v.kind == MOCK_IS_REAL ? v.real : v.kind == MOCK_IS_INTEGER ? (double)v.integer : -1e300;
}

static int is_code(variable v, int code)
{
    return v.kind == MOCK_IS_INTEGER && v.integer == code;
}

static int alike(double a, double b)
{
    return a - b < 1e-9 && b - a < 1e-9;
}

static int says(variable answer, const char *utf8)
{
    return answer.kind == MOCK_IS_STRING && answer.string != NULL && mock_same(answer.string, mock_text(utf8));
}

#define SIMULATE(handle, operation, ...) CALL("simulate", handle, operation, __VA_ARGS__)
#define GOOD real(90.0), real(1.0), real(0.3)

int main(int argc, char **argv)
{
    static const char broken[] = "turn: the plant broke the assumption `gripped` (R-12): größer als 12 € → gegriffen";
    variable a, b, answer;
    double seconds;
    if (argc != 2) {
        return 2;
    }
    mock_load(argv[1]);

    /* Two instances, apart from each other. */
    a = CALL_0("instantiate");
    b = CALL_0("instantiate");
    CHECK(number(a) > 0.0 && number(b) > 0.0);
    CHECK(a.kind == (sizeof(MOCK_INTEGER) < 4 ? MOCK_IS_REAL : MOCK_IS_INTEGER));
    CHECK(!alike(number(a), number(b)));
    if (failures > 0) {
        return 1;
    }

    /* Nothing has ended yet. */
    CHECK(is_code(CALL("get_real", a, string("time")), -2));
    CHECK(says(CALL("last_error", a), "no operation has ended yet"));

    /* Real numbers, integers, an index, a name with an umlaut. */
    answer = SIMULATE(a, integer(0), GOOD);
    CHECK(answer.kind == MOCK_IS_REAL && answer.real > 0.0);
    seconds = answer.real;
    CHECK(alike(number(SIMULATE(b, integer(0), integer(90), integer(1), real(0.3))), seconds));
    CHECK(alike(number(CALL("get_real", a, string("time"))), seconds));
    CHECK(alike(number(CALL("get_real", a, string("Länge"))), 90.0));
    CHECK(alike(number(CALL("get_real", b, string("property.Länge"))), 90.0));
    CHECK(number(CALL("get_real", a, string("energy"))) > 0.0);
    answer = CALL("get_integer", a, string("steps"));
    CHECK(answer.kind == MOCK_IS_INTEGER && answer.integer > 0);
    CHECK(is_code(CALL("get_integer", a, string("verdict")), 0));
    CHECK(says(CALL("get_string", a, string("verdict")), "ok"));
    CHECK(is_code(CALL("reset", a), 0));
    CHECK(alike(number(SIMULATE(a, string("prüfen"), GOOD)), seconds));
    CHECK(is_code(CALL("reset", b), 0));
#if defined(MOCK_BOOLEAN)
    CHECK(alike(number(SIMULATE(b, integer(0), real(90.0), truth(1), real(0.3))), seconds));
#else
    CHECK(alike(number(SIMULATE(b, integer(0), real(90.0), integer(1), real(0.3))), seconds));
    (void)truth;
#endif
    CHECK(is_code(CALL("reset", b), 0));
    CHECK(alike(number(SIMULATE(b, integer(0), real(90.0), integer(1), duration(0.3))), seconds));
    CHECK(is_code(CALL("reset", a), 0));

    /* Every mistake is a code and a text, and changes nothing. */
    CHECK(alike(number(SIMULATE(a, integer(2), GOOD)), -4.0));
    CHECK(alike(number(SIMULATE(a, integer(-1), GOOD)), -4.0));
    CHECK(alike(number(SIMULATE(a, string("drehen"), GOOD)), -4.0));
    CHECK(says(CALL("last_error", a), "there is no operation `drehen`"));
    CHECK(alike(number(SIMULATE(a, string("prüfe"), GOOD)), -4.0));
    CHECK(alike(number(SIMULATE(a, real(0.0), GOOD)), -2.0));
    CHECK(alike(number(SIMULATE(a, integer(0), string("90"), real(1.0), real(0.3))), -2.0));
    answer = CALL("last_error", a);
    CHECK(says(answer, "property `Länge` must be a real number or an integer"));
    CHECK(alike(number(SIMULATE(a, integer(0), real(91.0), real(1.0), real(0.3))), -3.0));
    CHECK(says(answer, "property `Länge` must be a real number or an integer"));
    CHECK(alike(number(SIMULATE(a, integer(0), real(90.0), real(0.0), real(0.3))), -5.0));
    CHECK(says(CALL("last_error", a), broken));
    CHECK(is_code(CALL("get_integer", a, string("verdict")), -5));
    CHECK(says(CALL("get_string", a, string("verdict")), "assumption"));
    CHECK(is_code(CALL("get_real", a, string("Breite")), -2));
    CHECK(says(CALL("last_error", a), "there is no result `Breite`"));
    CHECK(is_code(CALL("get_real", a, integer(1)), -2));
    answer.kind = MOCK_IS_JUNK;
    CHECK(is_code(CALL("get_real", a, answer), -2));
    CHECK(alike(number(SIMULATE(answer, integer(0), GOOD)), -2.0));
    CHECK(alike(number(SIMULATE(string("1"), integer(0), GOOD)), -2.0));
    CHECK(alike(number(SIMULATE(a, integer(0), GOOD)), seconds));

    /* The description, in the host's encoding. */
    answer = CALL_0("station_describe");
    CHECK(answer.kind == MOCK_IS_STRING && answer.string != NULL && answer.string[0] == '{');
    if (answer.kind == MOCK_IS_STRING && answer.string != NULL) {
        const mock_char *name = mock_text("\"Länge\"");
        const mock_char *at = answer.string;
        int found = 0;
        for (; *at != 0; at++) {
            size_t i = 0;
            while (name[i] != 0 && at[i] == name[i]) {
                i++;
            }
            found |= name[i] == 0;
        }
        CHECK(found);
    }

    /* Handles that are stale, foreign or none. */
    CHECK(is_code(CALL("deinstantiate", a), 0));
    CHECK(is_code(CALL("deinstantiate", a), -1));
    CHECK(is_code(CALL("reset", a), -1));
    CHECK(alike(number(SIMULATE(a, integer(0), GOOD)), -1.0));
    CHECK(is_code(CALL("get_real", a, string("time")), -1));
    CHECK(says(CALL("last_error", a), "the handle was never issued by this library, or its instance was destroyed"));
    CHECK(is_code(CALL("reset", integer(0)), -1));
    CHECK(is_code(CALL("reset", integer(-5)), -1));
    CHECK(is_code(CALL("reset", integer(77)), -1));
    for (int i = 0; i < 1000; i++) {
        variable c = CALL_0("instantiate");
        CHECK(number(c) > 0.0);
        CHECK(alike(number(SIMULATE(c, integer(0), GOOD)), seconds));
        CHECK(is_code(CALL("deinstantiate", c), 0));
    }
    CHECK(alike(number(CALL("get_real", b, string("time"))), seconds));
    CHECK(is_code(CALL("deinstantiate", b), 0));
    mock_free();
    if (failures == 0) {
        printf("HOST PASSED\n");
    }
    return failures == 0 ? 0 : 1;
}
