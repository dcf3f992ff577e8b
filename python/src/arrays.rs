//! Numbers between Rust and NumPy.

use illuminator::picture::Frame;
use numpy::{Element, IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

/// A linear picture as an array of height × width × 3. The numbers are moved, not copied.
pub(crate) fn picture(py: Python<'_>, frame: Frame) -> PyResult<Bound<'_, PyArray3<f32>>> {
    let shape = [frame.height as usize, frame.width as usize, 3];
    frame.linear.into_flattened().into_pyarray(py).reshape(shape)
}

/// A picture of bytes as an array of height × width × 3.
pub(crate) fn bytes(py: Python<'_>, bytes: Vec<u8>, [width, height]: [u32; 2]) -> PyResult<Bound<'_, PyArray3<u8>>> {
    bytes.into_pyarray(py).reshape([height as usize, width as usize, 3])
}

/// Rows of `components` numbers: one dimension for one component, else two.
pub(crate) fn rows<T: Element>(py: Python<'_>, numbers: Vec<T>, components: usize) -> PyResult<Bound<'_, PyAny>> {
    let count = numbers.len() / components.max(1);
    let flat = numbers.into_pyarray(py);
    Ok(if components == 1 { flat.into_any() } else { flat.reshape([count, components])?.into_any() })
}

/// A parameter's value: a number, or an array of three.
pub(crate) fn value(py: Python<'_>, numbers: &[f32]) -> PyResult<Py<PyAny>> {
    Ok(match numbers {
        [number] => shortest(*number).into_pyobject(py)?.into_any().unbind(),
        numbers => numbers.to_vec().into_pyarray(py).into_any().unbind(),
    })
}

/// The number that a person wrote: 0.3 rather than 0.30000001192.
fn shortest(number: f32) -> f64 {
    number.to_string().parse().unwrap_or_else(|_| f64::from(number))
}
