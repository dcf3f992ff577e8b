//! Widgets and the picture into pixels, on the CPU.
