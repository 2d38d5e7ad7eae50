//! The machine, compiler and commit of a result.

use std::{
    fs,
    path::Path,
    process::Command,
    time::{SystemTime, UNIX_EPOCH},
};

/// Stands for facts that could not be determined.
const UNKNOWN: &str = "unknown";

/// Place and time of a measurement.
#[derive(Clone, Debug)]
pub struct Machine {
    /// Day of the measurement, UTC, as 2026-11-21.
    pub date: String,
    /// Model name of the processor.
    pub processor: String,
    /// Processors this process may use.
    pub cores: usize,
    /// Output of `rustc --version`.
    pub rustc: String,
    /// Short hash of the commit, with `-dirty` if files differ from it.
    pub commit: String,
}

impl Machine {
    /// This machine, now.
    pub fn here() -> Self {
        let cpuinfo = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": ")).map(|(_, m)| m);
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        Self {
            date: date(seconds / 86_400),
            processor: model.unwrap_or(UNKNOWN).to_owned(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            rustc: output_of("rustc", &["--version"]),
            commit: output_of("git", &["describe", "--always", "--dirty", "--exclude=*"]),
        }
    }

    /// A markdown list, one line for each fact.
    pub fn to_markdown(&self) -> String {
        format!(
            "- date: {}\n- processor: {}, {} cores\n- compiler: {}\n- commit: {}\n",
            self.date, self.processor, self.cores, self.rustc, self.commit
        )
    }
}

fn output_of(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).current_dir(Path::new(env!("CARGO_MANIFEST_DIR"))).output();
    let output = output.ok().filter(|o| o.status.success());
    output.and_then(|o| String::from_utf8(o.stdout).ok()).map_or(UNKNOWN.to_owned(), |text| text.trim().to_owned())
}

/// Calendar date of a day counted from 1970-01-01.
fn date(mut day: u64) -> String {
    let leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let mut year = 1970;
    loop {
        let length = 365 + u64::from(leap(year));
        if day < length {
            break;
        }
        day -= length;
        year += 1;
    }
    let february = 28 + u64::from(leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    format!("{year:04}-{month:02}-{:02}", day + 1)
}

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn dates() {
        assert_eq!(date(0), "1970-01-01");
        assert_eq!(date(11_016), "2000-02-29");
        assert_eq!(date(11_017), "2000-03-01");
        assert_eq!(date(20_778), "2026-11-21");
        assert_eq!(date(20_818), "2026-12-31");
    }
}
