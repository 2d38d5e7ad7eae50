//! Bakes, on a thread of their own: the calling thread waits for signals, so that Ctrl-C ends the
//! call, and reports the progress. An interrupted decomposition ends soon; every other stage of a
//! bake runs to its end, and its result is dropped.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use hullmap_import::{MeshArrays, Polygons};
use hullmap_pipeline::{BakedPack, InMemoryError, Progress, Stage};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::{self, ArrayError, BakeError, BakeWarning};
use crate::pack::Pack;
use crate::threads::{self, Threads};

/// Interval at which a waiting thread checks for signals and reports the progress.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Positions, corners of all faces, and the end of each face, with a name.
type Mesh<'py> = (String, PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, u32>);

/// Bakes meshes in memory. `report` is called with the share that is done.
#[pyfunction]
pub fn bake_arrays(
    py: Python<'_>,
    name: String,
    meshes: Vec<Mesh<'_>>,
    options: Vec<(String, String)>,
    threads: Threads,
    report: Option<Bound<'_, PyAny>>,
) -> PyResult<Pack> {
    let meshes = meshes.iter().map(copy).collect::<PyResult<Vec<MeshArrays>>>()?;
    bake(py, threads, report, move |stage| {
        hullmap_pipeline::bake_arrays(&name, meshes, &borrowed(&options), stage).map(|(pack, _)| pack)
    })
}

/// Bakes a mesh file. `report` is called with the share that is done.
#[pyfunction]
pub fn bake_file(
    py: Python<'_>,
    path: PathBuf,
    options: Vec<(String, String)>,
    threads: Threads,
    report: Option<Bound<'_, PyAny>>,
) -> PyResult<Pack> {
    bake(py, threads, report, move |stage| hullmap_pipeline::bake_file(&path, &borrowed(&options), stage))
}

fn borrowed(options: &[(String, String)]) -> Vec<(&str, &str)> {
    options.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect()
}

/// Copies the arrays while the GIL is held.
fn copy((name, positions, corners, ends): &Mesh<'_>) -> PyResult<MeshArrays> {
    let wrong = |error: &dyn std::fmt::Display| ArrayError::new_err(format!("mesh {name}: {error}"));
    let numbers = positions.as_slice().map_err(|error| wrong(&error))?;
    let (positions, rest) = numbers.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(wrong(&"vertices must have three columns"));
    }
    let faces = Polygons {
        corners: corners.as_slice().map_err(|error| wrong(&error))?.to_vec(),
        ends: ends.as_slice().map_err(|error| wrong(&error))?.to_vec(),
    };
    Ok(MeshArrays { name: name.clone(), positions: positions.to_vec(), faces })
}

fn bake(
    py: Python<'_>,
    threads: Threads,
    report: Option<Bound<'_, PyAny>>,
    work: impl FnOnce(Stage<'_>) -> Result<BakedPack, InMemoryError> + Send + 'static,
) -> PyResult<Pack> {
    let pool = threads::pool(threads)?;
    let (sender, receiver) = sync_channel(1);
    let progress = Arc::new(Progress::default());
    let reached = Arc::clone(&progress);
    let run = move || {
        // Nobody listens after an interrupt.
        let _ = sender.send(pool.install(|| work(reached.whole())));
    };
    std::thread::Builder::new()
        .name("hullmap-bake".to_owned())
        .spawn(run)
        .map_err(|error| BakeError::new_err(format!("cannot start a thread: {error}; end other programs")))?;
    let (mut receiver, mut last) = (receiver, -1.0);
    let mut tell = |share: f64| match &report {
        Some(report) if share > last => {
            last = share;
            report.call1((share,)).map(drop)
        }
        _ => Ok(()),
    };
    let result = loop {
        let (waited, returned) = py.detach(move || (receiver.recv_timeout(SIGNAL_INTERVAL), receiver));
        receiver = returned;
        match waited {
            Ok(result) => break result,
            Err(RecvTimeoutError::Timeout) => {
                // The result would be dropped.
                let told = py.check_signals().and_then(|()| tell(progress.share()));
                told.inspect_err(|_| progress.cancel())?;
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(BakeError::new_err("internal error in the baker; please report it, with the mesh"));
            }
        }
    };
    let baked = result.map_err(|error| match &error {
        InMemoryError::Io { source, .. } => error::of_io(source, error.to_string()),
        _ => BakeError::new_err(in_python(&error.to_string())),
    })?;
    tell(1.0)?;
    let category = py.get_type::<BakeWarning>();
    for warning in &baked.warnings {
        let text = std::ffi::CString::new(in_python(warning).replace('\0', " "))?;
        PyErr::warn(py, &category, &text, 2)?;
    }
    Pack::baked(&baked.bytes, baked.notes.iter().map(|note| in_python(note)).collect())
}

/// A message of the command, with the options as keywords: `--max-vertices` becomes `max_vertices`.
pub fn in_python(message: &str) -> String {
    hullmap_pipeline::without_flags(message, str::to_owned)
}
