//! The interpreter itself, compared with the rules of IEC 61131-3: the meaning of each construct,
//! and the errors.

use super::play::compiled;
use crate::iec::interpreter::Program;

/// A block with some variables; `x` is its result.
fn block(declarations: &str, body: &str) -> Result<Program, String> {
    compiled(&format!(
        "TYPE Colour : (red, green, blue); END_TYPE TYPE Small : INT(-2..3); END_TYPE\n\
         FUNCTION_BLOCK Sample VAR_INPUT a : INT; p : BOOL; END_VAR VAR_OUTPUT x : INT; c : Colour; b : BOOL; END_VAR\n\
         VAR n : INT; d : DINT; l : LINT; s : Small; {declarations} END_VAR\n\
         VAR CONSTANT k : ARRAY[1..3] OF INT := [10, 20, 30]; z : ARRAY[0..5] OF INT := [2(7), 3(8), 9]; END_VAR\n\
         VAR_TEMP t : INT; END_VAR\n{body}\nEND_FUNCTION_BLOCK"
    ))
}

/// The value of a variable after a call.
fn value_of(name: &str, body: &str) -> Result<i64, String> {
    let program = block("", body)?;
    let mut instance = program.instance();
    instance.call().map_err(|f| f.0)?;
    Ok(instance.get(&program.variables[name]))
}

fn x(body: &str) -> i64 {
    value_of("X", body).unwrap_or_else(|e| panic!("{body}: {e}"))
}

fn number(expression: &str) -> i64 {
    x(&format!("x := {expression};"))
}

fn truth(expression: &str) -> bool {
    value_of("B", &format!("b := {expression};")).unwrap_or_else(|e| panic!("{expression}: {e}"))
        != 0
}

/// The error for a text that is rejected before it runs.
fn refused(body: &str) -> String {
    match block("", body) {
        Ok(_) => panic!("accepted: {body}"),
        Err(error) => error,
    }
}

/// The fault that ends the call.
fn fault(body: &str) -> String {
    let program = block("", body).unwrap_or_else(|e| panic!("{body}: {e}"));
    let mut instance = program.instance();
    match instance.call() {
        Ok(()) => panic!("no fault: {body}"),
        Err(fault) => fault.0,
    }
}

#[test]
fn operators_bind_as_the_standard_says() {
    assert_eq!(number("2 + 3 * 4"), 14);
    assert_eq!(number("(2 + 3) * 4"), 20);
    assert_eq!(number("20 - 5 - 3"), 12);
    assert_eq!(number("100 / 5 / 2"), 10);
    assert_eq!(number("-2 + 5"), 3);
    assert_eq!(number("2 * 7 MOD 4"), 2);
    assert!(truth("NOT FALSE OR TRUE"));
    assert!(truth("TRUE OR TRUE AND FALSE"));
    assert!(truth("TRUE OR TRUE XOR TRUE"));
    assert!(!truth("TRUE XOR TRUE AND TRUE"));
    assert!(truth("NOT (1 = 2)"));
    assert!(truth("1 + 1 = 2 AND 3 > 2"));
    assert!(truth("2 < 3 = TRUE"));
    assert!(truth("TRUE & TRUE"));
}

