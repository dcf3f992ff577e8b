//! Normals of vertices, for smooth meshes whose file has none.

use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use crate::mesh::weld::WeldedPositions;
use glam::{DVec3, Vec3};

/// The normal of a triangle of clockwise corners: unit length, towards the front; `None` where the triangle has no
/// area. Edges may have any length that coordinates allow.
pub(super) fn front_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (ab, ac) = (b - a, c - a);
    let scaled = |edge: DVec3| (edge.abs().max_element() > 0.0).then(|| edge / edge.abs().max_element());
    let cross = scaled(ac)?.cross(scaled(ab)?);
    cross.try_normalize()
}

/// A unit normal for each vertex: the mean of the normals of its triangles, weighted by the angles that they have at
/// the vertex (Thürmer and Wüthrich, "Computing vertex normals from polygonal facets", 1998). Vertices at one position
/// have one normal, whatever their texture coordinates are. No triangle may be without area.
pub(super) fn angle_weighted(positions: &[DVec3], triangles: &[[u32; 3]], ledger: &mut Ledger) -> Result<Vec<Vec3>, Fault> {
    let mut different = WeldedPositions::new(ledger)?;
    let mut places = Vec::new();
    ledger.reserve(&mut places, positions.len())?;
    for position in positions {
        places.push(different.index(*position, ledger)?);
    }
    let count = different.into_list(ledger).len();
    let mut sums = Vec::new();
    ledger.reserve(&mut sums, count)?;
    sums.resize(count, DVec3::ZERO);
    // For vertices whose triangles cancel each other out.
    let mut first = Vec::new();
    ledger.reserve(&mut first, count)?;
    first.resize(count, Vec3::ZERO);
    for triangle in triangles {
        let corners = triangle.map(|vertex| positions[vertex as usize]);
        let Some(normal) = front_normal(corners) else { continue };
        for (corner, vertex) in triangle.iter().enumerate() {
            let place = places[*vertex as usize] as usize;
            let [own, next, last] = [0, 1, 2].map(|step| corners[(corner + step) % 3]);
            sums[place] += angle(next - own, last - own) * normal;
            if first[place] == Vec3::ZERO {
                first[place] = normal.as_vec3();
            }
        }
    }
    let mut normals = Vec::new();
    ledger.reserve(&mut normals, positions.len())?;
    for place in &places {
        let sum = sums[*place as usize];
        // Rounding leaves a little of normals that cancel out.
        let normal = if sum.length() > 1e-9 { sum.normalize().as_vec3() } else { first[*place as usize] };
        normals.push(normal);
    }
    ledger.release(places);
    ledger.release(sums);
    ledger.release(first);
    Ok(normals)
}

/// The angle between two directions, in radians; 0 where one of them is 0.
fn angle(one: DVec3, other: DVec3) -> f64 {
    match (one.try_normalize(), other.try_normalize()) {
        // Exact for small angles too.
        (Some(one), Some(other)) => one.cross(other).length().atan2(one.dot(other)),
        (None, _) | (_, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ledger::Reading;
    use std::sync::atomic::AtomicBool;

    fn normals(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<Vec3> {
        let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
        let positions: Vec<DVec3> = positions.iter().copied().map(DVec3::from_array).collect();
        angle_weighted(&positions, triangles, &mut Ledger::new(&reading)).unwrap()
    }

    #[test]
    fn the_corner_of_a_cube_does_not_depend_on_the_diagonals() {
        // The sides of the corner (0,0,0) of a cube: x = 0 of two triangles, y = 0 and z = 0 of one each.
        let positions = [[0., 0., 0.], [0., 1., 0.], [0., 1., 1.], [0., 0., 1.], [1., 0., 0.]];
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
        let corner = normals(&positions, &triangles)[0];
        let expected = Vec3::splat(1.0 / 3.0_f32.sqrt());
        assert!((corner.abs() - expected).length() < 1e-6, "{corner}");
        let towards = front_normal([[0., 0., 0.], [0., 1., 0.], [0., 1., 1.]].map(DVec3::from_array)).unwrap();
        assert_eq!(corner.x.signum(), towards.x.signum() as f32);
    }

    #[test]
    fn clockwise_corners_face_the_viewer() {
        // Seen from +z, the corners go clockwise: up, right, back.
        let corners = [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.]].map(DVec3::from_array);
        assert_eq!(front_normal(corners), Some(DVec3::Z));
        assert_eq!(front_normal(corners.map(|corner| corner * 1e-30)), Some(DVec3::Z));
        assert_eq!(front_normal([corners[0], corners[1], corners[1] * 2.0]), None);
    }

    #[test]
    fn vertices_at_one_position_share_a_normal() {
        // A ridge along y, whose sides have vertices of their own.
        let positions = [[0., 0., 1.], [0., 1., 1.], [1., 0., 0.], [0., 0., 1.], [0., 1., 1.], [-1., 0., 0.]];
        let found = normals(&positions, &[[0, 1, 2], [3, 5, 4]]);
        assert_eq!(found[0], found[3]);
        assert!(found[0].x.abs() < 1e-6 && found[0].z > 0.99, "{}", found[0]);
        assert!(found[2].x > 0.7);
    }

    #[test]
    fn sheets_back_to_back_still_have_unit_normals() {
        let found = normals(&[[0., 0., 0.], [0., 1., 0.], [1., 0., 0.]], &[[0, 1, 2], [0, 2, 1]]);
        assert_eq!(found, [Vec3::Z; 3]);
    }
}
