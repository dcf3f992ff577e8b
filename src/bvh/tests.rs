use super::{BodyTree, MeshTree, TriangleHit, intersect_triangle};
use crate::mesh::{MeshParts, Reading, TriangleMesh};
use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn tree(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> MeshTree {
    let cancelled = AtomicBool::new(false);
    let reading = Reading { memory: 1 << 30, progress: &|_| (), cancelled: &cancelled };
    let parts = MeshParts { positions, triangles, ..MeshParts::default() };
    MeshTree::new(Arc::new(TriangleMesh::new("test", parts, &reading).unwrap().0), &|_| true).unwrap()
}

/// What a ray meets first, by testing every triangle.
fn by_all(tree: &MeshTree, origin: DVec3, direction: DVec3) -> Option<TriangleHit> {
    let count = tree.mesh().triangles().len() as u32;
    let hits = (0..count).filter_map(|triangle| intersect_triangle(origin, direction, triangle, tree.corners(triangle)));
    let ahead = hits.filter(|hit| hit.distance > 0.0);
    ahead.min_by(|one, other| one.distance.total_cmp(&other.distance).then(one.triangle.cmp(&other.triangle)))
}

fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-reach..reach).prop_map(DVec3::from)
}

/// A hilly square of 2·n² triangles.
fn hills(n: u32) -> Arc<TriangleMesh> {
    let places = (0..=n).flat_map(|y| (0..=n).map(move |x| [x, y].map(f64::from)));
    let positions = places.map(|[x, y]| DVec3::new(x, y, 3.0 * (0.4 * x).sin() * (0.3 * y).cos())).collect();
    let corner = |x: u32, y: u32| y * (n + 1) + x;
    let squares =
        (0..n).flat_map(|y| (0..n).map(move |x| [corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)]));
    let triangles = squares.flat_map(|[a, b, c, d]| [[a, b, c], [b, d, c]]).collect();
    let parts = MeshParts { positions, triangles, ..MeshParts::default() };
    Arc::new(TriangleMesh::new("hills", parts, &Reading::unwatched(1 << 30)).unwrap().0)
}

