//! The graphics device: what of Vulkan the backend needs, with errors as values.

use crate::backends::gpu::wgsl;
use crate::evaluate::EvaluateError;
use std::future::Future;
use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::Instant;
use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, Buffer, BufferBindingType, BufferDescriptor,
    BufferUsages, ComputePipeline, ComputePipelineDescriptor, DeviceDescriptor, ErrorFilter, Instance, InstanceDescriptor,
    PipelineLayout, PipelineLayoutDescriptor, PollType, PowerPreference, RequestAdapterOptions, ShaderModuleDescriptor,
    ShaderSource, ShaderStages,
};

/// What a buffer of a group of bindings is.
#[derive(Clone, Copy)]
enum BufferKind {
    Uniform,
    Read,
    Written,
}

/// The bindings of each group of a kernel.
const GROUPS: [&[BufferKind]; 3] = [
    &[BufferKind::Uniform, BufferKind::Read, BufferKind::Read, BufferKind::Read],
    &[BufferKind::Read; 9],
    &[BufferKind::Written, BufferKind::Uniform],
];

/// How many buffers of a kernel are no uniforms.
const STORAGE_BUFFERS: u32 = 13;

/// A device, and what all kernels on it share.
pub(super) struct GraphicsDevice {
    device: wgpu::Device,
    queue: wgpu::Queue,
    name: String,
    /// The most bytes of a buffer that a kernel reads.
    largest: u64,
    /// Whether the device was lost.
    is_lost: Arc<AtomicBool>,
    layouts: [BindGroupLayout; 3],
    pipeline_layout: PipelineLayout,
    keeps_subnormals: bool,
}

/// The device that is open, if one is.
static SHARED: Mutex<Option<Arc<GraphicsDevice>>> = Mutex::new(None);

impl GraphicsDevice {
    /// The device of the machine. It is opened at the first call, and again after it was lost.
    ///
    /// # Errors
    /// There is none, or it cannot do what kernels need. The text says what to do.
    pub(super) fn shared() -> Result<Arc<Self>, EvaluateError> {
        let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(device) = shared.as_ref().filter(|device| !device.is_lost.load(Ordering::Relaxed)) {
            return Ok(Arc::clone(device));
        }
        let device = Arc::new(Self::open().map_err(EvaluateError::Backend)?);
        *shared = Some(Arc::clone(&device));
        Ok(device)
    }

