//! Pictures of a formula by the device.

use crate::backends::compiled::leaves::StaticTextures;
use crate::backends::gpu::DeviceFormula;
use crate::backends::gpu::device::GraphicsDevice;
use crate::backends::gpu::numbers::{FrameHeader, FrameValues};
use crate::backends::gpu::pass::{DevicePass, Portion};
use crate::backends::gpu::textures::DeviceTextures;
use crate::backends::gpu::wgsl::WORKGROUP;
use crate::evaluate::{Drag, DragBeginning, Drawn, EvaluateError, Evaluator, Framebuffer, WholeFrames};
use crate::picture::Frame;
use crate::trace::{Hits, Mismatch, View};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use wgpu::{BindGroup, BindGroupDescriptor, BindGroupEntry, Buffer, BufferBinding, BufferUsages, CommandEncoder, PollType};

/// The bytes of a pixel on the device: three numbers.
pub(super) const PIXEL_BYTES: u64 = size_of::<[f32; 3]>() as u64;

/// A formula for a scene and a view, with one or more passes on the device. Its pictures are the mean of the passes.
pub struct DevicePicture {
    device: Arc<GraphicsDevice>,
    formula: Arc<DeviceFormula>,
    /// Those of each pass, at least one.
    hits: Vec<Arc<Hits>>,
    /// What the device has for the textures of the last picture.
    stored: Mutex<Arc<StoredPasses>>,
    /// The texels that kernels look up.
    textures: Mutex<Option<Arc<DeviceTextures>>>,
    /// Memory of frames, kept for the next one.
    free: Mutex<Vec<FrameMemory>>,
    /// What went wrong with the last picture.
    failed: Mutex<Option<String>>,
}

/// Passes whose static values were looked up in some textures.
struct StoredPasses {
    textures: StaticTextures,
    passes: Vec<Arc<DevicePass>>,
}

/// The memory of a frame on the device.
struct FrameMemory {
    header: Buffer,
    numbers: Buffer,
    picture: Buffer,
    staging: Buffer,
    /// Whether a pass is added to those before: no, and yes.
    adds: [Buffer; 2],
}

impl DevicePicture {
    /// Prepares one pass, with the textures among these parameter numbers.
    ///
    /// # Errors
    /// The tiles of `hits` are not those of their world and view, or the picture is too large for the device.
    pub(super) fn new(
        device: &Arc<GraphicsDevice>,
        formula: Arc<DeviceFormula>,
        hits: &Arc<Hits>,
        parameters: &[f32],
    ) -> Result<Self, EvaluateError> {
        let equation = formula.equation(&hits.world);
        let textures = StaticTextures::new(&formula.compiled.plan, &formula.formula, equation.layout, parameters);
        let passes = vec![Arc::new(formula.pass(device, &textures, hits)?)];
        let own = Self {
            device: Arc::clone(device),
            formula,
            hits: vec![Arc::clone(hits)],
            stored: Mutex::new(Arc::new(StoredPasses { textures, passes })),
            textures: Mutex::default(),
            free: Mutex::default(),
            failed: Mutex::default(),
        };
        // Whether it fits is known now. Without numbers for the first picture, its textures are not known.
        let memory = own.memory()?;
        if parameters.len() >= equation.layout.len() {
            own.device.guarded(|| own.textures_with(parameters).map(|_| ()))??;
        }
        own.free.lock().unwrap_or_else(PoisonError::into_inner).push(memory);
        Ok(own)
    }

