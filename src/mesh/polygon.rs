//! Polygons cut into triangles.

use crate::mesh::error::Fault;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// The most corners of a polygon that is not convex.
const MOST_CORNERS: usize = 1 << 14;
/// Before a corner is cut off, other corners are compared with its triangle. A polygon may take this many comparisons,
/// which last about a second.
const MOST_COMPARISONS: usize = 1 << 28;

/// A polygon has too many corners, without being convex, to be cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TooIntricate {
    corners: usize,
}

impl TooIntricate {
    /// The mistake in a file, at these bytes.
    pub(super) fn at(self, place: Range<usize>) -> Fault {
        let message = format!("this polygon has {} corners and is too intricate to be cut into triangles", self.corners);
        Fault::at(place, message).help("save the mesh with triangles: programs for modelling offer it where they export")
    }
}

/// The triangles of a polygon, three indices of corners each, in the direction of the polygon. It may be concave. One
/// that is not flat is projected along its mean normal.
///
/// # Errors
/// It takes too long. Some triangles may have been emitted.
pub(super) fn triangulate(corners: &[DVec3], mut emit: impl FnMut([usize; 3])) -> Result<(), TooIntricate> {
    let count = corners.len();
    let fan = |emit: &mut dyn FnMut([usize; 3])| (2..count).for_each(|last| emit([0, last - 1, last]));
    if count <= 3 {
        fan(&mut emit);
        return Ok(());
    }
    let flat = projected(corners);
    let turns_left = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
    if (0..count).all(|corner| turns_left([corner, (corner + 1) % count, (corner + 2) % count]) >= 0.0) {
        fan(&mut emit);
        return Ok(());
    }
    if count > MOST_CORNERS {
        return Err(TooIntricate { corners: count });
    }
    // Cuts off one corner after the other: a convex one whose triangle holds no other corner.
    let mut left: Vec<usize> = (0..count).collect();
    let mut at = 0;
    let (mut failures, mut comparisons) = (0, 0);
    while left.len() > 3 {
        let length = left.len();
        if comparisons > MOST_COMPARISONS {
            return Err(TooIntricate { corners: count });
        }
        let ear = [0, 1, 2].map(|step| left[(at + step) % length]);
        let mut is_held = |corner: &usize| {
            comparisons += 1;
            !ear.contains(corner) && holds(&flat, ear, *corner)
        };
        let is_ear = turns_left(ear) > 0.0 && !left.iter().any(&mut is_held);
        // A polygon that crosses itself may have no such corner. Any one will do.
        if is_ear || failures > length {
            emit(ear);
            left.remove((at + 1) % length);
            failures = 0;
            at %= left.len();
        } else {
            failures += 1;
            at = (at + 1) % length;
        }
    }
    if let [a, b, c] = left[..] {
        emit([a, b, c]);
    }
    Ok(())
}

/// The corners in the plane that they lie in, so that the polygon goes counter-clockwise.
fn projected(corners: &[DVec3]) -> Vec<DVec2> {
    let origin = corners[0];
    let next = |index: usize| corners[(index + 1) % corners.len()] - origin;
    // Newell's normal: twice the area of the polygon, projected onto each plane of the axes.
    let normal: DVec3 = corners.iter().enumerate().map(|(index, corner)| (*corner - origin).cross(next(index))).sum();
    let size = normal.abs();
    let project = |corner: DVec3| {
        let [x, y, z] = (corner - origin).to_array();
        // Without the axis of the largest component, in the order that keeps the direction.
        if size.z >= size.x && size.z >= size.y {
            DVec2::new(x, y * normal.z.signum())
        } else if size.x >= size.y {
            DVec2::new(y, z * normal.x.signum())
        } else {
            DVec2::new(z, x * normal.y.signum())
        }
    };
    corners.iter().copied().map(project).collect()
}

