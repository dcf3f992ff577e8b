//! The chords of convex bodies: the part of a line that is inside.
//!
//! A convex body is the intersection of simpler ones: of the slabs of a box, or of the wall and the ends of a cylinder.
//! A line is inside each of them over an interval, and the chord is the intersection of these intervals. So a body is
//! closed where its parts meet: no ray gets in or out between them.

use crate::world::hit::Meeting;
use crate::world::ray::PrimitiveId;

/// Where a line passes a part of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Passage {
    /// The distance from the origin of the ray in world units. It may be negative or infinite.
    pub(super) distance: f64,
    /// The part of the surface.
    pub(super) part: PrimitiveId,
    /// Whether the part coincides with the surface that the ray comes from. Then it is not met.
    pub(super) at_origin: bool,
}

/// The part of a line that is inside a convex body: where it enters, and where it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chord {
    enter: Passage,
    leave: Passage,
}

impl Chord {
    /// The whole line.
    pub(super) const LINE: Chord = Chord {
        enter: Passage { distance: f64::NEG_INFINITY, part: PrimitiveId::ONLY, at_origin: false },
        leave: Passage { distance: f64::INFINITY, part: PrimitiveId::ONLY, at_origin: false },
    };

    /// What is also between two other passages.
    #[must_use]
    pub(super) fn between(self, [enter, leave]: [Passage; 2]) -> Self {
        Self {
            enter: if enter.distance > self.enter.distance { enter } else { self.enter },
            leave: if leave.distance < self.leave.distance { leave } else { self.leave },
        }
    }

    /// Where a ray that comes from elsewhere meets the body first.
    pub(super) fn first(self) -> Option<Meeting> {
        let is_met = |passage: &Passage| passage.distance > 0.0 && passage.distance.is_finite() && !passage.at_origin;
        let first = [self.enter, self.leave].into_iter().filter(|_| self.enter.distance < self.leave.distance).find(is_met);
        first.map(|passage| Meeting { primitive: passage.part, distance: passage.distance })
    }
}

/// Where a line passes two parallel planes between which a body is, in the order of the ray; `None` if it
/// passes beside.
///
/// The line is given by its height: `planes` are the heights of the planes above the origin of the ray, the lower one
/// first, and `slope` is how much the ray rises in one unit. `parts` are those of the planes, and `tolerance` is that
/// across them.
#[inline]
pub(super) fn slab(planes: [f64; 2], slope: f64, parts: [PrimitiveId; 2], tolerance: f64) -> Option<[Passage; 2]> {
    let passage = |plane: usize, distance: f64| Passage {
        distance,
        part: parts[plane],
        // Measured across the plane, not along the ray: a ray that starts in a coincident surface is not let in however
        // flat it goes.
        at_origin: planes[plane].abs() <= tolerance,
    };
    if slope == 0.0 {
        let inside = planes[0] <= 0.0 && planes[1] >= 0.0;
        return inside.then(|| [passage(0, f64::NEG_INFINITY), passage(1, f64::INFINITY)]);
    }
    let [first, second] = if slope > 0.0 { [0, 1] } else { [1, 0] };
    Some([first, second].map(|plane| passage(plane, planes[plane] / slope)))
}

/// The distance at which a ray that starts inside the body leaves a [`slab`], and the part that it meets there. It does
/// not meet the plane that it `left`.
pub(super) fn ahead(planes: [f64; 2], slope: f64, parts: [PrimitiveId; 2], left: PrimitiveId) -> (f64, PrimitiveId) {
    let plane = usize::from(slope > 0.0);
    let distance = if slope == 0.0 || parts[plane] == left { f64::INFINITY } else { planes[plane] / slope };
    (distance, parts[plane])
}

/// Where a ray that starts on the surface of a body and goes inside leaves it, from where it passes each part.
///
/// The ray is inside by definition. At an edge, rounding may put its origin a little beyond another part: there it
/// leaves at once, and never misses the body.
pub(super) fn way_out<const PARTS: usize>(passages: [(f64, PrimitiveId); PARTS]) -> Option<Meeting> {
    let nearest = passages.into_iter().min_by(|(one, _), (other, _)| one.total_cmp(other))?;
    let (distance, primitive) = nearest;
    distance.is_finite().then(|| Meeting { primitive, distance: distance.max(f64::MIN_POSITIVE) })
}
