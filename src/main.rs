//! Parses the command line, calls the library and maps errors to exit codes.

fn main() -> std::process::ExitCode {
    lightbench::cli::main()
}
