//! A Vulkan device with the compiled kernels, and a pack in its memory.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytemuck::{Pod, Zeroable};
use hullmap::Pack;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::error::Error;
use crate::records::{AnswerRecord, PairRecord, Query, Tables};

/// Threads of a workgroup; the kernels have the same number.
const WORKGROUP: u32 = 64;

/// Pairs of one dispatch. Larger batches take several, so that no dispatch runs for long.
const CHUNK: usize = 1 << 17;

/// For contacts, whose polytopes take about 200 MB then.
const CONTACT_CHUNK: usize = 1 << 15;

/// Bytes of a polytope of EPA: 64 corners and 124 faces.
const POLYTOPE_BYTES: u64 = (64 + 124) * 32;

/// Bytes of `State` in `gjk.wgsl`, which stays on the device from batch to batch.
const STATE_BYTES: usize = 32;

/// Bytes of `Progress` in `simplex.wgsl`.
const PROGRESS_BYTES: usize = 144;

/// Time after which a dispatch counts as failed. The reads of a pair are bounded, so a dispatch
/// ends; this is for devices that do not answer.
const TIMEOUT: Duration = Duration::from_secs(120);

/// Parameters of the kernels, in a uniform buffer.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Parameters {
    pub(crate) count: u32,
    pub(crate) query: u32,
    pub(crate) max_steps: u32,
    pub(crate) tolerance: f32,
    pub(crate) warm: u32,
    pub(crate) three: u32,
    pub(crate) padding: [u32; 2],
}

const THREE: u32 = 3;

/// Source of the kernels. Each is a module of its own, so that none makes another slow to compile.
mod source {
    /// Body of `mad` in `records.wgsl`.
    pub(super) const MAD: &str = "return a * b + c;";
    /// A fused multiply-add with nearly one rounding: lavapipe has no fused operation. Halves of 12
    /// bits make the rounding error of the product exact; it is added last.
    pub(super) const FUSED: &str = "
        let a_high = bitcast<f32>(bitcast<u32>(a) & 0xfffff000u);
        let b_high = bitcast<f32>(bitcast<u32>(b) & 0xfffff000u);
        let a_low = a - a_high;
        let b_low = b - b_high;
        let product = a * b;
        let error = ((a_high * b_high - product) + (a_high * b_low + a_low * b_high)) + a_low * b_low;
        return (product + c) + error;";
    pub(super) const SOLVE: &str = concat!(
        include_str!("kernels/records.wgsl"),
        include_str!("kernels/support.wgsl"),
        include_str!("kernels/simplex.wgsl"),
        include_str!("kernels/gjk.wgsl"),
    );
    pub(super) const EXPAND: &str = concat!(
        include_str!("kernels/records.wgsl"),
        include_str!("kernels/support.wgsl"),
        include_str!("kernels/simplex.wgsl"),
        include_str!("kernels/epa.wgsl"),
    );
    pub(super) const VERTICES: &str = concat!(
        include_str!("kernels/records.wgsl"),
        include_str!("kernels/support.wgsl"),
        include_str!("kernels/vertices.wgsl"),
    );
}

/// A Vulkan device with the compiled kernels. Clones share it.
#[derive(Clone, Debug)]
pub struct Device(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    solve_pairs: wgpu::ComputePipeline,
    expand_pairs: wgpu::ComputePipeline,
    find_vertices: wgpu::ComputePipeline,
    info: wgpu::AdapterInfo,
    failure: Arc<Mutex<Option<String>>>,
}

impl Device {
    /// Opens the Vulkan device with the highest performance, and compiles the kernels.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if there is none, [`Error::Device`] if it does not compile the kernels.
    ///
    /// # Complexity
    /// A few hundred milliseconds: keep the device.
    pub fn open() -> Result<Self, Error> {
        Self::open_with(source::MAD)
    }

    /// As [`open`](Self::open), with kernels whose products keep their rounding error until the sum
    /// that follows, as fused operations of other devices do. For tests.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    #[doc(hidden)]
    pub fn open_fused() -> Result<Self, Error> {
        Self::open_with(source::FUSED)
    }

