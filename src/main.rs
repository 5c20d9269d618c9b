//! The `linewright` program: arguments in, exit code out.

fn main() -> std::process::ExitCode {
    linewright::cli::main(std::env::args_os()).into()
}
