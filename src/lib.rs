//! Illuminator, a lighting workshop: an illumination model typed as mathematics, a scene, and the ray-traced picture that
//! follows the model's parameters at once.
//!
//! Tracing rays is slow, shading is fast, and hits do not move while only materials change. So rays are traced once, every
//! pixel keeps its *formula* (the model, instantiated at each hit of the pixel's ray tree), and a moved parameter evaluates formulas
//! again: by code that Cranelift compiled for many records at a time, or by a reference interpreter that proves it right.
//!
//! ```text
//! formula text ─▶ lang ──▶ formula ─┬─▶ bytecode ────────────────────────┐
//!                                   └─▶ jit ────────────────────┐        │
//!   scene text ─▶ lang ──▶ scene ──▶ world ──▶ trace (hits) ──▶ evaluate ──▶ frame ──▶ picture
//!                                                                 ▲
//!                                workspace: values, sessions ─────┘
//! ```
//!
//! # Example
//!
//! ```
//! use illuminator::evaluate::{Backend, Evaluator};
//! use illuminator::lang::source::Source;
//! use illuminator::trace::{Budget, View, trace};
//! use illuminator::workspace::{Setting, Values};
//! use illuminator::{formula::Formula, picture::Transfer, picture::quantise, scene::Scene};
//! use std::sync::{Arc, atomic::AtomicBool};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let model = Source::new("lambert", "formula; = IL*Cd*max(0, N.L);");
//! let (formula, _warnings) = Formula::parse(&model).map_err(|errors| errors.located(&model).to_string())?;
//! let place = Source::new("ball", "bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <3,4,5>;
//!     camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;");
//! let (scene, _warnings) = Scene::parse(&place).map_err(|errors| errors.located(&place).to_string())?;
//!
//! let mut values = Values::defaults(&formula, &scene);
//! let red: Setting = "ball.Cd=<0.9, 0.2, 0.1>".parse()?;
//! values.assign(&red.resolve(values.roster())?);
//!
//! let view = View::new(64, 48)?;
//! let hits = Arc::new(trace(&scene, &view, &Budget::UNLIMITED, &|_| {}, &AtomicBool::new(false))?);
//! let evaluator = Evaluator::new(&Arc::new(formula), &Arc::new(scene), &hits, Backend::Jit)?;
//! let mut frame = evaluator.frame(values.numbers());
//! assert_eq!(frame.clean(), 0, "no pixel is NaN");
//! let image: Vec<u8> = quantise(&frame.linear, Transfer::Linear);
//! # let middle = 3 * (24 * 64 + 32);
//! # assert!(image[middle] > 100 && image[middle] > 3 * image[middle + 1]);
//! # Ok(())
//! # }
//! ```
//!
//! Nothing here knows of windows, terminals or command lines; the program `illuminator` is built on top.

pub mod files;

pub mod lang;

pub mod formula;

pub mod scene;

pub mod world;

mod segment;

pub mod trace;

pub mod bytecode;

pub mod plan;

pub mod jit;

mod transfer;

pub mod evaluate;

pub mod backends;

pub mod engine;

pub mod workspace;

pub mod picture;

#[cfg(any(feature = "cli", feature = "window"))]
pub mod user_data;

#[cfg(feature = "window")]
pub mod preview;
