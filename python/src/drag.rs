//! Drags: a slider that is held.

use crate::arrays;
use crate::diagnostics::{engine_failure, failure};
use crate::session::{Session, Tracing, find, mean, numbers, on_threads};
use crate::work::{interruptible, lock};
use illuminator::engine::{EngineError, Task};
use illuminator::evaluate::{Drag as EngineDrag, DragBeginning, Evaluator, Framebuffer};
use illuminator::formula::ParameterId;
use illuminator::lang::types::Type;
use illuminator::picture::Frame;
use illuminator::workspace::OwnerId;
use numpy::PyArray3;
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

/// The memory that a drag may keep, in bytes, if there is no limit.
const MOST: usize = 1 << 30;

/// How many pixels a thread turns into bytes at a time.
const PIXELS_AT_ONCE: usize = 1 << 14;

/// A held slider, see [`Session::drag`]. It begins with the `with` block.
#[pyclass(module = "illuminator", frozen)]
pub(crate) struct Drag {
    session: Py<Session>,
    owner: OwnerId,
    id: ParameterId,
    name: String,
    held: Mutex<Option<Held>>,
}

/// What is prepared while the slider is held.
struct Held {
    drag: Box<dyn EngineDrag>,
    evaluator: Arc<dyn Evaluator>,
    framebuffer: Framebuffer,
    pool: Option<Arc<ThreadPool>>,
}

#[pymethods]
impl Drag {
    /// Prepares everything that pictures of this slider need.
    fn __enter__(slf: Bound<'_, Self>) -> PyResult<Bound<'_, Self>> {
        let py = slf.py();
        let this = slf.get();
        let session = this.session.get();
        let values = session.values_now();
        let (numbers, moved) = (values.numbers().to_vec(), values.moved_indices(this.owner, this.id));
        let hold = |task: &Task| this.hold(&mut lock(&session.tracing), &numbers, &moved, task);
        let held = interruptible(py, hold)?.map_err(engine_failure)?;
        let large = "the passes of the picture do not fit into the memory together, so there are no drags; take fewer `samples`";
        let held = held.ok_or_else(|| failure(large))?;
        py.detach(|| *lock(&this.held) = Some(held));
        Ok(slf)
    }

    /// The picture with the slider at this value, as [`Session.render`] gives it. The session keeps the value.
    fn __call__<'py>(&self, py: Python<'py>, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let value = self.numbers(value)?;
        let frame = interruptible(py, |task| self.linear(value, task))??;
        arrays::picture(py, frame)
    }

    /// The picture with the slider at this value as bytes, as [`Session.image`] gives it.
    fn image<'py>(&self, py: Python<'py>, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let value = self.numbers(value)?;
        let (bytes, size) = interruptible(py, |_| self.bytes(value))??;
        arrays::bytes(py, bytes, size)
    }

    /// How pictures are made: a word.
    #[getter]
    fn method(&self, py: Python<'_>) -> PyResult<&'static str> {
        py.detach(|| lock(&self.held).as_ref().map(|held| held.drag.method().name())).ok_or_else(not_held)
    }

    fn __exit__(&self, py: Python<'_>, _kind: &Bound<'_, PyAny>, _error: &Bound<'_, PyAny>, _trace: &Bound<'_, PyAny>) {
        py.detach(|| *lock(&self.held) = None);
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let held = if py.detach(|| lock(&self.held).is_some()) { "held" } else { "not held" };
        format!("<Drag of {}, {held}>", self.name)
    }
}

fn not_held() -> PyErr {
    failure("the slider is not held; write `with session.drag(…) as drag:` and call `drag` in it")
}

impl Drag {
    /// A drag of the value of this name. Nothing is prepared yet.
    pub(crate) fn new(session: Bound<'_, Session>, name: &str) -> PyResult<Self> {
        let values = session.get().values_now();
        let (owner, id) = find(values.table(), name)?;
        if let Some(reason) = values.lock_of(owner, id) {
            return Err(failure(format!("`{name}` cannot be moved: {reason}")));
        }
        if values.table().parameter(id).ty == Type::Texture {
            return Err(failure(format!("`{name}` is a texture, which no slider moves; use `set`")));
        }
        Ok(Self { session: session.unbind(), owner, id, name: name.to_owned(), held: Mutex::new(None) })
    }

    /// Prepares everything; `None` if the passes of the picture do not fit into the memory together.
    fn hold(&self, tracing: &mut Tracing, numbers: &[f32], moved: &[usize], task: &Task) -> Result<Option<Held>, EngineError> {
        let pool = tracing.pool();
        on_threads(pool.clone().as_deref(), || {
            let Some(evaluator) = tracing.evaluator(numbers, task)? else { return Ok(None) };
            let picture = mean(&*evaluator, numbers, task)?;
            let framebuffer = Framebuffer::black(picture.width, picture.height, self.session.get().picture.view);
            let beginning = DragBeginning { picture: Arc::new(picture), passes: evaluator.passes() };
            let mut drag = Arc::clone(&evaluator).drag(moved, numbers, MOST, Some(&beginning))?;
            while !task.cancelled.load(Ordering::Relaxed) && !drag.prepare() {}
            Ok(Some(Held { drag, evaluator, framebuffer, pool }))
        })
    }

    /// A value of this slider as three numbers.
    fn numbers(&self, value: &Bound<'_, PyAny>) -> PyResult<[f32; 3]> {
        numbers(self.session.get().values_now().table().parameter(self.id), value)
    }

    /// Moves the value. Returns all parameter numbers.
    fn moved(&self, value: [f32; 3]) -> Vec<f32> {
        let mut values = lock(&self.session.get().values);
        values.move_to(self.owner, self.id, value);
        values.numbers().to_vec()
    }

    fn linear(&self, value: [f32; 3], task: &Task) -> PyResult<Frame> {
        let mut held = lock(&self.held);
        let Held { drag, evaluator, pool, .. } = held.as_mut().ok_or_else(not_held)?;
        let numbers = self.moved(value);
        // Where images do not give the linear picture, it is evaluated.
        let known = move || drag.linear(&numbers).map_or_else(|| mean(&**evaluator, &numbers, task), Ok);
        on_threads(pool.as_deref(), known).map_err(engine_failure)
    }

    fn bytes(&self, value: [f32; 3]) -> PyResult<(Vec<u8>, [u32; 2])> {
        let mut held = lock(&self.held);
        let Held { drag, framebuffer, pool, .. } = held.as_mut().ok_or_else(not_held)?;
        let numbers = self.moved(value);
        on_threads(pool.as_deref(), || drag.frame(&numbers, framebuffer));
        let mut bytes = vec![[0; 3]; framebuffer.pixels.len()];
        on_threads(pool.as_deref(), || {
            let pairs = bytes.par_iter_mut().zip(&framebuffer.pixels).with_min_len(PIXELS_AT_ONCE);
            // A pixel is 0x00RRGGBB.
            pairs.for_each(|(bytes, pixel)| bytes.copy_from_slice(&pixel.to_be_bytes()[1..]));
        });
        Ok((bytes.into_flattened(), [framebuffer.width, framebuffer.height]))
    }
}