    /// The same with one more pass. The passes so far are shared.
    ///
    /// # Errors
    /// The hits belong to another scene, their view differs in more than the pass, or the device has too little memory.
    pub fn with_one_more(&self, hits: &Arc<Hits>) -> Result<Self, EvaluateError> {
        let own = &self.hits[0];
        if !Arc::ptr_eq(&own.world, &hits.world) || own.view != hits.view.with_pass(own.view.pass()) {
            return Err(Mismatch.into());
        }
        let stored = self.stored();
        let pass = Arc::new(self.formula.pass(&self.device, &stored.textures, hits)?);
        let passes = stored.passes.iter().cloned().chain([pass]).collect();
        Ok(Self {
            device: Arc::clone(&self.device),
            formula: Arc::clone(&self.formula),
            hits: self.hits.iter().chain([hits]).cloned().collect(),
            stored: Mutex::new(Arc::new(StoredPasses { textures: stored.textures.clone(), passes })),
            textures: Mutex::new(self.textures.lock().unwrap_or_else(PoisonError::into_inner).clone()),
            free: Mutex::default(),
            failed: Mutex::default(),
        })
    }

    fn view(&self) -> View {
        self.hits[0].view
    }

    /// How many bytes the device copies in a second, within its memory: what a frame cannot exceed.
    ///
    /// # Errors
    /// The device fails.
    pub fn bandwidth(&self) -> Result<f64, EvaluateError> {
        self.device.bandwidth()
    }

    /// The name of the device.
    pub fn device_name(&self) -> &str {
        self.device.name()
    }

    /// The bytes that the device keeps for a frame, and those of the picture. A frame reads and writes each of them
    /// once; it leaves out rays whose weight is 0.
    pub fn frame_bytes(&self) -> u64 {
        let passes = &self.stored().passes;
        passes.iter().map(|pass| pass.device_bytes()).sum::<u64>() + u64::from(self.view().pixels()) * PIXEL_BYTES
    }

