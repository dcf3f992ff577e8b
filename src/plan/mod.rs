//! Plans: what backends compute, as plain data. A plan lists kernels of a formula or of a drag: nodes of a graph that
//! are computed from columns and uniform values.
//!
//! A backend reads plans and decides how to run them. Plans do not know machine code, memory layouts or pixels.
//!
//! ```text
//! formula::Bindings ─▶ FormulaPlan ────────────▶ a backend's kernels
//!        └─ formula::Separation ─▶ SliderPlan ─▶ a backend's kernels for a slider
//!                                       └─ DragPlan: what moves on a scene, and what each picture is a sum of
//! ```

mod conditions;
mod contribution;
mod drag;
mod formula;
mod kernel;
mod slider;
mod surface;

pub use conditions::{ConditionPlan, VariantPlan};
pub use contribution::{ContributionPlan, ParameterSlot, parameter_slots};
pub use drag::{Channels, DragPlan, Factors, ImageTerm, Method, MovedTerm, is_of_miss};
pub use formula::FormulaPlan;
pub use kernel::{Domain, KernelPlan, KernelWork, STREAMS, Schedule, Sink};
pub use slider::{Moved, SliderPlan, moved_parameters};
pub use surface::SurfacePlan;
