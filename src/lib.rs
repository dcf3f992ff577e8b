//! Illuminator, a lighting workshop: an illumination model typed as mathematics, a scene, and the ray-traced picture
//! that follows the model's parameters at once.
//!
//! Tracing rays is slow, and shading is fast. Hits do not move while only materials change. So rays are traced once,
//! and the hits are stored. When a parameter moves, only the formula is evaluated again, over the stored hits.
//! Cranelift compiles it to code that computes many records at a time. A reference interpreter checks the compiled
//! code.
//!
//! ```text
//! formula text ─▶ lang ──▶ formula ──▶ plan ─┬─▶ backends: compiled (jit), interpreter (bytecode) ─┐
//!   scene text ─▶ lang ──▶ scene ──▶ world ──┴─▶ trace (hits) ──▶ evaluate ◀───────────────────────┘──▶ picture
//!
//!                  engine: the whole sequence        workspace: values, sessions, materials        assist: help for editors
//! ```
//!
//! # Example
//!
//! ```
//! use illuminator::{engine::{Engine, Subject, Task}, trace::View, workspace::{NamedAssignment, Values}};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = "bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <3,4,5>;
//!     camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;";
//! let subject = Subject::parse("formula; = IL*Cd*max(0, N.L);", scene, View::new(64, 48)?)?;
//! let mut values = Values::defaults(&subject.formula, subject.world.scene());
//! values.assign(&"ball.Cd=<0.9, 0.2, 0.1>".parse::<NamedAssignment>()?.resolve(values.table())?);
//! let picture = Engine::default().picture(&subject, values.numbers(), 1, &Task::UNWATCHED)?;
//! let [red, green, _] = picture.linear[24 * 64 + 32];
//! assert!(red > 0.4 && red > 3.0 * green, "the middle of the ball is red: {red} {green}");
//! # Ok(())
//! # }
//! ```
//!
//! Nothing here knows of windows, terminals or command lines; the program `illuminator` is built on top.

pub mod files;

pub mod simd;

pub mod texture;

pub mod measured;

pub mod sampling;

pub mod lang;

pub mod formula;

pub mod scene;

pub mod mesh;

pub mod bvh;

pub mod environment;

pub mod world;

pub mod trace;

pub mod bytecode;

pub mod plan;

pub mod jit;

pub mod evaluate;

pub mod backends;

pub mod engine;

#[cfg(feature = "plot")]
pub mod plot;

pub mod instrument;

pub mod sensitivity;

#[cfg(feature = "fit")]
pub mod fit;

pub mod workspace;

pub mod picture;

pub mod import;

pub mod assist;

pub mod export;

#[cfg(any(feature = "cli", feature = "window"))]
pub mod user_data;

#[cfg(feature = "window")]
pub mod preview;

/// The examples in the manual's chapter about the library, which documentation tests try.
#[cfg(doctest)]
#[doc = include_str!("../docs/manual/src/library.md")]
struct LibraryChapter;