    fn stored(&self) -> Arc<StoredPasses> {
        Arc::clone(&self.stored.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The passes for the textures among these parameter numbers.
    fn passes_with(&self, parameters: &[f32]) -> Result<Arc<StoredPasses>, EvaluateError> {
        let last = self.stored();
        if last.textures.are_in(parameters) {
            return Ok(last);
        }
        let layout = self.formula.equation(&self.hits[0].world).layout;
        let textures = StaticTextures::new(&self.formula.compiled.plan, &self.formula.formula, layout, parameters);
        let passes = self.hits.iter().map(|hits| Ok(Arc::new(self.formula.pass(&self.device, &textures, hits)?)));
        let made = Arc::new(StoredPasses { passes: passes.collect::<Result<_, EvaluateError>>()?, textures });
        *self.stored.lock().unwrap_or_else(PoisonError::into_inner) = Arc::clone(&made);
        Ok(made)
    }

    /// The texels of the textures among these parameter numbers.
    fn textures_with(&self, parameters: &[f32]) -> Result<Arc<DeviceTextures>, EvaluateError> {
        let layout = self.formula.equation(&self.hits[0].world).layout;
        let numbers = DeviceTextures::numbers(parameters, &self.formula.texture_indices(&layout));
        let mut last = self.textures.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last.as_ref().filter(|known| known.holds(&numbers)) {
            return Ok(Arc::clone(known));
        }
        let made = DeviceTextures::new(&self.device, numbers).map(Arc::new);
        let made = made.ok_or_else(|| self.device.error("the textures do not fit into one buffer"))?;
        *last = Some(Arc::clone(&made));
        Ok(made)
    }

    /// Memory of a frame.
    fn memory(&self) -> Result<FrameMemory, EvaluateError> {
        if let Some(free) = self.free.lock().unwrap_or_else(PoisonError::into_inner).pop() {
            return Ok(free);
        }
        let size = u64::from(self.view().pixels()) * PIXEL_BYTES;
        let device = &self.device;
        device.guarded(|| FrameMemory {
            header: device.empty(BufferUsages::UNIFORM | BufferUsages::COPY_DST, size_of::<FrameHeader>() as u64),
            numbers: device.empty(BufferUsages::STORAGE | BufferUsages::COPY_DST, 0),
            picture: device.empty(BufferUsages::STORAGE | BufferUsages::COPY_SRC, size),
            staging: device.empty(BufferUsages::MAP_READ | BufferUsages::COPY_DST, size),
            adds: [0_u32, 1].map(|adds| device.filled(BufferUsages::UNIFORM, bytemuck::cast_slice(&[adds, 0, 0, 0]))),
        })
    }

    /// Adds up some passes and does what follows with the picture on the device. `None` once it is cancelled.
    fn evaluated<T>(
        &self,
        passes: Range<usize>,
        parameters: &[f32],
        cancelled: &AtomicBool,
        then: impl FnOnce(&FrameMemory) -> Result<T, EvaluateError>,
    ) -> Result<Option<T>, EvaluateError> {
        let equation = self.formula.equation(&self.hits[0].world);
        let values = FrameValues::new(&self.formula.compiled, &equation, &self.formula.leaves, parameters);
        let stored = self.passes_with(parameters)?;
        let mut memory = self.memory()?;
        let done = self.device.guarded(|| {
            let textures = self.textures_with(parameters)?;
            let numbers = self.frame_group(&mut memory, &values, &textures);
            let mut before = None;
            for index in passes.clone() {
                if cancelled.load(Ordering::Relaxed) {
                    return Ok(None);
                }
                let mut encoder = self.device.device().create_command_encoder(&Default::default());
                self.encode(&mut encoder, &stored.passes[index], &values, (&memory, &numbers), index > passes.start);
                let submitted = self.device.queue().submit([encoder.finish()]);
                // The next pass is encoded while the device computes this one, and no more wait for it.
                if let Some(submission_index) = before.replace(submitted) {
                    let wait = PollType::Wait { submission_index: Some(submission_index), timeout: None };
                    self.device.device().poll(wait).map_err(|error| self.device.error(&error.to_string()))?;
                }
            }
            then(&memory).map(Some)
        })??;
        self.free.lock().unwrap_or_else(PoisonError::into_inner).push(memory);
        Ok(done)
    }

    /// How long the device takes for a frame of these parameter numbers, from giving it the numbers until the picture
    /// is there, which is not read back.
    ///
    /// # Errors
    /// The device fails.
    pub fn time_on_device(&self, parameters: &[f32]) -> Result<Duration, EvaluateError> {
        let start = Instant::now();
        self.evaluated(0..self.hits.len(), parameters, &AtomicBool::new(false), |_| {
            let waited = self.device.device().poll(PollType::wait_indefinitely());
            waited.map(|_| ()).map_err(|error| self.device.error(&error.to_string()))
        })?;
        Ok(start.elapsed())
    }

    /// Gives the device the numbers of a frame.
    fn frame_group(&self, memory: &mut FrameMemory, values: &FrameValues, textures: &DeviceTextures) -> BindGroup {
        let queue = self.device.queue();
        let numbers: &[u8] = bytemuck::cast_slice(&values.numbers);
        if memory.numbers.size() < numbers.len() as u64 {
            memory.numbers = self.device.empty(memory.numbers.usage(), numbers.len() as u64);
        }
        queue.write_buffer(&memory.numbers, 0, numbers);
        queue.write_buffer(&memory.header, 0, bytemuck::bytes_of(&values.header));
        let buffers = [&memory.header, &memory.numbers, &textures.texels, &textures.table];
        self.group(0, &buffers.map(|buffer| buffer.as_entire_buffer_binding()))
    }

    fn group(&self, number: usize, buffers: &[BufferBinding]) -> BindGroup {
        let entries: Vec<BindGroupEntry> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| BindGroupEntry { binding, resource: wgpu::BindingResource::Buffer(buffer.clone()) })
            .collect();
        let layout = self.device.layout(number);
        self.device.device().create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// Encodes the calls of the kernel for a pass.
    fn encode(
        &self,
        encoder: &mut CommandEncoder,
        pass: &DevicePass,
        values: &FrameValues,
        (memory, numbers): (&FrameMemory, &BindGroup),
        adds: bool,
    ) {
        let mut calls = encoder.begin_compute_pass(&Default::default());
        calls.set_pipeline(&self.formula.kernel);
        calls.set_bind_group(0, numbers, &[]);
        for portion in &pass.portions {
            calls.set_bind_group(1, &portion.live(&values.lives).group, &[]);
            calls.set_bind_group(2, &self.picture_group(portion, memory, adds), &[]);
            calls.dispatch_workgroups((portion.pixels.len() as u32).div_ceil(WORKGROUP), 1, 1);
        }
    }

    /// The pixels of a portion.
    fn picture_group(&self, portion: &Portion, memory: &FrameMemory, adds: bool) -> BindGroup {
        // Tiles begin at multiples of 256 pixels, as bindings do.
        let pixels = BufferBinding {
            buffer: &memory.picture,
            offset: u64::from(portion.pixels.start) * PIXEL_BYTES,
            size: std::num::NonZero::new(portion.pixels.len() as u64 * PIXEL_BYTES),
        };
        self.group(2, &[pixels, memory.adds[usize::from(adds)].as_entire_buffer_binding()])
    }

    /// The picture on the device, once it is done.
    fn read(&self, memory: &FrameMemory) -> Result<Frame, EvaluateError> {
        let view = self.view();
        let bytes = u64::from(view.pixels()) * PIXEL_BYTES;
        let mut encoder = self.device.device().create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&memory.picture, 0, &memory.staging, 0, bytes);
        self.device.queue().submit([encoder.finish()]);
        let linear = self.device.read(&memory.staging, bytes, bytemuck::pod_collect_to_vec::<u8, [f32; 3]>)?;
        Ok(Frame { width: view.width(), height: view.height(), linear })
    }

    /// What is shown if the device fails: a picture of NaN.
    fn undefined(&self) -> Frame {
        let view = self.view();
        let linear = vec![[f32::NAN; 3]; view.pixels() as usize];
        Frame { width: view.width(), height: view.height(), linear }
    }
}

impl Evaluator for DevicePicture {
    fn passes(&self) -> usize {
        self.hits.len()
    }

