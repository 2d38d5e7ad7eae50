//! Narrow phases of other engines on a triangle mesh, each in a program of its own: Box3D's,
//! `benches/peers/box3d.c`, and Jolt's, `benches/peers/jolt.cpp`.

use std::{
    ffi::OsStr,
    fmt::Write,
    fs, io,
    path::{Path, PathBuf},
    process::Command,
};

use glam::Vec3;
use hullmap::Pose;
use tempfile::TempDir;

use crate::{
    known::{Known, TRIANGLES},
    peer_program::{PeerProgram, compile},
};

/// An engine, compiled.
#[derive(Debug)]
pub struct MeshPeer {
    folder: TempDir,
    program: PathBuf,
    /// Its answers to two known boxes, in words.
    pub proof: String,
}

/// Bodies and rays that a program measures.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The ground's vertices.
    pub positions: &'a [[f32; 3]],
    /// The ground's triangles.
    pub triangles: &'a [[u32; 3]],
    /// Vertices of the body's hull.
    pub hull: &'a [Vec3],
    /// Poses of all bodies, and their poses a step later.
    pub poses: &'a [Vec<Pose>; 2],
}

/// Times of one round.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// Two times in microseconds a body. Box3D: of new contacts, and of kept ones. Jolt: of new
    /// contacts with its default settings, and with its enhanced removal of internal edges.
    pub us: [f64; 2],
    /// Mean number of contact points of a body.
    pub points: f64,
    /// Depth of the deepest contact; 0 without one.
    pub depth: f64,
}

impl MeshPeer {
    /// Compiles Box3D, whose source is in a folder, with `cc`. Fails if the folder has no such
    /// source, if the compiler fails, or if the engine answers two known boxes wrongly.
    pub fn box3d(source: &Path) -> Result<Self, String> {
        let own = source.join("src");
        let mut files = Vec::new();
        sources(&own, "c", &mut files)?;
        let flags = ["-O2", "-DNDEBUG", "-std=gnu17", "-lm", "-lpthread"];
        Self::compile("Box3D", "cc", "box3d.c", &[&source.join("include"), &own], &files, &flags)
    }

    /// Compiles Jolt, whose source is in a folder, with `c++`, for the vector instructions of this
    /// machine. Takes some minutes. Fails as [`box3d`](Self::box3d) does.
    pub fn jolt(source: &Path) -> Result<Self, String> {
        let mut files = Vec::new();
        sources(&source.join("Jolt"), "cpp", &mut files)?;
        let flags = ["-O3", "-DNDEBUG", "-std=c++17", "-march=native", "-ffp-contract=off", "-pthread"];
        Self::compile("Jolt", "c++", "jolt.cpp", &[source], &files, &flags)
    }

    fn compile(
        name: &str,
        compiler: &str,
        main: &str,
        includes: &[&Path],
        files: &[PathBuf],
        flags: &[&str],
    ) -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|e| format!("temporary folder: {e}"))?;
        let program = folder.path().join("peer");
        let mut command = Command::new(compiler);
        command.arg("-o").arg(&program);
        for include in includes {
            command.arg(format!("-I{}", include.display()));
        }
        // Libraries stand after the files that need them.
        command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("peers").join(main)).args(files).args(flags);
        compile(&mut command)?;
        let mut peer = Self { folder, program, proof: String::new() };
        peer.proof = peer.prove(name)?;
        Ok(peer)
    }

    /// The first box is the ground's triangles, the second one a body.
    fn prove(&self, name: &str) -> Result<String, String> {
        let known = Known::boxes();
        let [ground, body] = known.corners;
        known.prove(name, |pose| {
            let poses = [vec![pose.b_in_a], vec![pose.b_in_a]];
            let scene = Scene { positions: &ground, triangles: &TRIANGLES, hull: &body.map(Vec3::from), poses: &poses };
            let times = self.start(&scene).and_then(|mut session| session.round());
            let Times { points, depth, .. } = times.map_err(|error| error.to_string())?;
            Ok((points != 0.0).then_some((depth, None)))
        })
    }

    /// Starts the program. Fails with any error of the file system. The program ends if its engine
    /// does not support the hull: Box3D has limits of 128 vertices, faces and half-edges.
    pub fn start(&self, scene: &Scene) -> io::Result<Session> {
        let Scene { positions, triangles, hull, poses } = scene;
        let mut text = format!("{} {} {} {}\n", positions.len(), triangles.len(), hull.len(), poses[0].len());
        // Writing to a string does not fail.
        for [x, y, z] in *positions {
            let _ = writeln!(text, "{x} {y} {z}");
        }
        for [a, b, c] in *triangles {
            let _ = writeln!(text, "{a} {b} {c}");
        }
        for p in *hull {
            let _ = writeln!(text, "{} {} {}", p.x, p.y, p.z);
        }
        for pose in poses.iter().flatten() {
            let (p, q) = (pose.translation(), pose.rotation());
            let _ = writeln!(text, "{} {} {} {} {} {} {}", p.x, p.y, p.z, q.x, q.y, q.z, q.w);
        }
        let file = self.folder.path().join("scene.txt");
        fs::write(&file, text)?;
        Ok(Session { program: PeerProgram::start(Command::new(&self.program).arg(file))? })
    }
}

/// A running program.
#[derive(Debug)]
pub struct Session {
    program: PeerProgram,
}

impl Session {
    /// Measures one round. Fails if the program has ended.
    pub fn round(&mut self) -> io::Result<Times> {
        self.program.ask("")?;
        let line = self.program.answer()?;
        let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        match numbers[..] {
            [first, second, points, depth] => Ok(Times { us: [1e-3 * first, 1e-3 * second], points, depth }),
            _ => Err(io::Error::other(format!("the engine's program: {line:?} is not four numbers"))),
        }
    }
}

/// Source files in a folder and in those inside, in order.
fn sources(folder: &Path, extension: &str, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            sources(&path, extension, files)?;
        } else if path.extension() == Some(OsStr::new(extension)) {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn programs_without_right_answers_are_refused() {
        // `echo` prints the name of the scene's file, unless the request finds that it has ended.
        for program in ["echo", "true", "no-such-program"] {
            let folder = tempfile::tempdir().expect("a folder");
            let peer = MeshPeer { folder, program: program.into(), proof: String::new() };
            let refusal = peer.prove("engine").unwrap_err();
            assert!(refusal.starts_with("engine: two known boxes: "), "{refusal}");
        }
    }
}