#[test]
fn strings_are_assigned_and_fit() {
    let text = |body: &str| {
        let program = block("w : STRING[5];", body)?;
        let mut instance = program.instance();
        instance.call().map_err(|f| f.0)?;
        Ok::<_, String>(program.texts[instance.get(&program.variables["W"]) as usize].clone())
    };
    assert_eq!(text("w := 'it$'s$$';"), Ok("it's$".to_owned()));
    assert_eq!(text("x := 1;"), Ok(String::new()));
    for wrong in [
        "w := 'longer';",
        "w := 5;",
        "x := 'a';",
        "w := 'a",
        "w := '$n';",
        "w := 'ä';",
        "b := w < w;",
    ] {
        assert!(text(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn division_rounds_towards_zero_and_the_rest_follows_the_dividend() {
    for (a, b, quotient, rest) in [
        (7, 2, 3, 1),
        (-7, 2, -3, -1),
        (7, -2, -3, 1),
        (-7, -2, 3, -1),
    ] {
        assert_eq!(number(&format!("{a} / {b}")), quotient);
        assert_eq!(x(&format!("n := {a}; x := n MOD {b};")), rest);
    }
    assert_eq!(x("n := 5; x := n MOD 0;"), 0);
    assert!(fault("n := 0; x := 5 / n;").contains("division by 0"));
}

#[test]
fn numbers_stay_in_their_types() {
    assert_eq!(number("32767"), 32767);
    assert!(refused("x := 32768;").contains("no INT"));
    assert!(fault("n := 32767; x := n + 1;").contains("leaves its type"));
    assert!(fault("n := -32768; x := -n;").contains("leaves its type"));
    assert!(fault("n := 200; x := n * n;").contains("leaves its type"));
    assert_eq!(x("d := 70000; x := DINT_TO_INT(d - 60000);"), 10_000);
    assert!(fault("d := 70000; x := DINT_TO_INT(d);").contains("leaves its type"));
    assert!(refused("d := n;").contains("is wanted"));
    assert!(refused("x := n + d;").contains("is wanted"));
    assert_eq!(
        value_of("L", "l := LINT#-5_000_000_000;"),
        Ok(-5_000_000_000)
    );
    assert_eq!(x("d := INT_TO_DINT(n) + 1; x := DINT_TO_INT(d);"), 1);
    assert!(fault("n := 4; s := n;").contains("subrange"));
    assert_eq!(value_of("S", "n := 3; s := n;"), Ok(3));
}

#[test]
fn literals_have_bases_types_and_underscores() {
    assert_eq!(number("16#ff"), 255);
    assert_eq!(number("2#1010"), 10);
    assert_eq!(number("8#17"), 15);
    assert_eq!(number("1_000"), 1000);
    assert_eq!(number("INT#-3"), -3);
    assert!(truth("BOOL#1"));
    assert!(refused("x := 1__0;").contains("no number"));
    assert!(refused("x := 9x;").contains("no number"));
    assert!(refused("x := DINT#3;").contains("is wanted"));
}

#[test]
fn names_are_the_same_in_upper_and_lower_case() {
    assert_eq!(x("X := 1; x := X + 1; iF TRUE tHEN X := x + 1; End_If;"), 3);
    assert!(block("ABC : INT; abc : INT;", ";").is_err());
    assert!(block("red : INT;", ";").is_err());
    assert!(block("sample : INT;", ";").is_err());
    assert!(block("step : INT;", ";").is_err());
    assert!(block("a__b : INT;", ";").is_err());
    assert!(block("b_ : INT;", ";").is_err());
}

#[test]
fn enumerations_are_types_of_their_own() {
    assert_eq!(value_of("C", "c := blue;"), Ok(2));
    assert_eq!(value_of("C", "c := Colour#green;"), Ok(1));
    assert!(truth("c = red"));
    assert!(truth("c <> green"));
    assert!(refused("c := 1;").contains("is wanted"));
    assert!(refused("x := red;").contains("is wanted"));
    assert!(refused("b := c < green;").contains("`<`"));
    assert!(refused("c := Colour#pink;").contains("no label"));
}

#[test]
fn a_case_takes_the_branch_of_its_value() {
    let body =
        "n := {}; CASE n OF -1: x := 1; 2, 5..7: x := 2; n := 0; 8: ; ELSE x := 3; END_CASE;";
    for (value, wanted) in [(-1, 1), (2, 2), (3, 3), (5, 2), (7, 2), (8, 0), (9, 3)] {
        assert_eq!(
            x(&body.replace("{}", &value.to_string())),
            wanted,
            "{value}"
        );
    }
    assert_eq!(
        x("c := green; CASE c OF red: x := 1; green, blue: x := 2; END_CASE;"),
        2
    );
    assert_eq!(x("CASE n OF 1: x := 1; END_CASE;"), 0);
    assert!(refused("CASE n OF 1: ; 0..3: ; END_CASE;").contains("twice"));
    assert!(refused("CASE n OF a: ; END_CASE;").contains("no constant"));
    assert!(refused("CASE p OF 1: ; END_CASE;").contains("chooses"));
}

#[test]
fn loops_turn_as_often_as_they_say() {
    assert_eq!(x("FOR n := 1 TO 4 DO x := x + n; END_FOR;"), 10);
    assert_eq!(x("FOR n := 4 TO 1 DO x := 1; END_FOR;"), 0);
    assert_eq!(x("FOR n := 7 TO 1 BY -3 DO x := x + n; END_FOR;"), 12);
    assert_eq!(
        x("FOR n := 1 TO 9 DO IF n = 4 THEN EXIT; END_IF; x := n; END_FOR;"),
        3
    );
    assert_eq!(
        x("FOR n := 1 TO 4 DO IF n = 2 THEN CONTINUE; END_IF; x := x + n; END_FOR;"),
        8
    );
    assert_eq!(x("WHILE x < 5 DO x := x + 2; END_WHILE;"), 6);
    assert_eq!(x("REPEAT x := x + 1; UNTIL TRUE END_REPEAT;"), 1);
    assert_eq!(x("x := 1; IF x = 1 THEN RETURN; END_IF; x := 2;"), 1);
    // EXIT leaves the inner loop only.
    assert_eq!(
        x("FOR n := 1 TO 3 DO WHILE TRUE DO x := x + 1; EXIT; END_WHILE; END_FOR;"),
        3
    );
    assert!(fault("WHILE TRUE DO x := 1; END_WHILE;").contains("does not end"));
    assert!(refused("FOR n := 1 TO 3 DO n := 2; END_FOR;").contains("changed within"));
    assert!(refused("FOR n := 1 TO 3 BY 0 DO ; END_FOR;").contains("does not advance"));
}

#[test]
fn conditions_take_the_first_branch_that_holds() {
    let body = "n := {}; IF n = 1 THEN x := 1; ELSIF n < 3 THEN x := 2; ELSE x := 3; END_IF;";
    for (value, wanted) in [(1, 1), (2, 2), (3, 3)] {
        assert_eq!(x(&body.replace("{}", &value.to_string())), wanted);
    }
    assert!(refused("IF n THEN ; END_IF;").contains("BOOL"));
    // Both operands are evaluated.
    assert!(fault("n := 4; b := FALSE AND (k[n] = 1);").contains("index"));
}

#[test]
fn arrays_are_bounded_and_initialised() {
    assert_eq!(number("k[1] + k[3]"), 40);
    assert_eq!(number("z[0] + z[1] * 10 + z[2] + z[5]"), 94);
    assert!(refused("x := k[0];").contains("leaves its array"));
    assert!(fault("n := 4; x := k[n];").contains("leaves its array"));
    assert!(refused("k[1] := 3;").contains("cannot be written"));
    assert!(refused("x := k;").contains("do not go together"));
    let program = block(
        "m : ARRAY[0..1, -1..1] OF INT := [1, 2, 3, 4, 5, 6];",
        "x := m[1, -1];",
    );
    let program = program.expect("arrays of two dimensions");
    let mut instance = program.instance();
    instance.call().expect("no fault");
    assert_eq!(instance.get(&program.variables["X"]), 4);
}

#[test]
fn only_some_variables_can_be_written_and_read() {
    assert!(refused("a := 1;").contains("cannot be written"));
    assert!(refused("y := 1;").contains("not declared"));
    assert!(fault("x := t;").contains("no value"));
    assert_eq!(x("t := 2; x := t;"), 2);
    assert!(fault("FOR t := 1 TO 2 DO ; END_FOR; x := t;").contains("no value"));
}

#[test]
fn functions_are_the_standards() {
    assert_eq!(number("ABS(-3)"), 3);
    assert_eq!(number("MIN(n, 4) + MAX(n, 4)"), 4);
    assert_eq!(number("LIMIT(0, n + 9, 5)"), 5);
    assert_eq!(number("SEL(FALSE, INT#1, INT#2)"), 1);
    assert_eq!(number("SEL(TRUE, INT#1, INT#2)"), 2);
    assert!(refused("x := FOO(1);").contains("no function"));
}

#[test]
fn comments_and_directives_mean_nothing() {
    assert_eq!(
        x("(* x := 1; *) x := 2; // x := 3;\n/* x := 4; */ {x := 5;}"),
        2
    );
    assert!(refused("(* (* *) *)").contains("comment"));
    assert!(refused("(* x").contains("no end"));
    assert!(refused("x := \"a\";").contains("means nothing"));
}

#[test]
fn what_is_kept_is_kept_from_call_to_call() {
    let program = block("", "n := n + 1; x := n;").expect("a block");
    let mut instance = program.instance();
    for call in 1..4 {
        instance.call().expect("no fault");
        assert_eq!(instance.get(&program.variables["X"]), call);
    }
}