    fn with_pass(&self, hits: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        Ok(Arc::new(self.with_one_more(hits)?))
    }

    /// If the device fails, all colours are NaN, and [`failure`](Evaluator::failure) tells why.
    fn sum(&self, passes: Range<usize>, parameters: &[f32], cancelled: &AtomicBool) -> Option<Frame> {
        let layout = self.formula.equation(&self.hits[0].world).layout;
        assert!(parameters.len() >= layout.len(), "as many parameter numbers as the formula and the scene have");
        let frame = self.evaluated(passes, parameters, cancelled, |memory| self.read(memory));
        let (frame, failed) = match frame {
            Ok(frame) => (frame, None),
            Err(error) => (Some(self.undefined()), Some(error.to_string())),
        };
        *self.failed.lock().unwrap_or_else(PoisonError::into_inner) = failed;
        frame
    }

    fn failure(&self) -> Option<String> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn {
        let mut undefined = None;
        let drawn = Drawn::timed(|| {
            let mut frame = self.frame(parameters);
            framebuffer.set(&frame);
            undefined = Some(frame.clean());
        });
        Drawn { undefined, ..drawn }
    }

    fn drag(
        self: Arc<Self>,
        _: &[usize],
        parameters: &[f32],
        _: usize,
        beginning: Option<&DragBeginning>,
    ) -> Result<Box<dyn Drag>, EvaluateError> {
        let pixels = self.view().pixels() as usize;
        Ok(Box::new(WholeFrames::new(self, pixels, parameters, beginning)))
    }

    fn bytes(&self) -> usize {
        let frames = self.free.lock().unwrap_or_else(PoisonError::into_inner).len() as u64;
        let passes = &self.stored().passes;
        let stored: u64 = passes.iter().map(|pass| pass.device_bytes() + pass.hits.bytes()).sum();
        (stored + frames * 2 * u64::from(self.view().pixels()) * PIXEL_BYTES) as usize
    }
}
