//! How a camera is led around a scene: orbit, pan, dolly, field of view, views from six sides, framing.
//!
//! Everything is computed from the camera before the motion, so the result does not depend on the number of steps. A
//! motion that no camera can follow, for instance because it would end too far away, gives `None`.

use crate::scene::Camera;
use glam::{DQuat, DVec3};

/// The steepest view up or down that an orbit reaches, in radians. The poles themselves are left out, so the picture
/// never turns over.
const STEEPEST: f64 = 89.9 / 180.0 * std::f64::consts::PI;
/// A gaze closer to −y than this cosine looks straight down. Then `up` only says where the picture's upper edge is, and
/// y is still upwards in the scene; unless `up` is +z, as in scenes where z is upwards.
const VERTICAL: f64 = 0.999_999_6;
/// The widest and the narrowest field of view that a motion reaches, in degrees.
const FOVS: [f64; 2] = [1.0, 150.0];
/// The part of the picture's width or height that a framed box fills.
const FILLED: f64 = 0.85;

/// A side from which a scene is viewed. In a scene where y is upwards, the front is towards +z and the right side
/// towards +x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewSide {
    /// From +z, for scenes where y is upwards.
    Front,
    /// The opposite of the front.
    Back,
    /// From −x, for scenes where y is upwards.
    Left,
    /// From +x, for scenes where y is upwards.
    Right,
    /// From above.
    Top,
    /// From below.
    Bottom,
}

impl ViewSide {
    /// All sides.
    pub const ALL: [ViewSide; 6] =
        [ViewSide::Front, ViewSide::Back, ViewSide::Right, ViewSide::Left, ViewSide::Top, ViewSide::Bottom];
}

impl Camera {
    /// The direction that is upwards in the scene, of unit length: the axis about which the camera orbits.
    pub fn upright(&self) -> DVec3 {
        let ([.., forward], up) = (self.axes(), self.up().normalize());
        if forward.y < -VERTICAL && up.z < 0.5 { DVec3::Y } else { up }
    }

    /// Orbits about a point: first about the upright axis, by `turn` to the left as seen from above, then up by
    /// `climb`, both in radians. The point stays where it is in the picture. The view never becomes steeper than 89.9°.
    pub fn orbited(&self, pivot: DVec3, turn: f64, climb: f64) -> Option<Camera> {
        let (upright, [right, _, forward]) = (self.upright(), self.axes());
        let across = right.reject_from_normalized(upright).normalize();
        let elevation = forward.dot(upright).clamp(-1.0, 1.0).asin();
        let elevation = (elevation - climb).clamp(-STEEPEST, STEEPEST);
        let across = DQuat::from_axis_angle(upright, turn) * across;
        let ahead = upright.cross(across);
        self.turned(pivot, elevation.cos() * ahead + elevation.sin() * upright, upright)
    }

    /// Turns rigidly about a point until the camera looks `forward`, with `up` upwards in the picture.
    fn turned(&self, pivot: DVec3, forward: DVec3, up: DVec3) -> Option<Camera> {
        let offset = self.position() - pivot;
        let coordinates = self.axes().map(|axis| offset.dot(axis));
        // A vector of the text that means the same direction stays as it is written.
        let written = self.up().normalize().abs_diff_eq(up, 1e-12);
        let up = if written { self.up() } else { up };
        let turned = Camera::new(self.position(), self.gaze().length() * forward.normalize(), up, self.fov()).ok()?;
        let moved: DVec3 = turned.axes().into_iter().zip(coordinates).map(|(axis, along)| along * axis).sum();
        turned.at(pivot + moved)
    }

    /// The same camera elsewhere.
    fn at(&self, position: DVec3) -> Option<Camera> {
        Camera::new(position, self.gaze(), self.up(), self.fov()).ok()
    }

    /// Moves parallel to the image plane, so that what was seen at `from` at this depth is seen at `to`. Both are
    /// points of the image plane, see [`direction`](Self::direction). The depth is in world units.
    pub fn panned(&self, depth: f64, from: [f64; 2], to: [f64; 2]) -> Option<Camera> {
        self.at(self.position() + self.point_at(from, depth) - self.point_at(to, depth))
    }

    /// Moves along the line to a point, until the distance to it is this many times what it was.
    pub fn dollied(&self, target: DVec3, factor: f64) -> Option<Camera> {
        self.at(target + factor * (self.position() - target))
    }

