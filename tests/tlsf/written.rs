//! What is written can be read, and says the same.

#[path = "../interchange/random.rs"]
mod random;

use crate::{bench, read_text, shown, verdict};
use linewright::gr1::Specification;
use linewright::interchange::{Target, write};
use proptest::prelude::*;

fn again(specification: &Specification) -> (String, Specification) {
    let text = write(specification, Target::Tlsf).expect("it is small");
    let reading = read_text(&text);
    let findings = shown(&reading, &text);
    let back = reading
        .specification
        .unwrap_or_else(|| panic!("{text}\n{findings}"));
    (text, back)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn random_specifications_are_written_and_read(specification in random::specifications()) {
        let (text, back) = again(&specification);
        prop_assert_eq!(verdict(&specification), verdict(&back), "{}", text);
        prop_assert_eq!(specification.timing, back.timing);
        let (text, twice) = again(&back);
        prop_assert_eq!(verdict(&twice), verdict(&back), "{}", text);
    }
}

#[test]
fn public_files_are_written_and_read() {
    let Some(folder) = bench() else { return };
    let mut count = 0;
    for (name, known) in crate::KNOWN {
        let Some(realizable) = known else { continue };
        let text = std::fs::read_to_string(folder.join(format!("{name}.tlsf"))).expect("a file");
        let (_, back) = again(&crate::sound(&text));
        assert_eq!(verdict(&back), realizable, "{name}");
        count += 1;
    }
    assert_eq!(count, 5);
}
