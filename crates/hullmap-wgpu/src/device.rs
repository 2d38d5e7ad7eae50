//! A Vulkan device with the compiled kernels, and a pack in its memory.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytemuck::{Pod, Zeroable};
use hullmap::Pack;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::error::Error;
use crate::records::Tables;

/// Threads of a workgroup; `kernels.wgsl` has the same number.
const WORKGROUP: u32 = 64;

/// Pairs of one dispatch. Larger batches take several, so that no dispatch runs for long.
const CHUNK: usize = 1 << 17;

/// Time after which a dispatch counts as failed. The reads of a pair are bounded, so a dispatch
/// ends; this is for devices that do not answer.
const TIMEOUT: Duration = Duration::from_secs(120);

/// What the kernels read in a uniform buffer.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Parameters {
    pub(crate) count: u32,
    pub(crate) query: u32,
    pub(crate) max_steps: u32,
    pub(crate) tolerance: f32,
}

/// A Vulkan device with the compiled kernels. Clones share it.
#[derive(Clone, Debug)]
pub struct Device(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    solve_pairs: wgpu::ComputePipeline,
    find_vertices: wgpu::ComputePipeline,
    info: wgpu::AdapterInfo,
    /// The first error since the last dispatch.
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
    ///
    /// # Examples
    /// ```
    /// match hullmap_wgpu::Device::open() {
    ///     Ok(device) => println!("{}", device.description()),
    ///     Err(error) => println!("{error}"),
    /// }
    /// ```
    pub fn open() -> Result<Self, Error> {
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
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..wgpu::DeviceDescriptor::default() };
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
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("hullmap"),
            source: wgpu::ShaderSource::Wgsl(include_str!("kernels.wgsl").into()),
        });
        let pipeline = |entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let (solve_pairs, find_vertices) = (pipeline("solve_pairs"), pipeline("find_vertices"));
        let info = adapter.get_info();
        let opened = Self(Arc::new(Inner { device, queue, solve_pairs, find_vertices, info, failure }));
        opened.check()?;
        Ok(opened)
    }

    /// Name of the adapter, its driver and the largest binding, in one line.
    ///
    /// # Examples
    /// ```
    /// if let Ok(device) = hullmap_wgpu::Device::open() {
    ///     assert!(device.description().contains("bytes a binding"));
    /// }
    /// ```
    pub fn description(&self) -> String {
        let Inner { info, .. } = &*self.0;
        format!("{}, {} {}, {} bytes a binding", info.name, info.driver, info.driver_info, self.binding_limit())
    }

    /// Makes the device unusable, as if it had been unplugged. Batches on it return
    /// [`Error::Device`] from then on.
    ///
    /// # Examples
    /// ```
    /// if let Ok(device) = hullmap_wgpu::Device::open() {
    ///     device.destroy();
    /// }
    /// ```
    pub fn destroy(&self) {
        self.0.device.destroy();
        self.fail("the device was destroyed");
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
        // A buffer must not be empty.
        let contents = if contents.is_empty() { &[0; 4] } else { contents };
        let usage = wgpu::BufferUsages::STORAGE;
        Ok(self.0.device.create_buffer_init(&BufferInitDescriptor { label: Some(section), contents, usage }))
    }
}

/// A pack in the memory of a device: the sections `blocks` and `slots` as they are in the file, and
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
    ///
    /// # Examples
    /// ```
    /// use hullmap_wgpu::{Device, DevicePack};
    ///
    /// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
    /// if let Ok(device) = Device::open() {
    ///     DevicePack::upload(&device, &pack)?;
    /// }
    /// # Ok::<(), hullmap_wgpu::Error>(())
    /// ```
    pub fn upload(device: &Device, pack: &Pack) -> Result<Self, Error> {
        let tables = Tables::of(pack)?;
        let uploaded = Self {
            device: device.clone(),
            hulls: device.upload("hulls", bytemuck::cast_slice(&tables.hulls))?,
            blocks: device.upload("blocks", bytemuck::cast_slice(tables.blocks))?,
            slots: device.upload("slots", bytemuck::cast_slice(tables.slots))?,
        };
        device.check()?;
        Ok(uploaded)
    }
}

/// Which kernel runs.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kernel {
    SolvePairs,
    FindVertices,
}

