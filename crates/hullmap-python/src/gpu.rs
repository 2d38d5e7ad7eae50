//! Queries on the GPU (`device="gpu"`), if the wheel was built with the feature `gpu`.
//!
//! The GPU proves what f32 can prove. The rows that it leaves open are solved by the processor.

use hullmap::{Contact, Distance, Intersection};
use pyo3::prelude::*;

use crate::error::ArrayError;

/// Whether `device` is the GPU. Fails if it is neither `cpu` nor `gpu`.
pub fn is_gpu(device: &str) -> PyResult<bool> {
    match device {
        "cpu" => Ok(false),
        "gpu" => Ok(true),
        _ => Err(ArrayError::new_err(format!("device: expected 'cpu' or 'gpu', found {device:?}"))),
    }
}

/// Converts answers of the GPU to the processor's. `None` where the processor solves the row.
pub trait FromGpu: Sized {
    /// Which query it answers.
    const QUERY: GpuQuery;

    fn from_gpu(answer: &Answer) -> Option<Self>;
}

#[cfg(feature = "gpu")]
pub use on_device::{Answer, GpuQuery, solve};

#[cfg(feature = "gpu")]
mod on_device {
    use std::collections::HashMap;
    use std::sync::{Arc, Mutex, PoisonError};

    use hullmap::{Pack, Settings, SharedGeometry};
    use hullmap_wgpu::{Batch, Device, IndexedPair};
    use pyo3::prelude::*;

    pub use hullmap_wgpu::{Answer, Query as GpuQuery};

    use crate::error::{Error, PoseError, ShapeError};
    use crate::task::Task;

    /// Rows between two checks for signals.
    const BLOCK: usize = 1 << 17;

    /// The device, opened on first use, and the process that opened it: a forked child cannot use
    /// its parent's device.
    static DEVICE: Mutex<Option<(u32, Device)>> = Mutex::new(None);

    fn of_gpu(error: hullmap_wgpu::Error) -> PyErr {
        Error::new_err(format!("device='gpu': {error}").replace("Backend::Cpu", "device='cpu'"))
    }

    fn device() -> PyResult<Device> {
        let mut opened = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
        let process = std::process::id();
        if let Some((owner, device)) = &*opened
            && *owner == process
            && !device.is_lost()
        {
            return Ok(device.clone());
        }
        let device = Device::open().map_err(of_gpu)?;
        // The parent's device must not be closed here.
        std::mem::forget(opened.replace((process, device.clone())));
        Ok(device)
    }

    /// Solves all rows. Fails if a shape is not a hull, a pose is rejected, or there is no device.
    pub fn solve(py: Python<'_>, task: &Task<'_>, query: GpuQuery, settings: &Settings) -> PyResult<Vec<Answer>> {
        let (packs, hulls) = packs(task.pairs.shapes())?;
        let device = device()?;
        py.detach(|| {
            let mut batch = Batch::of_packs(&device, &packs).map_err(of_gpu)?;
            let mut answers = Vec::with_capacity(task.count);
            let mut block = Vec::with_capacity(BLOCK.min(task.count));
            for start in (0..task.count).step_by(BLOCK) {
                block.clear();
                for row in start..task.count.min(start + BLOCK) {
                    let b_in_a = task.poses.get(row, task.pairs).map_err(PoseError::new_err)?;
                    let [a, b] = task.pairs.members(row).map(|shape| hulls.get(shape).copied().unwrap_or_default());
                    block.push(IndexedPair { a, b, b_in_a });
                }
                let found = match query {
                    GpuQuery::Intersects => batch.intersects(&block),
                    GpuQuery::Distance => batch.distance(&block, settings),
                    GpuQuery::Contact => batch.contact(&block, settings),
                };
                answers.extend_from_slice(found.map_err(of_gpu)?);
                Python::attach(|py| py.check_signals())?;
            }
            Ok(answers)
        })
    }

    /// The packs of all hulls, and the index of each hull in them.
    fn packs(shapes: &[SharedGeometry]) -> PyResult<(Vec<&Pack>, Vec<u32>)> {
        let (mut packs, mut hulls, mut count) = (Vec::new(), Vec::with_capacity(shapes.len()), 0);
        let mut starts = HashMap::new();
        for shape in shapes {
            let SharedGeometry::Hull(hull) = shape else {
                return Err(ShapeError::new_err("device='gpu' takes hulls: query other shapes with device='cpu'"));
            };
            let start = *starts.entry(Arc::as_ptr(hull.pack())).or_insert_with(|| {
                packs.push(&**hull.pack());
                let start = count;
                count += hull.pack().hull_count();
                start
            });
            let index = u32::try_from(start + hull.index());
            hulls.push(index.map_err(|_| ShapeError::new_err("the packs have too many hulls: query fewer at a time"))?);
        }
        Ok((packs, hulls))
    }
}

