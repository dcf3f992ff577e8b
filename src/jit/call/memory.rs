//! The executable memory of compiled code.

use cranelift_jit::{JITBuilder, JITModule};
use std::mem::ManuallyDrop;

/// The executable memory of functions that are compiled together. Whatever runs its code owns it or shares it.
pub(super) struct CodeMemory(pub(super) ManuallyDrop<JITModule>);

// SAFETY: the module is touched only when it is made and, by the one owner left, when it is dropped; kernels only run
// code in its memory.
unsafe impl Send for CodeMemory {}
// SAFETY: as above; there is no method that reads or changes the module through a shared reference.
unsafe impl Sync for CodeMemory {}

impl CodeMemory {
    /// Takes ownership of the module at once: a module that is merely dropped leaks its memory.
    pub(super) fn new(builder: JITBuilder) -> Self {
        Self(ManuallyDrop::new(JITModule::new(builder)))
    }
}

impl Drop for CodeMemory {
    fn drop(&mut self) {
        // SAFETY: the value is not used after this, since it is being dropped. Every kernel and list of calls holds the
        // memory by an `Arc`, and code for pixels owns it, so no code in it can be running or be called any more.
        unsafe { ManuallyDrop::take(&mut self.0).free_memory() }
    }
}
