//! Text for the terminal, with control characters escaped. All text is printed here.
//!
//! Names of files, objects and hulls may hold any character: an escape sequence that rewrites the
//! screen, a line break that forges a row of a table, a mark that reverses the order of letters. So
//! text is printed line by line, by this module alone, and such characters are escaped. `--json`
//! has JSON's own escapes.
//!
//! A closed standard error is ignored; `eprintln!` would panic.

use std::cell::RefCell;
use std::fmt::{self, Display, Write as _};
use std::io::{self, BufWriter, IsTerminal, Write, stderr, stdout};
use std::sync::atomic::{AtomicBool, Ordering};

use anstream::ColorChoice;
use clap::builder::styling::{AnsiColor, Style};
use hullmap_pipeline::mesh_file::names::is_escaped;
use indicatif::ProgressDrawTarget;
use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter};

/// Each `f32` is the shortest decimal that reads back as the same, also through `f64`.
pub fn json(object: &impl Serialize) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    object.serialize(&mut serde_json::Serializer::with_formatter(&mut text, ExactFloats))?;
    Ok(text)
}

struct ExactFloats;

impl Formatter for ExactFloats {
    fn write_f32<W: ?Sized + Write>(&mut self, writer: &mut W, number: f32) -> io::Result<()> {
        let mut shortest = Vec::new();
        CompactFormatter.write_f32(&mut shortest, number)?;
        let read = std::str::from_utf8(&shortest).ok().and_then(|text| text.parse::<f64>().ok());
        // The shortest decimal of 7.038531e-26 lies in the middle between two `f32`.
        if read.is_some_and(|read| (read as f32).to_bits() == number.to_bits()) {
            writer.write_all(&shortest)
        } else {
            self.write_f64(writer, number.into())
        }
    }
}

/// Text in one line: characters that move the cursor, end a line or change the direction of writing
/// become `\u{1b}`. All other characters are left alone, also beyond ASCII.
#[derive(Clone, Copy, Debug)]
pub struct Escaped<T>(pub T);

impl<T: Display> Display for Escaped<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escaping(f), "{}", self.0)
    }
}

struct Escaping<'a, 'f>(&'a mut fmt::Formatter<'f>);

impl fmt::Write for Escaping<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut rest = text;
        while let Some((at, letter)) = rest.char_indices().find(|&(_, letter)| is_escaped(letter)) {
            self.0.write_str(&rest[..at])?;
            write!(self.0, "{}", letter.escape_unicode())?;
            rest = &rest[at + letter.len_utf8()..];
        }
        self.0.write_str(rest)
    }
}

/// Sets whether terminals get colours. Files and pipes get some only if `--color always`, or
/// `CLICOLOR_FORCE`, says so; `NO_COLOR` and `CLICOLOR=0` remove them.
pub fn paint(choice: &str) {
    let choices = [("always", ColorChoice::Always), ("never", ColorChoice::Never)];
    let choice = choices.into_iter().find(|(name, _)| *name == choice);
    choice.map_or(ColorChoice::Auto, |(_, choice)| choice).write_global();
}

static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// With `true`, only errors, JSON and whole files are printed: `--quiet`.
pub fn silence(is_quiet: bool) {
    IS_QUIET.store(is_quiet, Ordering::Relaxed);
}

pub fn is_quiet() -> bool {
    IS_QUIET.load(Ordering::Relaxed)
}

pub const BAD: Style = AnsiColor::Red.on_default().bold();
pub const DOUBTFUL: Style = AnsiColor::Yellow.on_default().bold();
pub const GOOD: Style = AnsiColor::Green.on_default();
const REMARK: Style = AnsiColor::Cyan.on_default().bold();

pub struct Output<'a> {
    writer: Box<dyn Write + 'a>,
    has_color: bool,
}

impl<'a> Output<'a> {
    pub fn new(writer: impl Write + 'a) -> Self {
        Self { writer: Box::new(writer), has_color: false }
    }

