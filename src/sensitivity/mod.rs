//! How a picture changes when parameters move: its derivative, as a picture.
//!
//! Most parameters change what lights add at hits. Their derivative is the picture of the
//! [tangent](crate::formula::tangent) of the formula on the same hits. Some change the weights of rays, or what rays
//! that leave the scene bring. Pictures are polynomials in weights, so their derivative is measured between two
//! pictures beside the values.

use crate::engine::{Engine, EngineError, Subject};
use crate::evaluate::Evaluator;
use crate::evaluate::inspect::Inspector;
use crate::formula::layout::Layout;
use crate::formula::tangent::Tangent;
use crate::formula::{Formula, ParameterId, Term};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::{Owner, Predefined};
use crate::picture::Frame;
use crate::trace::Hits;
use crate::world::World;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A number of the [`Layout`] that moves, by its index, and how fast.
pub type Speed = (usize, f32);

/// The picture of parameter numbers.
type PictureOfNumbers = Box<dyn Fn(&[f32]) -> Frame + Send + Sync>;

/// A picture with its derivative by some parameters.
pub struct Sensitivity {
    formula: Arc<Formula>,
    layout: Layout,
    picture: PictureOfNumbers,
    tangent: Tangent,
    tangent_layout: Layout,
    tangent_picture: PictureOfNumbers,
    /// The parameters that change how rays are weighted.
    weights: BTreeSet<ParameterId>,
    /// The index of the light that is an environment.
    environment: Option<usize>,
}

impl Sensitivity {
    /// Prepares the picture of a subject, the mean of these passes, and its derivative by these parameters.
    ///
    /// # Errors
    /// The formula or its tangent is too large for the backend, there are no hits, or memory does not suffice.
    pub fn new(
        engine: &Engine,
        subject: &Subject,
        hits: &[Arc<Hits>],
        moving: &[ParameterId],
        numbers: &[f32],
    ) -> Result<Self, EngineError> {
        Self::with(subject, moving, |subject, tangent| {
            let numbers = tangent.map_or_else(|| numbers.to_vec(), |tangent| tangent(numbers));
            let picture = prepared(engine, subject, hits, &numbers)?;
            Ok(Box::new(move |numbers: &[f32]| picture.frame(numbers)) as PictureOfNumbers)
        })
    }

    /// The same for one pixel of the view alone, which is traced for each picture. Pictures have one pixel. Outside of
    /// the view they are black.
    pub fn of_pixel(subject: &Subject, pixel: [u32; 2], moving: &[ParameterId]) -> Self {
        let made = Self::with(subject, moving, |subject, _| {
            let Subject { formula, world, view } = subject.clone();
            Ok::<_, std::convert::Infallible>(Box::new(move |numbers: &[f32]| {
                let inspection = Inspector::new(&formula, &world, numbers).inspect(&view, pixel);
                Frame { width: 1, height: 1, linear: vec![inspection.map_or([0.0; 3], |found| found.total)] }
            }) as PictureOfNumbers)
        });
        match made {
            Ok(made) => made,
            Err(never) => match never {},
        }
    }

    /// Makes the pictures of the formula and of its tangent by `picture`, which is given what makes numbers of the
    /// tangent from those of the formula.
    fn with<E>(
        subject: &Subject,
        moving: &[ParameterId],
        picture: impl Fn(&Subject, Option<&dyn Fn(&[f32]) -> Vec<f32>>) -> Result<PictureOfNumbers, E>,
    ) -> Result<Self, E> {
        let formula = Arc::clone(&subject.formula);
        let weights = weight_parameters(&formula);
        let inner: Vec<ParameterId> = moving.iter().copied().filter(|id| !weights.contains(id)).collect();
        let tangent = Tangent::new(&formula, &inner);
        let tangent_subject = Subject { formula: Arc::new(tangent.formula.clone()), ..subject.clone() };
        let layout = layout_of(&formula, &subject.world);
        let tangent_layout = layout_of(&tangent.formula, &subject.world);
        let plain = |numbers: &[f32]| tangent.numbers([&layout, &tangent_layout], numbers, &[]);
        let tangent_picture = picture(&tangent_subject, Some(&plain))?;
        let picture = picture(subject, None)?;
        let environment = subject.world.environment().map(|environment| environment.light().index());
        Ok(Self { formula, layout, picture, tangent, tangent_layout, tangent_picture, weights, environment })
    }

    /// The picture of these parameter numbers: linear RGB, not clamped.
    pub fn picture(&self, numbers: &[f32]) -> Frame {
        (self.picture)(numbers)
    }

    /// How fast the picture changes at these numbers while some of them move: Σ speed · ∂picture/∂number.
    pub fn change(&self, numbers: &[f32], speeds: &[Speed]) -> Frame {
        let (weights, inner): (Vec<Speed>, Vec<Speed>) = speeds.iter().partition(|speed| self.is_measured(speed.0));
        let mut total: Option<Frame> = None;
        if !inner.is_empty() {
            total = Some(self.tangent_change(numbers, &inner));
        }
        if weights.iter().any(|(_, speed)| *speed != 0.0) {
            let measured = self.measured_change(numbers, &weights);
            match &mut total {
                Some(total) => total.add(&measured),
                None => total = Some(measured),
            }
        }
        total.unwrap_or_else(|| {
            let mut black = self.picture(numbers);
            black.linear.fill([0.0; 3]);
            black
        })
    }