    /// Makes the field of view this many times as high, measured in the image plane; between 1 and 150 degrees.
    pub fn widened(&self, factor: f64) -> Option<Camera> {
        let half = (self.fov().to_radians() / 2.0).tan() * factor;
        let [narrowest, widest] = FOVS;
        let fov = (2.0 * half.atan()).to_degrees().clamp(narrowest.min(self.fov()), widest.max(self.fov()));
        Camera::new(self.position(), self.gaze(), self.up(), fov).ok()
    }

    /// Views a point from a side, from the same distance.
    pub fn from_side(&self, side: ViewSide, pivot: DVec3) -> Option<Camera> {
        let upright = self.upright();
        let towards = if upright.z.abs() < 0.9 { DVec3::Z } else { DVec3::NEG_Y };
        let front = towards.reject_from_normalized(upright).normalize();
        let right = upright.cross(front);
        // The view is a little beside the pole, so that `up` still says what is upwards in the scene. Straight down is
        // the exception, see `upright`.
        let beside = |along: DVec3| (STEEPEST.sin() * along + STEEPEST.cos() * front, upright);
        let (from, up) = match side {
            ViewSide::Front => (front, upright),
            ViewSide::Back => (-front, upright),
            ViewSide::Right => (right, upright),
            ViewSide::Left => (-right, upright),
            ViewSide::Top if upright == DVec3::Y => (upright, -front),
            ViewSide::Top => beside(upright),
            ViewSide::Bottom => beside(-upright),
        };
        let distance = self.position().distance(pivot);
        let up = if up == upright && self.up().normalize().abs_diff_eq(up, 1e-12) { self.up() } else { up };
        Camera::new(pivot + distance * from, -self.gaze().length() * from, up, self.fov()).ok()
    }

