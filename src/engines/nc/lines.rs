//! The lines of an NC program in the manner of a post: numbered blocks, comments, and the longest line; and why there
//! are none.

use super::post::Post;
use feed::machine::BeyondTravel;

/// Reason why no program could be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NcError {
    /// The path moves an axis that the machine does not have.
    #[error("the path moves axis {axis} at row {row}, which the machine does not have; plan for the axes it has")]
    AxisNotOnMachine {
        /// Letter of the axis.
        axis: char,
        /// Row, from 0.
        row: usize,
    },
    /// The path moves an axis for which the post has no word.
    #[error("the path moves axis {axis}, for which the post has no word; add it under [[axes]]")]
    AxisNotInPost {
        /// Letter of the axis.
        axis: char,
    },
    /// A line is longer than the control allows.
    #[error(
        "a line of {length} characters is longer than the control's {limit}: {line:?}; \
             shorten the post's words or raise max_line_length"
    )]
    LineTooLong {
        /// Characters of the line.
        length: usize,
        /// Characters allowed.
        limit: usize,
        /// The line.
        line: String,
    },
    /// The feed of a block is rounded to 0.
    #[error(
        "the F word of block {block} would be 0 with its {decimals} decimals; raise the feed or the decimals of the \
         post"
    )]
    FeedTooSlow {
        /// Number of the block.
        block: usize,
        /// Decimals of the F word.
        decimals: usize,
    },
    /// The path leaves the travel of an axis.
    #[error("{0}; the program is for another machine than the path was verified for")]
    BeyondTravel(BeyondTravel),
    /// The machine has bodies, and its head does not come from the side that the electrode enters from.
    #[error(
        "the electrode enters from {from}, and the head of the machine comes along {along}; choose a machine whose head \
         comes from there, or one without bodies"
    )]
    HeadComesFromElsewhere {
        /// The side of entry.
        from: &'static str,
        /// Letter of the axis along which the head comes.
        along: char,
    },
    /// The machine has bodies, but the motion was not simulated with them.
    #[error("the machine has bodies, and the path was not simulated with them; simulate it")]
    NotSimulated,
    /// The motion was simulated for another machine.
    #[error("the motion was simulated for {simulated}, but the program is for {asked}; simulate it again")]
    OtherMachineSimulated {
        /// Machine of the simulation.
        simulated: String,
        /// Machine of the program.
        asked: String,
    },
    /// The post has no word for tool centre point control.
    #[error(
        "the post has no word for a control that follows the tool's tip ({wanted}); set tip_control to off, or take a \
             post that has {wanted} under [tip_control], as the built-in example milling-tcp has"
    )]
    NoTipControl {
        /// Key of the missing word.
        wanted: &'static str,
    },
    /// A setting is out of range.
    #[error("{name} is {value}, but must be {range}")]
    Setting {
        /// Name.
        name: &'static str,
        /// Value found.
        value: f64,
        /// Range of valid values.
        range: &'static str,
    },
}

/// Lines as they come.
pub(super) struct Lines<'a> {
    post: &'a Post,
    program: &'a str,
    dwell_s: f64,
    lines: Vec<String>,
    number: Option<u32>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(post: &'a Post, program: &'a str, dwell_s: f64) -> Self {
        Self { post, program, dwell_s, lines: Vec::new(), number: post.block_numbers.map(|n| n.first) }
    }

    /// One line as it is, with its placeholders filled.
    pub(super) fn raw(&mut self, line: &str) {
        let line = self.filled(line);
        self.lines.push(line);
    }

    /// One block, numbered; nothing for an empty one.
    pub(super) fn block(&mut self, words: &str) {
        let words = self.filled(words);
        if words.trim().is_empty() {
            return;
        }
        self.lines.push(match self.number {
            Some(n) => format!("N{n} {words}"),
            None => words,
        });
        if let (Some(n), Some(numbers)) = (self.number, self.post.block_numbers) {
            let next = n.checked_add(numbers.step).filter(|&next| next <= numbers.last);
            self.number = Some(next.unwrap_or(numbers.first));
        }
    }

    /// A comment, wrapped to the longest line. Whatever could end a comment or upset a control is replaced.
    pub(super) fn comment(&mut self, text: &str) {
        let safe: String = text.replace('%', "percent").chars().map(comment_character).collect();
        let style = &self.post.comment;
        let room = self.post.max_line_length.saturating_sub(style.open.len() + style.close.len()).max(1);
        let mut line = String::new();
        let mut lines = Vec::new();
        for word in safe.split_whitespace() {
            // Everything is ASCII here, so any byte is a place to cut.
            for piece in word.as_bytes().chunks(room).map(String::from_utf8_lossy) {
                if !line.is_empty() && line.len() + 1 + piece.len() > room {
                    lines.push(std::mem::take(&mut line));
                }
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(&piece);
            }
        }
        lines.push(line);
        self.lines.extend(lines.iter().map(|l| format!("{}{l}{}", style.open, style.close)));
    }

    fn filled(&self, line: &str) -> String {
        let name_character = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '-' { c } else { '_' };
        let program: String = self.program.chars().map(name_character).collect();
        line.replace("{program}", &program).replace("{seconds}", &number(self.dwell_s, 3))
    }

    pub(super) fn finish(self) -> Result<String, NcError> {
        let limit = self.post.max_line_length;
        if let Some(line) = self.lines.iter().find(|l| l.len() > limit) {
            let line = line.clone();
            return Err(NcError::LineTooLong { length: line.len(), limit, line });
        }
        let end = if self.post.crlf { "\r\n" } else { "\n" };
        Ok(self.lines.iter().flat_map(|l| [l.as_str(), end]).collect())
    }
}

/// A positive number with `decimals` decimals that is never rounded to zero.
fn number(value: f64, decimals: usize) -> String {
    let least = 10f64.powi(-(decimals as i32));
    format!("{:.decimals$}", value.max(least))
}

fn comment_character(c: char) -> char {
    match c {
        '(' => '[',
        ')' => ']',
        // Separators and expansions in one control or another.
        ';' => ',',
        '"' => '\'',
        '#' | '$' | '{' | '}' => '_',
        c if c == ' ' || c.is_ascii_graphic() => c,
        c if c.is_whitespace() => ' ',
        _ => '?',
    }
}