    pub fn standard() -> Output<'static> {
        // An old console of Windows gets none.
        let has_color = anstream::stdout().current_choice() == ColorChoice::AlwaysAnsi;
        Output { has_color, ..Output::new(BufWriter::new(stdout().lock())) }
    }

    /// The text in a style, if the output has colours.
    pub fn painted(&self, text: &str, style: Style) -> String {
        if self.has_color { format!("{style}{text}{style:#}") } else { text.to_owned() }
    }

    pub fn line(&mut self, line: impl Display) -> io::Result<()> {
        if is_quiet() {
            return Ok(());
        }
        writeln!(self.writer, "{}", Escaped(line))
    }

    pub fn json(&mut self, object: &impl Serialize) -> io::Result<()> {
        self.writer.write_all(&json(object)?)?;
        writeln!(self.writer)
    }

    /// Writes a whole file, or a text of the program itself without names from elsewhere, as is.
    pub fn verbatim(&mut self, text: &[u8]) -> io::Result<()> {
        self.writer.write_all(text)
    }

    pub fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

pub fn error(message: impl Display) {
    remark("error", BAD, &message);
}

pub fn note(message: impl Display) {
    let is_held = HELD.with_borrow_mut(|held| held.as_mut().map(|held| held.push(message.to_string())).is_some());
    if !is_held && !is_quiet() {
        remark("note", REMARK, &message);
    }
}

thread_local! {
    /// Notes that wait for the end of [`with_notes_of_changes`].
    static HELD: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Runs work, and prints its notes unless it returns that nothing has changed.
pub fn with_notes_of_changes<E>(work: impl FnOnce() -> Result<bool, E>) -> Result<bool, E> {
    HELD.set(Some(Vec::new()));
    let result = work();
    let notes = HELD.take().unwrap_or_default();
    notes.iter().filter(|_| !matches!(result, Ok(false))).for_each(note);
    result
}

pub fn warning(message: impl Display) {
    if !is_quiet() {
        remark("warning", DOUBTFUL, &message);
    }
}

fn remark(kind: &str, style: Style, message: &dyn Display) {
    let _ = writeln!(anstream::stderr(), "{style}{kind}:{style:#} {}", Escaped(message));
}

pub fn say(line: impl Display) {
    if !is_quiet() {
        let _ = writeln!(stderr(), "{}", Escaped(line));
    }
}

/// Whether output goes to a terminal, which binary data would disturb.
pub fn shows_output() -> bool {
    stdout().is_terminal()
}

/// Where progress bars are drawn, if standard error is a terminal. Their texts must be [`Escaped`].
pub fn screen() -> Option<ProgressDrawTarget> {
    stderr().is_terminal().then(ProgressDrawTarget::stderr)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        for (text, expected) in [
            ("plain", "plain"),
            ("größe 漢字 \u{1f980} C:\\x", "größe 漢字 \u{1f980} C:\\x"),
            ("\x1b[2Jx", "\\u{1b}[2Jx"),
            ("\x1b]0;title\x07", "\\u{1b}]0;title\\u{7}"),
            ("a\nb\r\tc\x7f", "a\\u{a}b\\u{d}\\u{9}c\\u{7f}"),
            ("\u{9b}31m\u{85}", "\\u{9b}31m\\u{85}"),
            ("gpj\u{202e}.obj\u{2066}", "gpj\\u{202e}.obj\\u{2066}"),
            ("\u{200e}\u{200f}\u{61c}\u{2028}\u{2029}", "\\u{200e}\\u{200f}\\u{61c}\\u{2028}\\u{2029}"),
        ] {
            assert_eq!(Escaped(text).to_string(), expected);
            let once = Escaped(text).to_string();
            assert_eq!(Escaped(&once).to_string(), once, "escaping twice changes nothing");
        }
        let all: String = ('\0'..=char::MAX).collect();
        let escaped = Escaped(&all).to_string();
        assert!(!escaped.chars().any(is_escaped));
        assert_eq!(all.chars().filter(|&letter| is_escaped(letter)).count(), 32 + 33 + 14);
    }

    #[test]
    fn only_the_end_of_a_line_ends_it() {
        let mut bytes = Vec::new();
        let mut out = Output::new(&mut bytes);
        out.line("a\nb").unwrap();
        out.json(&"c\n\u{9b}").unwrap();
        out.json(&[0.1, 7.038_531e-26_f32, 1.0]).unwrap();
        out.verbatim(b"d\n").unwrap();
        drop(out);
        assert_eq!(String::from_utf8(bytes).unwrap(), "a\\u{a}b\n\"c\\n\u{9b}\"\n[0.1,7.038530691851209e-26,1.0]\nd\n");
    }
}
