//! The workshop window: editors, sliders and the picture, in one window whose widgets are painted on the CPU.
//!
//! What is shown and what a click does is code that knows no window, so that tests drive it without one; only `window` does.

pub mod renderer;