    fn open() -> Result<Self, String> {
        let without = "`--backend jit` needs no graphics device";
        let vulkan = InstanceDescriptor { backends: wgpu::Backends::VULKAN, ..InstanceDescriptor::new_without_display_handle() };
        let options = RequestAdapterOptions { power_preference: PowerPreference::HighPerformance, ..Default::default() };
        let adapter = ready(Instance::new(vulkan).request_adapter(&options)).map_err(|_| {
            format!(
                "there is no device for Vulkan; install the driver of the graphics card, or Mesa's software device \
                 (packages libvulkan1 and mesa-vulkan-drivers); {without}"
            )
        })?;
        let (info, limits) = (adapter.get_info(), adapter.limits());
        if limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
            let found = limits.max_storage_buffers_per_shader_stage;
            return Err(format!("{} reads {found} buffers at once, and {STORAGE_BUFFERS} are needed; {without}", info.name));
        }
        let largest = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let wanted = DeviceDescriptor { required_limits: limits, ..Default::default() };
        let opened = ready(adapter.request_device(&wanted));
        let (device, queue) = opened.map_err(|error| format!("{} cannot be used: {error}; {without}", info.name))?;
        let is_lost = Arc::new(AtomicBool::new(false));
        let lost = Arc::clone(&is_lost);
        device.set_device_lost_callback(move |_, _| lost.store(true, Ordering::Relaxed));
        // Without a handler of its own, an error ends the program. Errors are taken where they arise, see `guarded`.
        device.on_uncaptured_error(Arc::new(|_| ()));
        let layouts = GROUPS.map(|group| layout(&device, group));
        let groups = layouts.each_ref().map(Some);
        let pipeline_layout =
            device.create_pipeline_layout(&PipelineLayoutDescriptor { bind_group_layouts: &groups, ..Default::default() });
        let name = info.name;
        let mut own = Self { device, queue, name, largest, is_lost, layouts, pipeline_layout, keeps_subnormals: false };
        own.keeps_subnormals = own.probe().map_err(|error| error.to_string())?;
        Ok(own)
    }

    /// Its name.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The most bytes of a buffer that a kernel reads.
    pub(super) fn largest(&self) -> u64 {
        self.largest
    }

    /// Whether it computes with subnormal numbers.
    pub(super) fn keeps_subnormals(&self) -> bool {
        self.keeps_subnormals
    }

    /// The bindings of a group.
    pub(super) fn layout(&self, group: usize) -> &BindGroupLayout {
        &self.layouts[group]
    }

    pub(super) fn device(&self) -> &wgpu::Device {
        &self.device
    }

    pub(super) fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Does some work on this thread, and takes the first error that arises.
    ///
    /// # Errors
    /// What the device reports: mostly that its memory is full.
    pub(super) fn guarded<T>(&self, work: impl FnOnce() -> T) -> Result<T, EvaluateError> {
        let filters = [ErrorFilter::Internal, ErrorFilter::OutOfMemory, ErrorFilter::Validation];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let done = work();
        let [internal, memory, validation] = scopes;
        let found = [validation, memory, internal].map(|scope| ready(scope.pop()));
        match found.into_iter().flatten().next() {
            None => Ok(done),
            Some(error) => Err(self.error(&error.to_string())),
        }
    }

    /// An error of this device.
    pub(super) fn error(&self, what: &str) -> EvaluateError {
        let what = what.split_whitespace().collect::<Vec<_>>().join(" ");
        EvaluateError::Backend(format!("the graphics device {}: {what}; `--backend jit` does without it", self.name))
    }

    /// A buffer of these bytes. An empty one has room for a row of a table.
    pub(super) fn filled(&self, usage: BufferUsages, bytes: &[u8]) -> Buffer {
        let buffer = self.empty(usage | BufferUsages::COPY_DST, bytes.len() as u64);
        if !bytes.is_empty() {
            self.queue.write_buffer(&buffer, 0, bytes);
        }
        buffer
    }

    /// A buffer of this many bytes, all 0.
    pub(super) fn empty(&self, usage: BufferUsages, bytes: u64) -> Buffer {
        const LEAST: u64 = 16;
        let size = bytes.max(LEAST).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        self.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    }

    /// Compiles a kernel with the bindings of [`layout`](Self::layout).
    ///
    /// # Errors
    /// The text is not WGSL, or the driver fails.
    pub(super) fn kernel(&self, text: &str) -> Result<ComputePipeline, EvaluateError> {
        self.guarded(|| self.compiled(text, wgsl::ENTRY, Some(&self.pipeline_layout)))
    }

    fn compiled(&self, text: &str, entry: &str, layout: Option<&PipelineLayout>) -> ComputePipeline {
        let source = ShaderSource::Wgsl(text.into());
        let module = &self.device.create_shader_module(ShaderModuleDescriptor { label: None, source });
        self.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout,
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    /// The bytes of a buffer that can be mapped, once the device has done everything that it was given.
    ///
    /// # Errors
    /// The device was lost.
    pub(super) fn read<T>(&self, buffer: &Buffer, bytes: u64, take: impl FnOnce(&[u8]) -> T) -> Result<T, EvaluateError> {
        let slice = buffer.slice(0..bytes);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        self.device.poll(PollType::wait_indefinitely()).map_err(|error| self.error(&error.to_string()))?;
        let mapped = slice.get_mapped_range().map_err(|error| self.error(&error.to_string()))?;
        let taken = take(&mapped);
        drop(mapped);
        buffer.unmap();
        Ok(taken)
    }

    /// How many bytes it reads and writes in a second, when it copies within its memory.
    ///
    /// # Errors
    /// It fails, or has too little memory.
    pub(super) fn bandwidth(&self) -> Result<f64, EvaluateError> {
        const ROUNDS: u32 = 8;
        let bytes = self.largest.min(256 << 20);
        self.guarded(|| {
            let [from, to] = [(); 2].map(|()| self.empty(BufferUsages::COPY_SRC | BufferUsages::COPY_DST, bytes));
            let copy = || {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes);
                self.queue.submit([encoder.finish()]);
            };
            let wait = || {
                let waited = self.device.poll(PollType::wait_indefinitely());
                waited.map_err(|error| self.error(&error.to_string()))
            };
            // The first use of memory takes longer.
            copy();
            wait()?;
            let start = Instant::now();
            (0..ROUNDS).for_each(|_| copy());
            wait()?;
            Ok(2.0 * bytes as f64 * f64::from(ROUNDS) / start.elapsed().as_secs_f64())
        })?
    }

    /// Whether a product too small for a normal number is another than 0.
    fn probe(&self) -> Result<bool, EvaluateError> {
        const PROBE: &str = "@group(0) @binding(0) var<storage, read_write> numbers: array<f32>;
            @compute @workgroup_size(1) fn multiply() { numbers[2] = numbers[0] * numbers[1]; }";
        let numbers = [1e-30_f32, 1e-10, 0.0, 0.0];
        Ok(self.computed(PROBE, "multiply", &[], &numbers, 1)?[2] != 0.0)
    }

    /// Runs a small kernel once. Its bindings are buffers of these numbers, and last one that it changes, which is
    /// returned.
    pub(super) fn computed(
        &self,
        text: &str,
        entry: &str,
        inputs: &[(BufferUsages, &[u8])],
        changed: &[f32],
        workgroups: u32,
    ) -> Result<Vec<f32>, EvaluateError> {
        self.guarded(|| {
            let kernel = self.compiled(text, entry, None);
            let bytes: &[u8] = bytemuck::cast_slice(changed);
            let result = self.filled(BufferUsages::STORAGE | BufferUsages::COPY_SRC, bytes);
            let staging = self.empty(BufferUsages::MAP_READ | BufferUsages::COPY_DST, bytes.len() as u64);
            let inputs: Vec<Buffer> = inputs.iter().map(|(usage, bytes)| self.filled(*usage, bytes)).collect();
            let entries: Vec<wgpu::BindGroupEntry> = (0..)
                .zip(inputs.iter().chain([&result]))
                .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
                .collect();
            let layout = &kernel.get_bind_group_layout(0);
            let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
            let mut encoder = self.device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&kernel);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups(workgroups, 1, 1);
            }
            encoder.copy_buffer_to_buffer(&result, 0, &staging, 0, bytes.len() as u64);
            self.queue.submit([encoder.finish()]);
            self.read(&staging, bytes.len() as u64, bytemuck::pod_collect_to_vec::<u8, f32>)
        })?
    }
}

fn layout(device: &wgpu::Device, group: &[BufferKind]) -> BindGroupLayout {
    let entry = |(binding, held): (u32, &BufferKind)| BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::COMPUTE,
        ty: BindingType::Buffer {
            ty: match held {
                BufferKind::Uniform => BufferBindingType::Uniform,
                BufferKind::Read => BufferBindingType::Storage { read_only: true },
                BufferKind::Written => BufferBindingType::Storage { read_only: false },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<BindGroupLayoutEntry> = (0..).zip(group).map(entry).collect();
    device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: None, entries: &entries })
}

/// The result of work that the library does at once, though it has the form of a future.
fn ready<F: Future>(work: F) -> F::Output {
    let mut work = pin!(work);
    loop {
        match work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(done) => return done,
            Poll::Pending => std::thread::yield_now(),
        }
    }
}