    fn open_with(mad: &str) -> Result<Self, Error> {
        let none = |reason: &dyn std::fmt::Display| Error::NoDevice { reason: reason.to_string() };
        if !wgpu::Instance::enabled_backend_features().contains(wgpu::Backends::VULKAN) {
            return Err(none(&"this platform has no Vulkan"));
        }
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN;
        let instance = wgpu::Instance::new(descriptor);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(|error| none(&error))?;
        let possible = adapter.limits();
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: possible.max_storage_buffer_binding_size,
            max_buffer_size: possible.max_buffer_size,
            ..wgpu::Limits::default()
        };
        // Only to measure the kernels.
        let required_features = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
        let descriptor =
            wgpu::DeviceDescriptor { required_limits, required_features, ..wgpu::DeviceDescriptor::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| none(&error))?;
        let failure = Arc::new(Mutex::new(None));
        // Without a handler, wgpu panics on errors. The lock is held for one assignment only.
        let record = |failure: &Arc<Mutex<Option<String>>>| {
            let failure = Arc::clone(failure);
            move |reason: String| {
                failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(reason);
            }
        };
        let on_error = record(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| on_error(error.to_string())));
        let on_loss = record(&failure);
        device.set_device_lost_callback(move |_, reason| on_loss(reason));
        let pipeline = |source: &'static str, entry_point| {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(entry_point),
                source: wgpu::ShaderSource::Wgsl(source.replacen(source::MAD, mad, 1).into()),
            });
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module: &module,
                entry_point: Some(entry_point),
                // Whatever is read in the memory of a workgroup was written before.
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            })
        };
        let inner = Inner {
            solve_pairs: pipeline(source::SOLVE, "solve_pairs"),
            expand_pairs: pipeline(source::EXPAND, "expand_pairs"),
            find_vertices: pipeline(source::VERTICES, "find_vertices"),
            info: adapter.get_info(),
            device,
            queue,
            failure,
        };
        let opened = Self(Arc::new(inner));
        opened.check()?;
        Ok(opened)
    }

    /// Name of the adapter, its driver and the largest binding, in one line.
    pub fn description(&self) -> String {
        let Inner { info, .. } = &*self.0;
        format!("{}, {} {}, {} bytes a binding", info.name, info.driver, info.driver_info, self.binding_limit())
    }

    /// Makes the device unusable, as if it had been unplugged. Batches on it return
    /// [`Error::Device`] from then on.
    pub fn destroy(&self) {
        self.0.device.destroy();
        self.fail("the device was destroyed");
    }

    /// Whether an operation on the device failed. All later ones fail, too: open it again.
    ///
    /// # Examples
    /// ```
    /// if let Ok(device) = hullmap_wgpu::Device::open() {
    ///     assert!(!device.is_lost());
    ///     device.destroy();
    ///     assert!(device.is_lost());
    /// }
    /// ```
    pub fn is_lost(&self) -> bool {
        self.check().is_err()
    }

    fn binding_limit(&self) -> u64 {
        self.0.device.limits().max_storage_buffer_binding_size
    }

    fn fail(&self, reason: &str) {
        self.0.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| reason.to_owned());
    }

    /// The error that was recorded, if there is one. A device that failed once stays failed.
    fn check(&self) -> Result<(), Error> {
        match &*self.0.failure.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(reason) => Err(Error::Device { reason: reason.clone() }),
            None => Ok(()),
        }
    }

    fn upload(&self, section: &'static str, contents: &[u8]) -> Result<wgpu::Buffer, Error> {
        let limit = self.binding_limit().min(self.0.device.limits().max_buffer_size);
        if contents.len() as u64 > limit {
            return Err(Error::TooLarge { section, found: contents.len() as u64, limit });
        }
        // A buffer must not be shorter than an element.
        let contents = if contents.is_empty() { &[0; 128] } else { contents };
        let usage = wgpu::BufferUsages::STORAGE;
        Ok(self.0.device.create_buffer_init(&BufferInitDescriptor { label: Some(section), contents, usage }))
    }
}

/// Packs in the memory of a device: the sections `blocks` and `slots` as they are in the file, and
/// a record for each hull.
#[derive(Clone, Debug)]
pub struct DevicePack {
    device: Device,
    hulls: wgpu::Buffer,
    blocks: wgpu::Buffer,
    slots: wgpu::Buffer,
}

impl DevicePack {
    /// Copies what the kernels read of `pack` to `device`.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if a section is longer than a binding may be. [`Error::Pack`] on a
    /// big-endian processor. [`Error::Device`] if the device failed.
    ///
    /// # Complexity
    /// One copy of both sections.
    pub fn upload(device: &Device, pack: &Pack) -> Result<Self, Error> {
        Self::upload_tables(device, &Tables::from_pack(pack)?)
    }

