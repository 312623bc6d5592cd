//! The program: see [`sparkpath::cli`].

fn main() -> std::process::ExitCode {
    sparkpath::cli::run()
}
