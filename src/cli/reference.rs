//! `sparkpath completions` and `sparkpath man`: the command line as shells and `man` know it, made from its definition.

use std::path::Path;

use anyhow::Context as _;
use clap::CommandFactory as _;
use clap_complete::Shell;
use clap_mangen::Man;

use super::{Answer, Arguments};

/// Exit codes, as the last section of every man page (roff).
const EXIT_STATUS: &str = r#".SH "EXIT STATUS"
.TP
0
Done, and every check holds.
.TP
1
Internal error.
.TP
2
Bad usage, bad input or an unreadable file: one line on standard error.
.TP
3
The answer is no: no path exists, or a check failed. Results are written all the same.
.TP
130
Cancelled.
"#;

/// Prints the completion script for `shell`.
pub(super) fn completions(shell: Shell) -> Answer {
    say!("{}", script(shell).trim_end());
    Answer::Yes
}

/// Writes the man pages of the program and of each command into the folder `out`, made if it is not there.
pub(super) fn man(out: &Path) -> anyhow::Result<Answer> {
    std::fs::create_dir_all(out).with_context(|| format!("{}: the folder cannot be made", out.display()))?;
    for (name, page) in pages()? {
        files::write_bytes(&out.join(name), page.as_bytes())?;
    }
    Ok(Answer::Yes)
}

fn script(shell: Shell) -> String {
    let mut bytes = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "sparkpath", &mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// File name and text of each man page. No page has a date: the same program gives the same bytes.
fn pages() -> anyhow::Result<Vec<(String, String)>> {
    let mut program = Arguments::command().disable_help_subcommand(true);
    program.build();
    let all = std::iter::once(&program).chain(program.get_subcommands());
    let page = |command: &clap::Command| {
        let source = format!("sparkpath {}", env!("CARGO_PKG_VERSION"));
        let page = Man::new(command.clone()).source(source).manual("Sparkpath");
        let mut bytes = Vec::new();
        page.render(&mut bytes)?;
        Ok((page.get_filename(), String::from_utf8(bytes)? + EXIT_STATUS))
    };
    all.map(page).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum as _;

    /// Every command with its long options, those of the program under its own name.
    fn commands() -> Vec<(String, Vec<String>)> {
        let mut program = Arguments::command();
        program.build();
        let options = |command: &clap::Command| {
            let shown = command.get_arguments().filter(|argument| !argument.is_hide_set());
            shown.filter_map(|argument| Some(argument.get_long()?.to_owned())).collect()
        };
        let all = std::iter::once(&program).chain(program.get_subcommands().filter(|c| c.get_name() != "help"));
        all.map(|command| (command.get_name().to_owned(), options(command))).collect()
    }

    #[test]
    fn every_command_has_a_man_page_with_each_option() {
        let pages = pages().unwrap();
        let commands = commands();
        assert!(commands.len() > 20, "{commands:?}");
        assert_eq!(pages.len(), commands.len());
        for (command, options) in commands {
            let name = if command == "sparkpath" { command } else { format!("sparkpath-{command}") };
            let (_, page) =
                pages.iter().find(|(file, _)| *file == format!("{name}.1")).unwrap_or_else(|| panic!("{name}"));
            for option in options {
                let written = format!(r"\-\-{}", option.replace('-', r"\-"));
                assert!(page.contains(&written), "{name} {option}");
            }
            assert!(page.contains("EXIT STATUS"), "{name}");
        }
    }

    /// The date would stand between the two spaces behind the section.
    #[test]
    fn man_pages_have_no_date() {
        for (file, page) in pages().unwrap() {
            let name = file.strip_suffix(".1").unwrap();
            let title = format!(".TH {name} 1  \"sparkpath {}\" Sparkpath", env!("CARGO_PKG_VERSION"));
            assert!(page.lines().any(|line| line == title), "{title}: {page}");
        }
        assert_eq!(pages().unwrap(), pages().unwrap());
    }

    #[test]
    fn completions_of_every_shell_name_every_command_and_option() {
        for shell in Shell::value_variants() {
            let script = script(*shell);
            for (command, options) in commands() {
                assert!(script.contains(&command), "{shell} {command}");
                for option in options {
                    // Fish writes the option without its dashes.
                    let written = [format!("--{option}"), format!("-l {option}")];
                    assert!(written.iter().any(|word| script.contains(word)), "{shell} {command} {option}");
                }
            }
        }
    }
}