    /// Moves so that the box between two corners is in the middle of the picture, as large as the picture allows. The
    /// gaze stays the same. `aspect` is the picture's width divided by its height.
    pub fn framing(&self, low: DVec3, high: DVec3, aspect: f64) -> Option<Camera> {
        let (middle, axes) = (low.midpoint(high), self.axes());
        let half = (self.fov().to_radians() / 2.0).tan();
        let corners = (0..8).map(|corner| {
            let pick = |bit: i32, low: f64, high: f64| if corner >> bit & 1 == 1 { high } else { low };
            DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z)) - middle
        });
        let distances = corners.map(|corner| {
            let [across, above, ahead] = axes.map(|axis| corner.dot(axis));
            (across.abs() / aspect).max(above.abs()) / (FILLED * half) - ahead
        });
        let distance = distances.fold(0.0, f64::max);
        self.at(middle - distance * axes[2])
    }

    /// Moves so that all of these points are in the picture, as large as it allows. The gaze stays the same. `aspect`
    /// is the picture's width divided by its height.
    pub fn framing_all(&self, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Option<Camera> {
        let axes = self.axes();
        let above = FILLED * (self.fov().to_radians() / 2.0).tan();
        let slopes = [above * aspect, above];
        // The planes through the camera and the edges of the picture must have all points between them. Across and
        // above, on either side: how far out such a plane is, at the depth of the origin.
        let mut reach = [[f64::NEG_INFINITY; 2]; 2];
        for point in points {
            let ahead = point.dot(axes[2]);
            for (axis, sides) in reach.iter_mut().enumerate() {
                let across = point.dot(axes[axis]);
                sides[0] = sides[0].max(across - slopes[axis] * ahead);
                sides[1] = sides[1].max(-across - slopes[axis] * ahead);
            }
        }
        let distances = [0, 1].map(|axis| (reach[axis][0] + reach[axis][1]) / (2.0 * slopes[axis]));
        let [across, above] = reach.map(|[one, other]| (one - other) / 2.0);
        self.at(across * axes[0] + above * axes[1] - distances[0].max(distances[1]) * axes[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn camera() -> Camera {
        Camera::new(DVec3::new(0.2, 2.1, 8.0), DVec3::new(0.0, -0.15, -1.0), DVec3::Y, 29.0).unwrap()
    }

    fn near(one: DVec3, other: DVec3) -> bool {
        one.abs_diff_eq(other, 1e-9)
    }

    #[test]
    fn a_quarter_turn_leads_from_the_front_to_the_right_side() {
        let front = Camera::new(DVec3::new(0.0, 0.0, 5.0), 2.0 * DVec3::NEG_Z, 3.0 * DVec3::Y, 40.0).unwrap();
        let quarter = std::f64::consts::FRAC_PI_2;
        let right = front.orbited(DVec3::ZERO, quarter, 0.0).unwrap();
        assert!(near(right.position(), 5.0 * DVec3::X) && near(right.gaze(), -2.0 * DVec3::X), "{right:?}");
        assert_eq!(right.up(), 3.0 * DVec3::Y, "as it was written");
        let above = front.orbited(DVec3::ZERO, 0.0, quarter / 2.0).unwrap();
        let half = 0.5f64.sqrt();
        assert!(near(above.position(), 5.0 * DVec3::new(0.0, half, half)), "{above:?}");
        assert!(near(above.gaze(), -2.0 * DVec3::new(0.0, half, half)));
    }

    #[test]
    fn the_poles_are_not_passed() {
        let mut camera = camera();
        for _ in 0..50 {
            camera = camera.orbited(DVec3::ZERO, 0.0, 0.5).unwrap();
        }
        let [right, above, forward] = camera.axes();
        assert!((forward.y + 89.9f64.to_radians().sin()).abs() < 1e-12 && above.y > 0.0, "{camera:?}");
        assert!(near(right, DVec3::X), "the picture does not turn");
        for _ in 0..100 {
            camera = camera.orbited(DVec3::ZERO, 0.0, -0.5).unwrap();
        }
        let [right, above, forward] = camera.axes();
        assert!(forward.y > 0.999 && above.y > 0.0 && near(right, DVec3::X), "{camera:?}");
    }

    #[test]
    fn six_sides_are_six_directions_and_orbiting_goes_on_from_each() {
        let pivot = DVec3::new(1.0, 2.0, 3.0);
        let camera = camera();
        let distance = camera.position().distance(pivot);
        let expected = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];
        for (side, from) in ViewSide::ALL.into_iter().zip(expected) {
            let view = camera.from_side(side, pivot).unwrap();
            // The poles are not passed, from below.
            let tolerance = if side == ViewSide::Bottom { 0.002 } else { 1e-9 };
            assert!(view.position().abs_diff_eq(pivot + distance * from, tolerance * distance), "{side:?} {view:?}");
            assert!(view.gaze().normalize().abs_diff_eq(-from, tolerance), "{side:?} {view:?}");
            assert!(view.project(pivot).unwrap().into_iter().all(|coordinate| coordinate.abs() < 1e-9));
            assert_eq!(view.upright(), DVec3::Y, "{side:?}");
            // A small orbit changes little, from the poles too.
            let next = view.orbited(pivot, 0.0, 0.0).unwrap();
            assert!(
                next.axes().into_iter().zip(view.axes()).all(|(one, other)| one.abs_diff_eq(other, 0.01)),
                "{side:?} {next:?}"
            );
            assert_eq!(next.upright(), DVec3::Y);
        }
        let above = camera.from_side(ViewSide::Top, pivot).unwrap();
        assert_eq!(above.axes()[0], DVec3::X, "as on a map, x is to the right");
        // Where z is upwards, too.
        let camera = Camera::new(DVec3::new(0.0, -9.0, 1.0), DVec3::Y, DVec3::Z, 40.0).unwrap();
        let right = camera.from_side(ViewSide::Right, DVec3::ZERO).unwrap();
        assert!(right.position().normalize().abs_diff_eq(DVec3::X, 1e-12) && right.up() == DVec3::Z);
        let above = camera.from_side(ViewSide::Top, DVec3::ZERO).unwrap();
        assert!(near(above.axes()[0], DVec3::X) && above.upright() == DVec3::Z, "{above:?}");
    }

    #[test]
    fn a_wider_field_of_view_is_wider_in_the_image_plane_and_has_limits() {
        let camera = Camera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 90.0).unwrap();
        assert!((camera.widened(1.0 / 3f64.sqrt()).unwrap().fov() - 60.0).abs() < 1e-9);
        assert_eq!(camera.widened(1e9).unwrap().fov(), 150.0);
        assert_eq!(camera.widened(1e-9).unwrap().fov(), 1.0);
        let wide = Camera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 170.0).unwrap();
        assert!((wide.widened(1.0).unwrap().fov() - 170.0).abs() < 1e-9, "what the text says is no motion");
    }

    #[test]
    fn a_framed_box_touches_the_frame_and_stays_within() {
        let (low, high) = (DVec3::new(-1.0, 0.0, 2.0), DVec3::new(3.0, 1.0, 4.5));
        for aspect in [0.5, 1.0, 2.4] {
            let framed = camera().framing(low, high, aspect).unwrap();
            assert_eq!(framed.gaze(), camera().gaze());
            let corners = (0..8).map(|bits| {
                let pick = |axis: usize| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] };
                framed.project(DVec3::new(pick(0), pick(1), pick(2))).unwrap()
            });
            let reach = corners.map(|[x, y]| (x.abs() / aspect).max(y.abs())).fold(0.0, f64::max);
            assert!((reach - FILLED).abs() < 1e-9, "{aspect}: {reach}");
        }
        // A point has no size, but the camera goes to it.
        assert!(near(camera().framing(low, low, 1.0).unwrap().position(), low));
    }

    #[test]
    fn framed_points_touch_the_frame_and_stay_within() {
        let aspect = 16.0 / 9.0;
        for points in [[1.0, 2.0, 3.0], [1e-6, 2e-6, 9e-6], [4.0, 1e4, 2.0]] {
            let points = DVec3::AXES.into_iter().zip(points).map(|(axis, length)| length * axis + DVec3::new(5.0, -7.0, 2.0));
            let points = Vec::from_iter(points);
            let framed = camera().framing_all(points.iter().copied(), aspect).unwrap();
            let seen = points.iter().map(|point| framed.project(*point).unwrap()).map(|[x, y]| [x / aspect, y]);
            let reach = |list: &mut dyn Iterator<Item = f64>| {
                list.fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)])
            };
            let seen = Vec::from_iter(seen);
            let ranges = [0, 1].map(|axis| reach(&mut seen.iter().map(|place| place[axis])));
            assert!(ranges.iter().flatten().all(|place| place.abs() < FILLED + 1e-9), "{ranges:?}");
            // Both edges across or both above and below.
            let touches = |[low, high]: [f64; 2]| (high - FILLED).abs() < 1e-6 && (low + FILLED).abs() < 1e-6;
            assert!(ranges.into_iter().any(touches), "{ranges:?}");
        }
        assert_eq!(camera().framing_all([], aspect), None);
    }

    proptest! {
        #[test]
        fn an_orbit_keeps_the_pivot_in_the_picture_and_its_distance(
            pivot in (-5.0..5.0f64, -5.0..5.0f64, -5.0..5.0f64), turn in -7.0..7.0f64, climb in -4.0..4.0f64,
        ) {
            let pivot = DVec3::from(pivot);
            let before = camera();
            let after = before.orbited(pivot, turn, climb).unwrap();
            prop_assert!((after.position().distance(pivot) - before.position().distance(pivot)).abs() < 1e-9);
            match (before.project(pivot), after.project(pivot)) {
                (Some(one), Some(other)) => {
                    let far = one.into_iter().zip(other).map(|(one, other)| (one - other).abs() / one.abs().max(1.0));
                    prop_assert!(far.fold(0.0, f64::max) < 1e-6, "{one:?} {other:?}")
                }
                (one, other) => prop_assert_eq!(one.is_some(), other.is_some()),
            }
            // The horizon stays level.
            prop_assert!(after.axes()[0].y.abs() < 1e-9 && after.axes()[1].y > 0.0);
        }

        #[test]
        fn what_is_grabbed_stays_under_the_pointer(
            from in (-1.5..1.5f64, -1.0..1.0f64), to in (-1.5..1.5f64, -1.0..1.0f64), depth in 0.1..100.0f64,
        ) {
            let before = camera();
            let (from, to) = (<[f64; 2]>::from(from), <[f64; 2]>::from(to));
            let grabbed = before.point_at(from, depth);
            let after = before.panned(depth, from, to).unwrap();
            let [x, y] = after.project(grabbed).unwrap();
            prop_assert!((x - to[0]).abs() < 1e-9 && (y - to[1]).abs() < 1e-9);
            // A dolly to a point leaves it where it is in the picture.
            let nearer = before.dollied(grabbed, 0.25).unwrap();
            let [x, y] = nearer.project(grabbed).unwrap();
            prop_assert!((x - from[0]).abs() < 1e-9 && (y - from[1]).abs() < 1e-9);
            prop_assert!((nearer.depth_of(grabbed) - 0.25 * depth).abs() < 1e-9 * depth);
        }
    }
}