    /// Whether the derivative by a number is measured between two pictures.
    pub fn is_measured(&self, index: usize) -> bool {
        let Some((id, owner)) = self.parameter_at(index) else { return false };
        let environment = [Predefined::Intensity, Predefined::LightColour].map(|predefined| self.formula.predefined(predefined));
        self.weights.contains(&id) || self.environment == Some(owner) && environment.contains(&id)
    }

    /// The parameter that a number belongs to, and the index of its owner.
    fn parameter_at(&self, index: usize) -> Option<(ParameterId, usize)> {
        let (owner, row, slot) = self.layout.owner_of(index)?;
        let holds = |id: &ParameterId| {
            let parameter = self.formula.parameter(*id);
            let first = parameter.slot as usize;
            parameter.owner == owner && (first..first + parameter.ty.slots()).contains(&slot)
        };
        Some((self.formula.parameter_ids().find(holds)?, row))
    }

    fn tangent_change(&self, numbers: &[f32], speeds: &[Speed]) -> Frame {
        let layouts = [&self.layout, &self.tangent_layout];
        let background = self.formula.parameter(self.formula.predefined(Predefined::Background));
        let of = |speeds: &[Speed]| {
            let mut all = self.tangent.numbers(layouts, numbers, speeds);
            // A ray that hits nothing brings the background, whose change is its own speed.
            let [from, to] = layouts.map(|layout| layout.index(background, 0));
            for component in 0..3 {
                let speed = speeds.iter().find(|(index, _)| *index == from + component);
                all[to + component] = speed.map_or(0.0, |(_, speed)| *speed);
            }
            (self.tangent_picture)(&all)
        };
        let mut change = of(speeds);
        if self.environment.is_some() {
            // Rays that leave the scene bring the same light, whatever moves.
            let still = of(&[]);
            let components = change.linear.as_flattened_mut().iter_mut().zip(still.linear.as_flattened());
            components.for_each(|(component, still)| *component -= still);
        }
        change
    }

    fn measured_change(&self, numbers: &[f32], speeds: &[Speed]) -> Frame {
        /// How far the fastest number moves to each side, as a part of its range.
        const STEP: f32 = 1.0 / 128.0;
        let range_of = |index: usize| {
            let range = self.parameter_at(index).and_then(|(id, _)| self.formula.parameter(id).range);
            range.unwrap_or([f32::MIN, f32::MAX])
        };
        let steps = speeds.iter().filter(|(_, speed)| *speed != 0.0).map(|(index, speed)| {
            let [low, high] = range_of(*index);
            STEP * (high - low).clamp(f32::MIN_POSITIVE, 1.0) / speed.abs()
        });
        let step = steps.fold(f32::INFINITY, f32::min);
        // As far as all ranges allow, to each side.
        let reach = |sign: f32| {
            let free = speeds.iter().filter(|(_, speed)| *speed != 0.0).map(|(index, speed)| {
                let ([low, high], at, speed) = (range_of(*index), numbers[*index], sign * speed);
                (if speed > 0.0 { high - at } else { low - at }) / speed
            });
            free.fold(step, f32::min).max(0.0)
        };
        let (right, left) = (reach(1.0), reach(-1.0));
        let at = |by: f32| {
            let mut moved = numbers.to_vec();
            for (index, speed) in speeds {
                let [low, high] = range_of(*index);
                moved[*index] = (moved[*index] + by * speed).clamp(low, high);
            }
            (self.picture)(&moved)
        };
        let (mut high, low) = (at(right), at(-left));
        let width = right + left;
        let components = high.linear.as_flattened_mut().iter_mut().zip(low.linear.as_flattened());
        components.for_each(|(high, low)| *high = if width > 0.0 { (*high - low) / width } else { 0.0 });
        high
    }
}

fn layout_of(formula: &Formula, world: &World) -> Layout {
    Layout::new(formula, world.scene().bodies.len(), world.scene().lights.len())
}

fn prepared(engine: &Engine, subject: &Subject, hits: &[Arc<Hits>], numbers: &[f32]) -> Result<Arc<dyn Evaluator>, EngineError> {
    let (first, others) = hits
        .split_first()
        .ok_or_else(|| EngineError::Evaluate(crate::evaluate::EvaluateError::Backend("there are no traced passes".to_owned())))?;
    others.iter().try_fold(engine.prepare(subject, first, numbers)?, |evaluator, hits| Ok(evaluator.with_pass(hits)?))
}

/// The parameters that change the weights of reflected and refracted rays.
fn weight_parameters(formula: &Formula) -> BTreeSet<ParameterId> {
    let mut found = BTreeSet::new();
    for (term, predefined) in [(SurfaceTerm::Reflected, Predefined::Reflection), (SurfaceTerm::Refracted, Predefined::Refraction)]
    {
        match formula.surface.get(term) {
            None => {
                found.insert(formula.predefined(predefined));
            }
            Some(root) => found.extend(formula.terms_of(root).into_iter().filter_map(|id| match formula.term(id) {
                Term::Parameter(parameter) => Some(*parameter),
                Term::Number(_) | Term::Material(_) | Term::Variable(_) | Term::Apply(..) | Term::ByComponents(..) => None,
            })),
        }
    }
    found.retain(|id| formula.parameter(*id).owner != Owner::Light);
    found
}

#[cfg(test)]
mod tests;