#[cfg(not(feature = "gpu"))]
pub use without::{Answer, GpuQuery, solve};

#[cfg(not(feature = "gpu"))]
mod without {
    use hullmap::Settings;
    use pyo3::prelude::*;

    use crate::error::Error;
    use crate::task::Task;

    /// There are no answers.
    pub enum Answer {}

    /// The queries that a GPU would answer.
    #[derive(Clone, Copy)]
    pub enum GpuQuery {
        Intersects,
        Distance,
        Contact,
    }

    /// Always fails.
    pub fn solve(_: Python<'_>, _: &Task<'_>, query: GpuQuery, _: &Settings) -> PyResult<Vec<Answer>> {
        let name = match query {
            GpuQuery::Intersects => "intersects",
            GpuQuery::Distance => "distance",
            GpuQuery::Contact => "contact",
        };
        Err(Error::new_err(format!(
            "{name}: device='gpu' requires a wheel with the feature gpu: build it with \
             `maturin build --release --features gpu`, or pass device='cpu'"
        )))
    }
}

/// Solves the rows on the GPU, if it is requested. `None` for rows that the processor solves.
/// Returns the errors of [`is_gpu`] and [`solve`].
pub fn known<T: FromGpu>(
    py: Python<'_>,
    device: &str,
    task: &crate::task::Task<'_>,
    settings: &hullmap::Settings,
) -> PyResult<impl Fn(usize) -> Option<T> + Sync + use<T>> {
    let answers = if is_gpu(device)? { solve(py, task, T::QUERY, settings)? } else { Vec::new() };
    Ok(move |row: usize| answers.get(row).and_then(T::from_gpu))
}

#[cfg(not(feature = "gpu"))]
mod conversions {
    use super::{Answer, Contact, Distance, FromGpu, GpuQuery, Intersection};

    macro_rules! none {
        ($($kind:ty => $query:expr),*) => {
            $(impl FromGpu for $kind {
                const QUERY: GpuQuery = $query;

                fn from_gpu(answer: &Answer) -> Option<Self> {
                    match *answer {}
                }
            })*
        };
    }

    none!(Intersection => GpuQuery::Intersects, Distance => GpuQuery::Distance, Contact => GpuQuery::Contact);
}

#[cfg(feature = "gpu")]
mod conversions {
    use hullmap::{Overlap, Status};
    use hullmap_wgpu::Status as Ended;

    use super::{Answer, Contact, Distance, FromGpu, GpuQuery, Intersection};

    impl FromGpu for Intersection {
        const QUERY: GpuQuery = GpuQuery::Intersects;

        fn from_gpu(answer: &Answer) -> Option<Self> {
            let status = match answer.status {
                Ended::Separated => Overlap::Separated,
                Ended::Overlapping => Overlap::Overlapping,
                _ => return None,
            };
            Some(Self { status, iterations: answer.steps, support_calls: answer.steps, ..Self::default() })
        }
    }

    impl FromGpu for Distance {
        const QUERY: GpuQuery = GpuQuery::Distance;

        fn from_gpu(answer: &Answer) -> Option<Self> {
            let status = match answer.status {
                Ended::Separated => Status::Within,
                Ended::Overlapping => Status::Overlapping,
                _ => return None,
            };
            Some(Self {
                status,
                distance: length(answer),
                lower: answer.lower,
                upper: answer.upper,
                normal: answer.normal,
                point_a: answer.point_a,
                point_b: answer.point_b,
                iterations: answer.steps,
                support_calls: answer.steps,
                ..Self::default()
            })
        }
    }

    impl FromGpu for Contact {
        const QUERY: GpuQuery = GpuQuery::Contact;

        fn from_gpu(answer: &Answer) -> Option<Self> {
            let (hit, status) = match answer.status {
                Ended::Separated => (false, Status::Separated),
                Ended::Overlapping => (true, Status::Within),
                _ => return None,
            };
            Some(Self {
                hit,
                status,
                depth: length(answer),
                depth_lower: answer.lower,
                depth_upper: answer.upper,
                normal: answer.normal,
                point_a: answer.point_a,
                point_b: answer.point_b,
                iterations: answer.steps,
                support_calls: answer.steps,
                ..Self::default()
            })
        }
    }

    /// The distance of the witness points, within the interval.
    fn length(answer: &Answer) -> f64 {
        answer.point_a.distance(answer.point_b).max(answer.lower).min(answer.upper)
    }
}