    pub(crate) fn upload_tables(device: &Device, tables: &Tables<'_>) -> Result<Self, Error> {
        let uploaded = Self {
            device: device.clone(),
            hulls: device.upload("hulls", bytemuck::cast_slice(&tables.hulls))?,
            blocks: device.upload("blocks", bytemuck::cast_slice(&tables.blocks))?,
            slots: device.upload("slots", bytemuck::cast_slice(&tables.slots))?,
        };
        device.check()?;
        Ok(uploaded)
    }
}

impl DevicePack {
    /// Pairs of one dispatch of `query`. A depth takes memory for a polytope.
    pub(crate) fn chunk(&self, query: Query) -> usize {
        let polytopes = (self.device.binding_limit() / POLYTOPE_BYTES) as usize;
        match query {
            Query::Contact => polytopes.clamp(WORKGROUP as usize, CONTACT_CHUNK) & !(WORKGROUP as usize - 1),
            _ => CHUNK,
        }
    }

    fn buffer(&self, size: usize, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let descriptor = wgpu::BufferDescriptor { label: None, size: size as u64, usage, mapped_at_creation: false };
        self.device.0.device.create_buffer(&descriptor)
    }

    fn group(&self, pipeline: &wgpu::ComputePipeline, bound: &[(u32, wgpu::BindingResource<'_>)]) -> wgpu::BindGroup {
        let entries: Vec<_> = bound
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.clone() })
            .collect();
        let layout = pipeline.get_bind_group_layout(0);
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
        self.device.0.device.create_bind_group(&descriptor)
    }

    fn sections(&self) -> [(u32, wgpu::BindingResource<'_>); 3] {
        [(1, self.hulls.as_entire_binding()), (2, self.blocks.as_entire_binding()), (3, self.slots.as_entire_binding())]
    }

    fn submit(&self, encoder: wgpu::CommandEncoder) {
        self.device.0.queue.submit([encoder.finish()]);
    }

    /// Waits for all that was submitted, and appends the first `count` records of `staging`.
    fn read<O: Pod>(&self, staging: &wgpu::Buffer, count: usize, out: &mut Vec<O>) -> Result<(), Error> {
        let bytes = (count * size_of::<O>()) as u64;
        let device_of_callback = self.device.clone();
        staging.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
            if let Err(error) = result {
                device_of_callback.fail(&error.to_string());
            }
        });
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(TIMEOUT) };
        if let Err(error) = self.device.0.device.poll(wait) {
            self.device.fail(&error.to_string());
        }
        self.device.check()?;
        let view = staging.get_mapped_range(0..bytes).map_err(|error| Error::Device { reason: error.to_string() })?;
        out.extend(view.chunks_exact(size_of::<O>()).map(bytemuck::pod_read_unaligned::<O>));
        drop(view);
        staging.unmap();
        Ok(())
    }
}

fn dispatch(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    group: &wgpu::BindGroup,
    groups: u32,
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, group, &[]);
    pass.dispatch_workgroups(groups, 1, 1);
}

#[derive(Debug)]
struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

impl Clock {
    const BYTES: usize = 2 * size_of::<u64>();

    fn new(pack: &DevicePack) -> Option<Self> {
        use wgpu::BufferUsages as Usage;
        let device = &pack.device.0.device;
        device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: pack.buffer(Self::BYTES, Usage::QUERY_RESOLVE | Usage::COPY_SRC),
            staging: pack.buffer(Self::BYTES, Usage::MAP_READ | Usage::COPY_DST),
        })
    }

    /// Records the time in a pass without a kernel: 0 before all others, 1 after them.
    fn stamp(&self, encoder: &mut wgpu::CommandEncoder, index: u32) {
        let (before, after) = if index == 0 { (None, Some(0)) } else { (Some(1), None) };
        let timestamp_writes = Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: before,
            end_of_pass_write_index: after,
        });
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
        if index == 1 {
            encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, Self::BYTES as u64);
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) query: Query,
    pub(crate) tolerance: f32,
    pub(crate) max_steps: u32,
    pub(crate) is_warm: bool,
}

/// Buffers of the pairs, which grow with the batches.
#[derive(Debug)]
pub(crate) struct PairBuffers {
    parameters: wgpu::Buffer,
    pairs: wgpu::Buffer,
    answers: wgpu::Buffer,
    progress: wgpu::Buffer,
    /// The number of pairs that EPA continues, and their indices.
    overlapping: wgpu::Buffer,
    staging: wgpu::Buffer,
    capacity: usize,
    /// Polytopes, and their number.
    cells: Option<(wgpu::Buffer, usize)>,
    clock: Option<Clock>,
    /// Time of the kernels of the last batch. Meaningless without a clock.
    seconds: f64,
}