/// Buffers of one kernel, which grow with the batches.
#[derive(Debug)]
pub(crate) struct Buffers {
    kernel: Kernel,
    parameters: wgpu::Buffer,
    input: wgpu::Buffer,
    output: wgpu::Buffer,
    staging: wgpu::Buffer,
    capacity: usize,
}

impl Buffers {
    /// Buffers for `count` records of type `I` in and of type `O` out.
    fn new<I, O>(pack: &DevicePack, kernel: Kernel, count: usize) -> Self {
        use wgpu::BufferUsages as Usage;
        let capacity = count.next_power_of_two().min(CHUNK);
        let buffer = |size: usize, usage| {
            let descriptor =
                wgpu::BufferDescriptor { label: None, size: size as u64, usage, mapped_at_creation: false };
            pack.device.0.device.create_buffer(&descriptor)
        };
        Self {
            kernel,
            parameters: buffer(size_of::<Parameters>(), Usage::UNIFORM | Usage::COPY_DST),
            input: buffer(capacity * size_of::<I>(), Usage::STORAGE | Usage::COPY_DST),
            output: buffer(capacity * size_of::<O>(), Usage::STORAGE | Usage::COPY_SRC),
            staging: buffer(capacity * size_of::<O>(), Usage::MAP_READ | Usage::COPY_DST),
            capacity,
        }
    }

    /// Runs the kernel of `slot` for all of `input`, in chunks, and appends its output to `out`.
    pub(crate) fn run<I: Pod, O: Pod>(
        slot: &mut Option<Self>,
        pack: &DevicePack,
        kernel: Kernel,
        parameters: Parameters,
        input: &[I],
        out: &mut Vec<O>,
    ) -> Result<(), Error> {
        let needed = input.len().min(CHUNK);
        if slot.as_ref().is_none_or(|buffers| buffers.capacity < needed) {
            *slot = Some(Self::new::<I, O>(pack, kernel, needed));
        }
        let Some(buffers) = slot else { return Ok(()) };
        input.chunks(CHUNK).try_for_each(|chunk| buffers.run_chunk(pack, parameters, chunk, out))
    }

    fn run_chunk<I: Pod, O: Pod>(
        &self,
        pack: &DevicePack,
        parameters: Parameters,
        input: &[I],
        out: &mut Vec<O>,
    ) -> Result<(), Error> {
        let Inner { device, queue, solve_pairs, find_vertices, .. } = &*pack.device.0;
        pack.device.check()?;
        let (pipeline, at) = match self.kernel {
            Kernel::SolvePairs => (solve_pairs, 4),
            Kernel::FindVertices => (find_vertices, 6),
        };
        let entry = |binding, buffer: &'_ wgpu::Buffer| (binding, buffer.clone());
        let bound = [
            entry(0, &self.parameters),
            entry(1, &pack.hulls),
            entry(2, &pack.blocks),
            entry(3, &pack.slots),
            entry(at, &self.input),
            entry(at + 1, &self.output),
        ];
        let entries = bound
            .each_ref()
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() });
        let layout = pipeline.get_bind_group_layout(0);
        let group =
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let count = input.len() as u32;
        queue.write_buffer(&self.parameters, 0, bytemuck::bytes_of(&Parameters { count, ..parameters }));
        queue.write_buffer(&self.input, 0, bytemuck::cast_slice(input));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(count.div_ceil(WORKGROUP), 1, 1);
        }
        let bytes = size_of_val(input) as u64 / size_of::<I>() as u64 * size_of::<O>() as u64;
        encoder.copy_buffer_to_buffer(&self.output, 0, &self.staging, 0, bytes);
        queue.submit([encoder.finish()]);
        let device_of_callback = pack.device.clone();
        self.staging.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
            if let Err(error) = result {
                device_of_callback.fail(&error.to_string());
            }
        });
        let waited = device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(TIMEOUT) });
        if let Err(error) = waited {
            pack.device.fail(&error.to_string());
        }
        pack.device.check()?;
        let view =
            self.staging.get_mapped_range(0..bytes).map_err(|error| Error::Device { reason: error.to_string() })?;
        out.extend(view.chunks_exact(size_of::<O>()).map(bytemuck::pod_read_unaligned::<O>));
        drop(view);
        self.staging.unmap();
        Ok(())
    }
}
