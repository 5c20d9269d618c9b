//! The `linewright` program: arguments in, exit code out.

/// Decision diagrams and formulas are many small objects, which come and go on all threads.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    linewright::cli::main(std::env::args_os()).into()
}
