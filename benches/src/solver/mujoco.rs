//! MuJoCo's convex collision (GJK and EPA in f64), beside ours on the same hulls and poses.
//!
//! It runs in a program of its own, `benches/peers/mujoco.c`, which is compiled here. Its library
//! and headers come from the package `mujoco` of PyPI, so the workspace does not need MuJoCo.

use std::{
    fmt::Write as _,
    fs,
    io::{self, BufRead, BufReader, Lines, Write as _},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
};

use glam::DVec3;
use hullmap::Hull;
use hullmap_testkit::packs::tree_pack;
use tempfile::TempDir;

use super::pairs::Placed;
use crate::{known::Known, subject::first_hull};

/// Maximum number of steps of GJK, and of EPA. MuJoCo's default is 35, with which EPA does not end
/// on hulls of many vertices.
pub const ITERATIONS: usize = 200;

/// Where the package is, and its version.
const WHERE: &str = "import mujoco, os; print(os.path.dirname(mujoco.__file__)); print(mujoco.__version__)";

/// The compiled program.
#[derive(Debug)]
pub struct MuJoCo {
    folder: TempDir,
    program: PathBuf,
    /// Version of MuJoCo.
    pub version: String,
}

impl MuJoCo {
    /// Finds the package `mujoco` of `python`, and compiles the program with `cc`. Fails if Python,
    /// the package or the compiler is missing; the error names it.
    pub fn find(python: &Path) -> Result<Self, String> {
        let shown = python.display();
        let asked = Command::new(python).args(["-c", WHERE]).output().map_err(|e| format!("{shown}: {e}"))?;
        let text = String::from_utf8_lossy(&asked.stdout).into_owned();
        let mut lines = text.lines();
        let (Some(package), Some(version)) = (lines.next(), lines.next()) else {
            return Err(format!("{shown} has no package `mujoco` (pip install mujoco)"));
        };
        let package = Path::new(package);
        let library = library(package).map_err(|e| format!("{}: {e}", package.display()))?;
        let folder = tempfile::tempdir().map_err(|e| format!("temporary folder: {e}"))?;
        let program = folder.path().join("mujoco");
        let mut cc = Command::new("cc");
        cc.args(["-O2", "-o"])
            .arg(&program)
            .arg(format!("-I{}", package.join("include").display()))
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("peers/mujoco.c"))
            .arg(&library)
            .arg(format!("-Wl,-rpath,{}", package.display()));
        let compiled = cc.output().map_err(|e| format!("cc: {e}"))?;
        if !compiled.status.success() {
            return Err(format!("cc: {}", String::from_utf8_lossy(&compiled.stderr).trim()));
        }
        Ok(Self { folder, program, version: version.to_owned() })
    }

    /// The line about its answers to two known boxes. Fails if one is wrong.
    pub fn prove(&self) -> Result<String, String> {
        let known = Known::boxes();
        let packs = known.corners.map(|corners| tree_pack(&corners));
        let hulls = packs.each_ref().map(first_hull);
        known.prove(&format!("MuJoCo {}", self.version), |pose| {
            let placed = Placed::new(pose.b_in_a.translation(), pose.b_in_a.rotation());
            let session = self.start(hulls, &[&placed]).map_err(|error| error.to_string())?;
            Ok(session.contacts[0])
        })
    }

    /// Starts the program with two hulls, and poses of B in A's frame. Fails with any error of the
    /// file system, or if the program does not start.
    pub fn start(&self, hulls: [Hull<'_>; 2], poses: &[&Placed]) -> io::Result<Session> {
        let (mut assets, mut bodies) = (String::new(), String::new());
        for (name, hull) in ["a", "b"].into_iter().zip(hulls) {
            let vertices: Vec<String> = hull.vertices().map(|v| format!("{} {} {}", v.x, v.y, v.z)).collect();
            // Writing to a string does not fail.
            let _ = write!(assets, "<mesh name='{name}' inertia='convex' vertex='{}'/>", vertices.join(" "));
            let _ = write!(bodies, "<body><freejoint/><geom type='mesh' mesh='{name}'/></body>");
        }
        // One point of contact, as ours: `multiccd` would search for up to four.
        let model = format!(
            "<mujoco><option ccd_iterations='{ITERATIONS}'><flag multiccd='disable'/></option><asset>{assets}</asset>\
             <worldbody>{bodies}</worldbody></mujoco>"
        );
        let mut lines = format!("{}\n", poses.len());
        for placed in poses {
            let (p, q) = (placed.b_in_a.translation(), placed.b_in_a.rotation());
            let _ = writeln!(lines, "{} {} {} {} {} {} {}", p.x, p.y, p.z, q.w, q.x, q.y, q.z);
        }
        let [model_file, pose_file] = ["model.xml", "poses.txt"].map(|name| self.folder.path().join(name));
        fs::write(&model_file, model)?;
        fs::write(&pose_file, lines)?;
        let mut command = Command::new(&self.program);
        // MuJoCo writes its log into the current folder.
        command.arg(model_file).arg(pose_file).current_dir(self.folder.path());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let pipes = child.stdin.take().zip(child.stdout.take());
        let (requests, answers) = pipes.ok_or_else(|| io::Error::other("the program has no pipes"))?;
        let mut session = Session { child, requests, answers: BufReader::new(answers).lines(), contacts: Vec::new() };
        for _ in poses {
            let depth = session.number()?;
            let normal = DVec3::new(session.number()?, session.number()?, session.number()?);
            session.contacts.push((depth >= 0.0).then_some((depth, normal)));
        }
        Ok(session)
    }
}

/// The shared library in the package.
fn library(package: &Path) -> io::Result<PathBuf> {
    let is_library = |path: &PathBuf| {
        path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with("libmujoco."))
    };
    let mut paths = fs::read_dir(package)?.filter_map(|entry| Some(entry.ok()?.path()));
    paths.find(is_library).ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no libmujoco"))
}

/// A running program. It is ended when this is dropped.
#[derive(Debug)]
pub struct Session {
    child: Child,
    requests: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
    /// Depth and normal of each pose, from A to B; `None` without a contact.
    pub contacts: Vec<Option<(f64, DVec3)>>,
}

impl Session {
    /// Processor time in nanoseconds per query, over the poses `first`, `first + step`, … below
    /// `end`, which were answered once just before. Fails if the program has ended.
    pub fn time_ns(&mut self, first: usize, end: usize, step: usize) -> io::Result<f64> {
        writeln!(self.requests, "{first} {end} {step}")?;
        self.number()
    }

    fn number(&mut self) -> io::Result<f64> {
        let line = self.answers.next().ok_or_else(|| io::Error::other("MuJoCo's program has ended"))??;
        line.trim().parse().map_err(|_| io::Error::other(format!("MuJoCo's program: {line:?} is not a number")))
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // The program may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let error = MuJoCo::find(Path::new("no-such-python")).unwrap_err();
        assert!(error.contains("no-such-python"), "{error}");
        // A program that succeeds and prints nothing.
        let error = MuJoCo::find(Path::new("true")).unwrap_err();
        assert!(error.contains("pip install mujoco"), "{error}");
    }

    #[test]
    fn programs_without_right_answers_are_refused() {
        // `echo` prints the names of the files, unless the request finds that it has ended.
        for program in ["echo", "true", "no-such-program"] {
            let folder = tempfile::tempdir().expect("a folder");
            let refusal = MuJoCo { folder, program: program.into(), version: "0".into() }.prove().unwrap_err();
            assert!(refusal.starts_with("MuJoCo 0: two known boxes: "), "{refusal}");
        }
    }
}