#[derive(Debug)]
pub(crate) struct States {
    buffer: wgpu::Buffer,
    count: usize,
}

impl PairBuffers {
    fn new(pack: &DevicePack, capacity: usize) -> Self {
        use wgpu::BufferUsages as Usage;
        Self {
            parameters: pack.buffer(size_of::<Parameters>(), Usage::UNIFORM | Usage::COPY_DST),
            pairs: pack.buffer(capacity * size_of::<PairRecord>(), Usage::STORAGE | Usage::COPY_DST),
            answers: pack.buffer(capacity * size_of::<AnswerRecord>(), Usage::STORAGE | Usage::COPY_SRC),
            progress: pack.buffer(capacity * PROGRESS_BYTES, Usage::STORAGE),
            overlapping: pack.buffer((capacity + 1) * 4, Usage::STORAGE | Usage::COPY_DST),
            staging: pack.buffer(capacity * size_of::<AnswerRecord>(), Usage::MAP_READ | Usage::COPY_DST),
            capacity,
            cells: None,
            clock: Clock::new(pack),
            seconds: 0.0,
        }
    }

    /// Solves all `pairs`, in chunks, and appends their answers to `out`.
    pub(crate) fn run(
        kept: &mut Option<Self>,
        states: &mut Option<States>,
        pack: &DevicePack,
        plan: Plan,
        pairs: &[PairRecord],
        out: &mut Vec<AnswerRecord>,
    ) -> Result<(), Error> {
        use wgpu::BufferUsages as Usage;
        let chunk = pack.chunk(plan.query);
        let needed = pairs.len().clamp(1, chunk);
        if kept.as_ref().is_none_or(|buffers| buffers.capacity < needed) {
            *kept = Some(Self::new(pack, needed.next_power_of_two().max(WORKGROUP as usize)));
        }
        if states.as_ref().is_none_or(|states| states.count < pairs.len()) {
            let count = pairs.len().max(1);
            let (bytes, limit) = (count * STATE_BYTES, pack.device.0.device.limits().max_buffer_size);
            if bytes as u64 > limit {
                return Err(Error::TooLarge { section: "states", found: bytes as u64, limit });
            }
            *states = Some(States { buffer: pack.buffer(bytes, Usage::STORAGE), count });
        }
        let (Some(buffers), Some(states)) = (kept, states) else { return Ok(()) };
        if plan.query == Query::Contact && buffers.cells.as_ref().is_none_or(|(_, count)| *count < needed) {
            let count = needed.next_power_of_two().max(WORKGROUP as usize).min(chunk);
            buffers.cells = Some((pack.buffer(count * POLYTOPE_BYTES as usize, Usage::STORAGE), count));
        }
        buffers.seconds = 0.0;
        for (at, pairs) in pairs.chunks(chunk).enumerate() {
            let start = (at * chunk * STATE_BYTES) as u64;
            let size = std::num::NonZeroU64::new((pairs.len() * STATE_BYTES) as u64);
            let states =
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: &states.buffer, offset: start, size });
            buffers.run_chunk(pack, plan, pairs, states, out)?;
        }
        Ok(())
    }

    pub(crate) fn seconds(&self) -> Option<f64> {
        self.clock.as_ref().map(|_| self.seconds)
    }

    fn run_chunk(
        &mut self,
        pack: &DevicePack,
        plan: Plan,
        pairs: &[PairRecord],
        states: wgpu::BindingResource<'_>,
        out: &mut Vec<AnswerRecord>,
    ) -> Result<(), Error> {
        let Inner { device, queue, solve_pairs, expand_pairs, .. } = &*pack.device.0;
        pack.device.check()?;
        let count = pairs.len() as u32;
        queue.write_buffer(&self.pairs, 0, bytemuck::cast_slice(pairs));
        queue.write_buffer(&self.overlapping, 0, bytemuck::bytes_of(&0_u32));
        let parameters = Parameters {
            count,
            query: plan.query as u32,
            max_steps: plan.max_steps,
            tolerance: plan.tolerance,
            warm: u32::from(plan.is_warm),
            three: THREE,
            padding: [0; 2],
        };
        queue.write_buffer(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let Some(clock) = &self.clock {
            clock.stamp(&mut encoder, 0);
        }
        let groups = count.div_ceil(WORKGROUP);
        let group = pack.group(solve_pairs, &self.bound(pack, states));
        dispatch(&mut encoder, solve_pairs, &group, groups);
        if let (Query::Contact, Some((cells, _))) = (plan.query, &self.cells) {
            let group = pack.group(expand_pairs, &self.bound(pack, cells.as_entire_binding()));
            dispatch(&mut encoder, expand_pairs, &group, groups);
        }
        if let Some(clock) = &self.clock {
            clock.stamp(&mut encoder, 1);
        }
        encoder.copy_buffer_to_buffer(&self.answers, 0, &self.staging, 0, size_of_val(pairs) as u64);
        pack.submit(encoder);
        if let Some(clock) = &self.clock {
            let mut times: Vec<u64> = Vec::with_capacity(2);
            pack.read(&clock.staging, 2, &mut times)?;
            if let [start, end] = times[..] {
                self.seconds += end.saturating_sub(start) as f64 * f64::from(queue.get_timestamp_period()) * 1e-9;
            }
        }
        pack.read(&self.staging, pairs.len(), out)
    }

    /// Bindings of both kernels of pairs. The last one is the states, or the polytopes.
    fn bound<'b>(
        &'b self,
        pack: &'b DevicePack,
        last: wgpu::BindingResource<'b>,
    ) -> Vec<(u32, wgpu::BindingResource<'b>)> {
        let mut bound = pack.sections().to_vec();
        bound.push((0, self.parameters.as_entire_binding()));
        bound.push((4, self.pairs.as_entire_binding()));
        bound.push((5, self.answers.as_entire_binding()));
        bound.push((6, self.progress.as_entire_binding()));
        bound.push((7, self.overlapping.as_entire_binding()));
        bound.push((8, last));
        bound
    }
}

