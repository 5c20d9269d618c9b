//! Truncated, changed or fabricated dumps: findings, never a panic, and never a profile that cannot
//! be read again.

use super::mocks::mocks;
use super::probing::{build, probe};
use crate::uf_value;
use linewright::station::profile::Profile;

/// splitmix64.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % bound.max(1) as u64) as usize
    }
}

fn mutated(text: &str, random: &mut Random) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..=random.below(4) {
        let at = random.below(lines.len());
        match random.below(9) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[random.below(lines.len())].clone()),
            2 => lines.truncate(at + 1),
            3 => {
                let other = random.below(lines.len());
                lines.swap(at, other);
            }
            4 => "call lw_probe_real_1".clone_into(&mut lines[at]),
            5 => lines[at] = format!("points {} 00", random.below(600)),
            6 => {
                let words = [
                    "expects integer:9223372036854775807",
                    "expects real:nan",
                    "expects text:ff",
                    "arg ",
                    "ret null",
                    "end",
                    "\u{202e}",
                    "linewright-probe 1",
                ];
                words[random.below(words.len())].clone_into(&mut lines[at]);
            }
            _ => {
                let line = &mut lines[at];
                let place = random.below(line.len());
                if line.is_char_boundary(place)
                    && line.is_char_boundary(place + 1)
                    && place < line.len()
                {
                    let digit = b"0123456789abcdef :\n"[random.below(19)] as char;
                    line.replace_range(place..=place, &digit.to_string());
                }
            }
        }
        if lines.is_empty() {
            break;
        }
    }
    let mut out = lines.join("\n") + "\n";
    if random.below(3) == 0 {
        let end = random.below(out.len());
        if out.is_char_boundary(end) {
            out.truncate(end);
        }
    }
    out
}

#[test]
fn damaged_dumps_give_findings() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = build(folder.path(), None);
    let mut random = Random(5);
    let (mut found, mut cases) = (0, 0);
    for mock in mocks() {
        let (printed, path) = probe(&mock, &first, folder.path(), &format!("{}.txt", mock.name));
        let layout = mock.layout(&printed);
        let profile = Profile {
            layout,
            ..Profile::assumed()
        };
        std::fs::write(folder.path().join("profile.toml"), profile.to_toml()).expect("a file");
        let second = build(folder.path(), Some("profile.toml"));
        let (_, confirmed) = probe(
            &mock,
            &second,
            folder.path(),
            &format!("{}-2.txt", mock.name),
        );
        for path in [path, confirmed] {
            let whole = std::fs::read_to_string(&path).expect("a dump");
            let second = whole.contains("lw_confirm_seen");
            assert_eq!(uf_value::dump(&whole), (true, second), "{}", mock.name);
            for _ in 0..300 {
                cases += 1;
                found += usize::from(uf_value::dump(&mutated(&whole, &mut random)).0);
            }
            // Truncated anywhere, the rest suffices or it does not.
            for _ in 0..60 {
                let end = random.below(whole.len());
                let _ = uf_value::dump(&whole[..end]);
            }
        }
    }
    println!("{found} of {cases} damaged dumps still tell a layout");
    assert!(found > 0 && found < cases);
}

/// Two dumps of different layouts in one session contradict each other.
#[test]
fn contradictions_are_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = build(folder.path(), None);
    let mocks = mocks();
    let texts: Vec<String> = [&mocks[0], &mocks[4]]
        .iter()
        .map(|mock| {
            let (_, path) = probe(mock, &first, folder.path(), &format!("{}.txt", mock.name));
            std::fs::read_to_string(path).expect("a dump")
        })
        .collect();
    let calls = texts[1].split_once("call ").expect("calls").1;
    let mixed = format!("{}call {calls}", texts[0]);
    assert_eq!(uf_value::dump(&mixed), (false, false));
    // Two sessions do not: the last one counts.
    assert_eq!(uf_value::dump(&texts.concat()), (true, false));
}
