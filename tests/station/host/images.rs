//! Library files: what a PE image exports and an ELF image needs, and 32-bit images.

use super::programs::Prepared;
use linewright::station::toolchain::{CrossCompiler, Platform};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn u16_at(image: &[u8], at: usize) -> usize {
    usize::from(u16::from_le_bytes([image[at], image[at + 1]]))
}

fn u32_at(image: &[u8], at: usize) -> usize {
    let bytes = image[at..at + 4].try_into().expect("four bytes");
    u32::from_le_bytes(bytes) as usize
}

/// Offset of the COFF header in a PE image.
fn coff(image: &[u8]) -> usize {
    let at = u32_at(image, 0x3c);
    assert_eq!(&image[at..at + 4], b"PE\0\0", "a PE image");
    at + 4
}

fn is_elf(image: &[u8]) -> bool {
    image.starts_with(b"\x7fELF")
}

/// The image marked as one for 32-bit processors. Only what a loader reads first is changed.
pub fn as_32_bit(image: &[u8]) -> Vec<u8> {
    let mut image = image.to_vec();
    if is_elf(&image) {
        // The class and the processor.
        assert_eq!(
            (image[4], u16_at(&image, 18)),
            (2, 62),
            "an ELF image for x86-64"
        );
        image[4] = 1;
        image[18..20].copy_from_slice(&3_u16.to_le_bytes());
    } else {
        let coff = coff(&image);
        assert_eq!(
            (u16_at(&image, coff), u16_at(&image, coff + 20)),
            (0x8664, 0x20b),
            "a PE image for x86-64"
        );
        image[coff..coff + 2].copy_from_slice(&0x14c_u16.to_le_bytes());
        image[coff + 20..coff + 22].copy_from_slice(&0x10b_u16.to_le_bytes());
    }
    image
}

/// A library made for 32 bits, if a compiler supports that without the system's headers.
pub fn real_32_bit(prepared: &Prepared, platform: Platform) -> Option<PathBuf> {
    let folder = prepared.folder();
    let source = folder.join("small.c");
    let (text, path, mut compilers) = if platform == Platform::Host {
        let mut cc = Command::new("cc");
        cc.arg("-m32");
        (
            "int lw_create(void) { return 1; }\n",
            folder.join("small.so"),
            vec![cc],
        )
    } else {
        let text = "__declspec(dllexport) int lw_create(void) { return 1; }\n\
                    int __stdcall DllMainCRTStartup(void *a, unsigned b, void *c);\n\
                    int __stdcall DllMainCRTStartup(void *a, unsigned b, void *c)\n\
                    { (void)a; (void)b; (void)c; return 1; }\n";
        let mut compilers = vec![Command::new("i686-w64-mingw32-gcc")];
        let zigs = [CrossCompiler::Zig, CrossCompiler::PythonZig];
        for zig in zigs.into_iter().filter_map(CrossCompiler::find) {
            let mut zig = zig.command();
            // The last target applies.
            zig.args(["-target", "x86-windows-gnu"]);
            compilers.push(zig);
        }
        (text, folder.join("small.dll"), compilers)
    };
    std::fs::write(&source, text).expect("a file");
    compilers.iter_mut().find_map(|compiler| {
        let output = compiler
            .args(["-shared", "-nostdlib"])
            .arg(&source)
            .arg("-o")
            .arg(&path)
            .output();
        output
            .ok()
            .filter(|o| o.status.success())
            .map(|_| path.clone())
    })
}

/// The names that a PE image exports.
pub fn exports(image: &[u8]) -> BTreeSet<String> {
    let coff = coff(image);
    let sections = u16_at(image, coff + 2);
    let optional = coff + 20;
    let first_section = optional + u16_at(image, coff + 16);
    // Converts an address in the loaded image to an offset in the file.
    let place = |address: usize| {
        (0..sections)
            .map(|s| first_section + 40 * s)
            .find_map(|s| {
                let (size, begin) = (u32_at(image, s + 8), u32_at(image, s + 12));
                (begin..begin + size)
                    .contains(&address)
                    .then(|| address - begin + u32_at(image, s + 20))
            })
            .expect("a section has the address")
    };
    let table = place(u32_at(image, optional + 112));
    let names = place(u32_at(image, table + 32));
    (0..u32_at(image, table + 24))
        .map(|n| {
            let at = place(u32_at(image, names + 4 * n));
            let length = image[at..].iter().position(|b| *b == 0).expect("an end");
            String::from_utf8_lossy(&image[at..at + length]).into_owned()
        })
        .collect()
}

/// The symbols that `nm` lists for a library, defined or undefined, without their versions.
pub fn symbols(library: &Path, which: &str) -> BTreeSet<String> {
    let output = Command::new("nm")
        .args(["-D", which, "--format=posix"])
        .arg(library)
        .output()
        .expect("nm comes with every C compiler");
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines()
        .filter_map(|line| line.split([' ', '@']).next())
        .map(str::to_owned)
        .collect()
}