#[derive(Debug)]
pub(crate) struct DirectionBuffers {
    parameters: wgpu::Buffer,
    directions: wgpu::Buffer,
    vertices: wgpu::Buffer,
    staging: wgpu::Buffer,
    capacity: usize,
}

impl DirectionBuffers {
    fn new<I, O>(pack: &DevicePack, capacity: usize) -> Self {
        use wgpu::BufferUsages as Usage;
        Self {
            parameters: pack.buffer(size_of::<Parameters>(), Usage::UNIFORM | Usage::COPY_DST),
            directions: pack.buffer(capacity * size_of::<I>(), Usage::STORAGE | Usage::COPY_DST),
            vertices: pack.buffer(capacity * size_of::<O>(), Usage::STORAGE | Usage::COPY_SRC),
            staging: pack.buffer(capacity * size_of::<O>(), Usage::MAP_READ | Usage::COPY_DST),
            capacity,
        }
    }

    /// Finds the support vertices of all `directions`, in chunks, and appends them to `out`.
    pub(crate) fn run<I: Pod, O: Pod>(
        kept: &mut Option<Self>,
        pack: &DevicePack,
        directions: &[I],
        out: &mut Vec<O>,
    ) -> Result<(), Error> {
        let needed = directions.len().min(CHUNK);
        if kept.as_ref().is_none_or(|buffers| buffers.capacity < needed) {
            *kept = Some(Self::new::<I, O>(pack, needed.next_power_of_two()));
        }
        let Some(buffers) = kept else { return Ok(()) };
        let Inner { device, queue, find_vertices, .. } = &*pack.device.0;
        for chunk in directions.chunks(CHUNK) {
            pack.device.check()?;
            let count = chunk.len() as u32;
            let parameters = Parameters { count, three: THREE, ..Parameters::default() };
            queue.write_buffer(&buffers.parameters, 0, bytemuck::bytes_of(&parameters));
            queue.write_buffer(&buffers.directions, 0, bytemuck::cast_slice(chunk));
            let mut bound = pack.sections().to_vec();
            bound.push((0, buffers.parameters.as_entire_binding()));
            bound.push((4, buffers.directions.as_entire_binding()));
            bound.push((5, buffers.vertices.as_entire_binding()));
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let group = pack.group(find_vertices, &bound);
            dispatch(&mut encoder, find_vertices, &group, count.div_ceil(WORKGROUP));
            encoder.copy_buffer_to_buffer(
                &buffers.vertices,
                0,
                &buffers.staging,
                0,
                (chunk.len() * size_of::<O>()) as u64,
            );
            pack.submit(encoder);
            pack.read(&buffers.staging, chunk.len(), out)?;
        }
        Ok(())
    }
}
