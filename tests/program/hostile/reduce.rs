//! Reduces a file as far as possible while it still causes the same fault.

/// Removes lines as long as `fails` holds, within a maximum number of tests.
pub fn reduced_by_lines(
    bytes: &[u8],
    mut most: usize,
    fails: &mut dyn FnMut(&[u8]) -> bool,
) -> Vec<u8> {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return bytes.to_owned();
    };
    let lines = text.split_inclusive('\n').map(str::to_owned);
    without(lines.collect(), &mut most, fails)
        .concat()
        .into_bytes()
}

/// The same for other pieces, which together form the file.
pub fn reduced_by(
    pieces: Vec<String>,
    mut most: usize,
    fails: &mut dyn FnMut(&[u8]) -> bool,
) -> Vec<u8> {
    without(pieces, &mut most, fails).concat().into_bytes()
}

/// Delta debugging (Zeller and Hildebrandt, 2002), by complements: pieces of half the size in each
/// round.
fn without(
    mut pieces: Vec<String>,
    most: &mut usize,
    fails: &mut dyn FnMut(&[u8]) -> bool,
) -> Vec<String> {
    let mut size = pieces.len().div_ceil(2).max(1);
    loop {
        let mut at = 0;
        let mut smaller = false;
        while at < pieces.len() {
            if *most == 0 {
                return pieces;
            }
            *most -= 1;
            let end = (at + size).min(pieces.len());
            let rest = [&pieces[..at], &pieces[end..]].concat();
            if fails(rest.concat().as_bytes()) {
                pieces = rest;
                smaller = true;
            } else {
                at = end;
            }
        }
        if size == 1 && !smaller {
            return pieces;
        }
        size = size.div_ceil(2).max(1);
    }
}
