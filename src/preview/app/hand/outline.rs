//! The outline of a body in the picture. It is found by rays, so it works for any shape.

use crate::scene::BodyId;
use crate::world::{Ray, World};
use glam::DVec3;

/// How many cells the longer side of the searched area has.
const CELLS: usize = 96;
/// How often the distance between two rays, of which one meets the body, is halved.
const HALVINGS: u32 = 7;
/// How much larger than the box around the body the searched area is.
const MARGIN: f64 = 0.02;

/// An outline.
#[derive(Debug, Clone, Default)]
pub(in crate::preview::app) struct Outline {
    /// Pieces of the line, in points of the image plane.
    pub(in crate::preview::app) pieces: Vec<[[f64; 2]; 2]>,
    /// Whether the body reaches beyond the picture.
    pub(in crate::preview::app) beyond: bool,
}

/// The part of the image plane in which a body is searched: its low and its high corner.
fn searched(world: &World, body: BodyId, aspect: f64) -> Option<[[f64; 2]; 2]> {
    let (camera, bounds) = (&world.scene().camera, world.bounds(body));
    let corners = (0..8).map(|corner| {
        let pick = |bit: i32, low: f64, high: f64| if corner >> bit & 1 == 1 { high } else { low };
        let [x, y, z] = [0, 1, 2].map(|axis| pick(axis as i32, bounds.low[axis], bounds.high[axis]));
        camera.project(DVec3::new(x, y, z))
    });
    let whole = [[-aspect, -1.0], [aspect, 1.0]];
    // A box that begins behind the camera may be anywhere.
    let Some(corners) = corners.collect::<Option<Vec<_>>>() else { return Some(whole) };
    let mut found = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for corner in corners {
        for axis in 0..2 {
            found[0][axis] = found[0][axis].min(corner[axis]);
            found[1][axis] = found[1][axis].max(corner[axis]);
        }
    }
    let margin = MARGIN * (found[1][0] - found[0][0]).max(found[1][1] - found[0][1]);
    for axis in 0..2 {
        found[0][axis] = (found[0][axis] - margin).max(whole[0][axis]);
        found[1][axis] = (found[1][axis] + margin).min(whole[1][axis]);
    }
    (found[0][0] < found[1][0] && found[0][1] < found[1][1]).then_some(found)
}

impl Outline {
    /// The outline of a body in a picture of this width divided by its height.
    pub(in crate::preview::app) fn of(world: &World, body: BodyId, aspect: f64) -> Self {
        let Some([low, high]) = searched(world, body, aspect) else { return Self::default() };
        let camera = &world.scene().camera;
        let meets = |[x, y]: [f64; 2]| {
            let ray = Ray { origin: camera.position(), direction: camera.direction(x, y), leaves: None };
            world.intersect(&ray, body).is_some()
        };
        let sides = [high[0] - low[0], high[1] - low[1]];
        let step = sides[0].max(sides[1]) / CELLS as f64;
        let counts = sides.map(|side| ((side / step).ceil() as usize).max(1));
        let at = |column: usize, row: usize| {
            let along = |axis: usize, index: usize| low[axis] + sides[axis] * index as f64 / counts[axis] as f64;
            [along(0, column), along(1, row)]
        };
        let inside: Vec<Vec<bool>> =
            (0..=counts[1]).map(|row| (0..=counts[0]).map(|column| meets(at(column, row))).collect()).collect();
        // Where the line crosses the edge between two corners of a cell.
        let crossing = |one: (usize, usize), other: (usize, usize)| {
            let (mut one_inside, other_inside) = (inside[one.1][one.0], inside[other.1][other.0]);
            if one_inside == other_inside {
                return None;
            }
            let (mut one, mut other) = (at(one.0, one.1), at(other.0, other.1));
            if !one_inside {
                std::mem::swap(&mut one, &mut other);
                one_inside = true;
            }
            for _ in 0..HALVINGS {
                let middle = [0, 1].map(|axis| 0.5 * (one[axis] + other[axis]));
                if meets(middle) == one_inside { one = middle } else { other = middle }
            }
            // Not an end of the edge, which other edges have too.
            Some([0, 1].map(|axis| 0.5 * (one[axis] + other[axis])))
        };
        let mut pieces = Vec::new();
        for row in 0..counts[1] {
            for column in 0..counts[0] {
                let corners = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)];
                let crossings: Vec<_> = (0..4).filter_map(|edge| crossing(corners[edge], corners[(edge + 1) % 4])).collect();
                pieces.extend(crossings.chunks_exact(2).map(|two| [two[0], two[1]]));
            }
        }
        let edge = |axis: usize, index: usize| {
            let [x, y] = at(index * counts[0], index * counts[1]);
            let coordinate = [x, y][axis].abs();
            coordinate >= [aspect, 1.0][axis] - 1e-9
        };
        let beyond = (0..2).any(|end| {
            let rows = edge(1, end) && inside[end * counts[1]].iter().any(|inside| *inside);
            let columns = edge(0, end) && inside.iter().any(|row| row[end * counts[0]]);
            rows || columns
        });
        Self { pieces, beyond }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::scene::Scene;
    use crate::world::Assets;

    fn world(bodies: &str) -> World {
        let camera = "camera; position <0, 0, 0>; gaze <0, 0, -1>; up <0, 1, 0>; fov 90;";
        let scene = Scene::parse(&Source::new("scene", format!("bodies; {bodies} lights; {camera}"))).unwrap().0;
        World::new(scene, &Assets::NONE).unwrap()
    }

    #[test]
    fn a_sphere_in_the_middle_has_a_circle() {
        let world = world("s: sphere, center <0, 0, -5>, radius 3;");
        let outline = Outline::of(&world, BodyId(0), 1.5);
        // The tangent of the angle whose sine is 3/5.
        let radius = 0.75;
        assert!(outline.pieces.len() > 100 && !outline.beyond);
        for [x, y] in outline.pieces.iter().flatten() {
            assert!((x.hypot(*y) - radius).abs() < 1e-3, "{x} {y}");
        }
        // It is closed: each end is where another piece begins.
        let ends: Vec<[f64; 2]> = outline.pieces.iter().flatten().copied().collect();
        assert!(ends.iter().all(|end| ends.iter().filter(|other| *other == end).count() == 2));
        let round: f64 = outline.pieces.iter().map(|[one, other]| (one[0] - other[0]).hypot(one[1] - other[1])).sum();
        assert!((round - std::f64::consts::TAU * radius).abs() < 0.01, "{round}");
    }

    #[test]
    fn bodies_beyond_the_picture_are_known() {
        let bodies = "floor: rectangle, <-50, -1, -50>, <50, -1, -50>, <50, -1, 50>;
            card: rectangle, <-1, -1, -2>, <-1, 1, -2>, <1, 1, -2>;
            behind: sphere, center <0, 0, 5>, radius 1; side: sphere, center <12, 0, -5>, radius 1;
            edge: sphere, center <7.5, 0, -5>, radius 1;";
        let world = world(bodies);
        let outlines = [0, 1, 2, 3, 4].map(|id| Outline::of(&world, BodyId(id), 1.5));
        assert_eq!(outlines.each_ref().map(|outline| outline.beyond), [true, false, false, false, true]);
        assert_eq!(outlines.each_ref().map(|outline| outline.pieces.is_empty()), [false, false, true, true, false]);
        assert!(outlines[1].pieces.iter().flatten().all(|[x, y]| (x.abs().max(y.abs()) - 0.5).abs() < 0.02));
    }
}