/// Whether a corner lies within a triangle of others, or on its border but not at one of its corners.
fn holds(flat: &[DVec2], [a, b, c]: [usize; 3], corner: usize) -> bool {
    let point = flat[corner];
    if [a, b, c].iter().any(|other| flat[*other] == point) {
        return false;
    }
    let side = |from: usize, to: usize| (flat[to] - flat[from]).perp_dot(point - flat[from]) >= 0.0;
    side(a, b) && side(b, c) && side(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn triangles(corners: &[DVec3]) -> Vec<[usize; 3]> {
        let mut found = Vec::new();
        triangulate(corners, |triangle| found.push(triangle)).unwrap();
        found
    }

    /// The area of each triangle, positive if it goes counter-clockwise seen from +z.
    fn areas(corners: &[DVec3]) -> Vec<f64> {
        let area = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]).z / 2.0;
        triangles(corners).into_iter().map(area).collect()
    }

    #[test]
    fn a_dart_is_cut_at_its_concave_corner() {
        // A fan from the first corner would leave the polygon.
        let dart = [[2., 0., 0.], [0., 1., 0.], [0.5, 0., 0.], [0., -1., 0.]].map(DVec3::from_array);
        for start in 0..4 {
            let mut turned = dart;
            turned.rotate_left(start);
            let areas = areas(&turned);
            assert!(areas.iter().all(|area| *area > 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - 1.5).abs() < 1e-12, "2 · ½ · 1.5 · 1");
        }
    }

    /// A band of width 1 that goes round and round.
    fn spiral(corners: usize) -> Vec<DVec3> {
        let half = corners / 2;
        let at = |step: usize, inwards: f64| {
            let angle = step as f64 * 0.1;
            (angle * 0.5 + 10.0 - inwards) * DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        (0..half).map(|step| at(step, 0.0)).chain((0..half).rev().map(|step| at(step, 1.0))).collect()
    }

    #[test]
    fn polygons_of_many_corners_are_covered_once() {
        for count in [500, 1000] {
            let corners = spiral(count);
            let areas = areas(&corners);
            let whole: f64 = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a.cross(*b).z / 2.0).sum();
            assert!(areas.iter().all(|area| *area >= 0.0), "{count}");
            assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-9 * whole, "{count}");
        }
        let refused = triangulate(&spiral(MOST_CORNERS + 2), |_| panic!("nothing is cut"));
        assert_eq!(refused, Err(TooIntricate { corners: MOST_CORNERS + 2 }));
        // A convex one may have any number.
        let round = |step: usize| DVec3::new((step as f64 * 1e-4).cos(), (step as f64 * 1e-4).sin(), 0.0);
        assert_eq!(triangles(&(0..40_000).map(round).collect::<Vec<_>>()).len(), 39_998);
    }

    #[test]
    fn a_comb_is_covered_once_in_any_plane() {
        let comb = [
            [0., 0.],
            [5., 0.],
            [5., 3.],
            [4., 3.],
            [4., 1.],
            [3., 1.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ];
        // 5 × 1 for the back, and 1 × 2 for each of three teeth.
        for place in [|x, y| DVec3::new(x, y, 0.0), |x, y| DVec3::new(0.0, x, y), |x, y| DVec3::new(y, 0.0, x)] {
            let corners = comb.map(|[x, y]| place(x, y));
            let normal = place(1.0, 0.0).cross(place(0.0, 1.0));
            let area = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(normal) / 2.0;
            let areas: Vec<f64> = triangles(&corners).into_iter().map(area).collect();
            assert_eq!(areas.len(), 10);
            assert!(areas.iter().all(|area| *area > 0.0), "{areas:?}");
            assert_eq!(areas.iter().sum::<f64>(), 11.0);
        }
    }

    proptest! {
        #[test]
        fn any_corners_give_two_triangles_fewer(corners in prop::collection::vec(prop::array::uniform3(-2_i8..3), 3..40)) {
            let corners: Vec<DVec3> = corners.into_iter().map(|corner| DVec3::from_array(corner.map(f64::from))).collect();
            prop_assert_eq!(triangles(&corners).len(), corners.len() - 2);
        }
    }
}
