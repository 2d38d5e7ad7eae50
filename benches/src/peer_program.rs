//! An engine in a C program of its own, which is compiled here, reads requests and prints answers.

use std::{
    io::{self, BufRead, BufReader, Lines, Write},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
};

/// Runs a compiler. Fails with what it printed.
pub fn compile(compiler: &mut Command) -> Result<(), String> {
    let name = compiler.get_program().display().to_string();
    let compiled = compiler.output().map_err(|e| format!("{name}: {e}"))?;
    if compiled.status.success() {
        Ok(())
    } else {
        Err(format!("{name}: {}", String::from_utf8_lossy(&compiled.stderr).trim()))
    }
}

/// A running program. It is ended when this is dropped.
#[derive(Debug)]
pub struct PeerProgram {
    child: Child,
    requests: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
}

impl PeerProgram {
    /// Starts a program. Fails if it cannot be started.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let pipes = child.stdin.take().zip(child.stdout.take());
        let (requests, answers) = pipes.ok_or_else(|| io::Error::other("the program has no pipes"))?;
        Ok(Self { child, requests, answers: BufReader::new(answers).lines() })
    }

    /// Sends a line. Fails if the program has ended.
    pub fn ask(&mut self, line: &str) -> io::Result<()> {
        writeln!(self.requests, "{line}")
    }

    /// The next line that it prints. Fails if it has ended.
    pub fn answer(&mut self) -> io::Result<String> {
        self.answers.next().ok_or_else(|| io::Error::other("the engine's program has ended"))?
    }
}

impl Drop for PeerProgram {
    fn drop(&mut self) {
        // The program may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
