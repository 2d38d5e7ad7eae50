//! Box3D's narrow phase on a triangle mesh, in a program of its own, `benches/peers/box3d.c`.

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

use crate::peer_program::{PeerProgram, compile};

/// Box3D, compiled.
#[derive(Debug)]
pub struct Box3d {
    folder: TempDir,
    program: PathBuf,
}

/// What a program measures.
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
    /// Microseconds a body, of new contacts and of kept ones.
    pub us: [f64; 2],
    /// Mean number of contact points of a body.
    pub points: f64,
}

impl Box3d {
    /// Compiles Box3D, whose source is in a folder, with `cc`. Fails if the folder has no such
    /// source, or if the compiler fails.
    pub fn compile(source: &Path) -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|e| format!("temporary folder: {e}"))?;
        let program = folder.path().join("box3d");
        let own = source.join("src");
        let entries = fs::read_dir(&own).map_err(|e| format!("{}: {e}", own.display()))?;
        let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        files.retain(|path| path.extension() == Some(OsStr::new("c")));
        files.sort();
        let mut cc = Command::new("cc");
        cc.args(["-O2", "-DNDEBUG", "-std=gnu17", "-o"])
            .arg(&program)
            .arg(format!("-I{}", source.join("include").display()))
            .arg(format!("-I{}", own.display()))
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("peers/box3d.c"))
            .args(files)
            .args(["-lm", "-lpthread"]);
        compile(&mut cc)?;
        Ok(Self { folder, program })
    }

    /// Starts the program. Fails with any error of the file system, or if Box3D does not take the
    /// hull: it has limits of 128 vertices, faces and half-edges.
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
            [new, kept, points] => Ok(Times { us: [1e-3 * new, 1e-3 * kept], points }),
            _ => Err(io::Error::other(format!("Box3D's program: {line:?} is not three numbers"))),
        }
    }
}