#[test]
fn building_tells_its_progress_and_can_be_ended() {
    let mesh = hills(250);
    let told = std::cell::RefCell::new(Vec::new());
    let tell = |share: f64| {
        told.borrow_mut().push(share);
        true
    };
    assert!(MeshTree::new(Arc::clone(&mesh), &tell).is_some());
    let told = told.into_inner();
    assert!(told.len() >= 4 && told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
    // It can be ended each time.
    for end in 0..told.len() {
        let calls = std::cell::Cell::new(0);
        let stop = |_: f64| {
            calls.set(calls.get() + 1);
            calls.get() <= end
        };
        assert!(MeshTree::new(Arc::clone(&mesh), &stop).is_none(), "{end}");
        assert_eq!(calls.get(), end + 1, "nothing more is done");
    }
}

proptest! {
    #[test]
    fn a_tree_finds_what_a_test_of_all_triangles_finds(
        places in prop::collection::vec((vector(1.0), vector(0.2), vector(0.2)), 1..300),
        (origin, target) in (vector(3.0), vector(1.0)),
        scale in prop::sample::select(vec![1e-12, 1e-3, 1.0, 1e4, 1e25]),
        offset in vector(5.0),
        (flat, rounded) in any::<(bool, bool)>(),
    ) {
        // Leaves hold 24 bits exactly, unless the mesh is far from its origin.
        let stored = |at: DVec3| if rounded { at.as_vec3().as_dvec3() } else { at };
        let place = |at: DVec3| (if flat { at * DVec3::new(1.0, 1.0, 0.0) } else { at } + offset) * scale;
        let positions: Vec<DVec3> = places.iter().flat_map(|(at, one, other)| [*at, at + one, at + other]).map(place).map(stored).collect();
        let triangles = (0..places.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
        let tree = tree(positions, triangles);
        let (origin, target) = ((origin + offset) * scale, (target + offset) * scale);
        let direction = target - origin;
        let expected = by_all(&tree, origin, direction);
        prop_assert_eq!(tree.nearest(origin, direction, f64::INFINITY, |_| true), expected);
        prop_assert_eq!(tree.any(origin, direction, f64::INFINITY, |_| true), expected.is_some());
        if let Some(expected) = expected {
            prop_assert!(!tree.any(origin, direction, expected.distance, |_| true));
            let next = tree.nearest(origin, direction, f64::INFINITY, |hit| hit.triangle != expected.triangle);
            prop_assert!(next.is_none_or(|next| next.distance >= expected.distance && next.triangle != expected.triangle));
        }
    }

    #[test]
    fn rays_do_not_pass_between_triangles(size in 1usize..40, heights in any::<u64>(), targets in prop::collection::vec((0usize..1600, 0usize..3, 0.0..=1.0f64), 50), origin in vector(3.0)) {
        // A bumpy sheet of triangles, seen from above, where no edge is an outline. Rays go through edges and vertices.
        let height = |at: usize| 0.1 * ((heights.rotate_left(at as u32 * 7 % 64) & 0xff) as f64 / 256.0);
        let side = size + 1;
        let positions: Vec<DVec3> = (0..side * side).map(|at| DVec3::new((at % side) as f64 / 3.0, height(at), (at / side) as f64 / 7.0)).collect();
        let quads = (0..size * size).map(|quad| (quad / size * side + quad % size) as u32);
        let triangles: Vec<[u32; 3]> = quads.flat_map(|at| [[at, at + 1, at + side as u32], [at + 1, at + side as u32 + 1, at + side as u32]]).collect();
        let inner = |at: DVec3| {
            let (x, z) = (3.0 * at.x / size as f64, 7.0 * at.z / size as f64);
            x.min(z) > 1e-9 && x.max(z) < 1.0 - 1e-9
        };
        let tree = tree(positions, triangles);
        for (triangle, edge, share) in targets {
            let corners = tree.corners((triangle % (2 * size * size)) as u32);
            let target = corners[edge].lerp(corners[(edge + 1) % 3], share);
            if inner(target) {
                let origin = DVec3::new(origin.x, 30.0 + origin.y, origin.z);
                let hit = tree.nearest(origin, target - origin, f64::INFINITY, |_| true);
                prop_assert!(hit.is_some_and(|hit| hit.distance <= 1.0 + 1e-12), "{:?}", hit);
            }
        }
    }

    #[test]
    fn boxes_that_a_ray_meets_are_visited(boxes in prop::collection::vec((vector(1.0), vector(0.3)), 0..200), few in any::<bool>(), origin in vector(3.0), target in vector(1.0)) {
        let boxes: Vec<[DVec3; 2]> = boxes.into_iter().map(|(at, size)| [at.min(at + size), at.max(at + size)]).collect();
        let boxes = if few { &boxes[..boxes.len() / 7] } else { &boxes };
        let direction = (target - origin).normalize();
        for tree in [BodyTree::new(boxes), BodyTree::with_list_below(boxes, 0)] {
            let mut visited = Vec::new();
            tree.search(origin, direction, 2.0, |body| { visited.push(body); 2.0 });
            let mut tried = Vec::new();
            prop_assert_eq!(tree.any(origin, direction, 2.0, |body| { tried.push(body); false }), None);
            for (index, [low, high]) in boxes.iter().enumerate() {
                let (one, other) = ((*low - origin) / direction, (*high - origin) / direction);
                let (enter, leave) = (one.min(other).max_element().max(0.0), one.max(other).min_element().min(2.0));
                let is_found = visited.contains(&(index as u32)) && tried.contains(&(index as u32));
                prop_assert!(enter > leave || is_found);
            }
            visited.sort_unstable();
            tried.sort_unstable();
            prop_assert_eq!(&visited, &tried);
            visited.dedup();
            prop_assert_eq!(visited.len(), tried.len(), "each box comes once");
            let mut count = 0;
            let last = tried.last().copied();
            prop_assert_eq!(tree.any(origin, direction, 2.0, |body| { count += 1; Some(body) == last }), last);
            prop_assert!(count <= tried.len());
        }
    }
}
