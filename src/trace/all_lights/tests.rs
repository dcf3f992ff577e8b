//! The hits for all lights say what the trees of rays say, whenever they are made; and their memory is foreseen.

use super::*;
use crate::trace::tests::{bright_room, room, traced, view};
use crate::trace::{Budget, Child, Estimate, Shortage, TraceError, Tree, ray_tree, trace};
use EvaluatedLights::{All, Reaching};
use std::sync::atomic::AtomicBool;

fn traced_for_all(world: &Arc<World>, view: &View) -> Hits {
    trace(world, view, All, &Budget::UNLIMITED, &|_| {}, &AtomicBool::new(false)).unwrap()
}

#[test]
fn every_light_stands_at_every_hit_with_its_visibility() {
    for (world, view) in [(room(1.0), view(120, 90, 5)), (bright_room(10), view(80, 60, 4))] {
        let hits = Arc::new(traced(&world, &view));
        let all = hits.for_lights(All).unwrap();
        let tracer = Tracer::new(&world, &view);
        let trees: Vec<Tree> = (0..view.pixels()).map(|pixel| ray_tree(&tracer, pixel, All)).collect();
        let emitters: Vec<EmitterId> = world.emitter_ids().collect();
        // Visible or not, for lights before and behind the surface.
        let mut kinds = [[0; 2]; 2];
        for tile in &all.tiles {
            assert!(tile.groups.is_sorted_by(|a, b| a.body < b.body), "a group for each body");
            for group in &tile.groups {
                assert_eq!((&*group.emitters, group.scattered), (&*emitters, false));
                replay(&tracer, tile, group, group.hits.clone(), |hit, key, surface| {
                    let tree = &trees[key.pixel as usize];
                    let node = tree.nodes.iter().find(|node| node.hit == *surface).unwrap();
                    for light in &node.lights {
                        assert_eq!(tile.is_visible(hit, light.emitter), light.visible);
                        kinds[usize::from(tracer.faces(light.emitter, surface, key))][usize::from(light.visible)] += 1;
                        let reaches = tracer.reaches(light.emitter, surface, key);
                        assert_eq!(reaches, light.visible && tracer.faces(light.emitter, surface, key));
                    }
                })
                .unwrap();
            }
        }
        assert!(kinds.iter().flatten().all(|count| *count > 100), "{kinds:?}");
        let nodes: u64 = trees.iter().map(|tree| tree.nodes.len() as u64).sum();
        let (counts, before) = (all.counts(), hits.counts());
        assert_eq!((counts.hits, counts.records), (nodes, nodes * emitters.len() as u64));
        assert_eq!((counts.hits, counts.misses, counts.paths), (before.hits, before.misses, before.paths));
        assert!(trees.iter().all(|tree| !matches!(tree.primary, Child::None)));
    }
}

#[test]
fn it_does_not_matter_when_they_are_made() {
    for (world, view) in [(room(1.0), view(120, 90, 5)), (bright_room(10), view(80, 60, 4))] {
        let (small, large) = (Arc::new(traced(&world, &view)), Arc::new(traced_for_all(&world, &view)));
        assert!(!small.serves(All) && large.serves(All) && small.serves(Reaching));
        let before = small.bytes();
        assert_eq!(small.tiles, large.tiles);
        assert_eq!(small.for_lights(All).unwrap().tiles, large.for_lights(All).unwrap().tiles);
        assert!(Arc::ptr_eq(&small.for_lights(All).unwrap(), &small.for_lights(All).unwrap()), "they are kept");
        assert!(Arc::ptr_eq(&large.for_lights(Reaching).unwrap(), &large));
        assert_eq!((small.bytes(), small.serves(All)), (large.bytes(), true));
        assert!(small.bytes() > before);
        assert_eq!(small.for_lights(All).unwrap().for_lights(Reaching).err(), Some(Mismatch));
    }
}

#[test]
fn the_same_hits_serve_where_every_light_reaches_every_hit() {
    let world = room(1.0);
    let hits = Arc::new(traced_for_all(&world, &view(40, 30, 3).with_shadows(false)));
    assert!(hits.serves(All));
    assert!(Arc::ptr_eq(&hits.for_lights(All).unwrap(), &hits));
    assert!(hits.tiles.iter().all(|tile| tile.visibility.is_none() && tile.is_visible(0, EmitterId(0))));
}

#[test]
fn without_shadow_rays_a_light_that_sends_nothing_is_at_every_hit_too() {
    let world = crate::trace::tests::world(
        "bodies; floor: rectangle, <-9, 0, -9>, <9, 0, -9>, <9, 0, 9>;
         lights; beam: spot, <0, 5, 0>, target <0, 0, 0>, angle 20; key: point, <1, 7, 3>;
         camera; position <0, 5, 9>; gaze <0, -0.5, -1>; up <0, 1, 0>; fov 45;",
    );
    let view = view(40, 30, 3).with_shadows(false);
    let hits = Arc::new(traced(&world, &view));
    assert!(!hits.serves(All) && hits.counts().records < 2 * hits.counts().hits, "the cone is small");
    let all = hits.for_lights(All).unwrap();
    assert_eq!(all.counts().records, 2 * hits.counts().hits);
    for tile in &all.tiles {
        let of_group = |group: &crate::trace::Group| group.hits.clone().all(|hit| tile.is_visible(hit, EmitterId(0)));
        assert!(tile.groups.iter().all(of_group), "`visible` is 1 where no shadow rays are sent");
    }
}

#[test]
fn the_memory_of_all_records_and_of_both_stores_is_foreseen_and_counted() {
    let (world, view) = (bright_room(10), view(160, 120, 4));
    let budget = Budget { bytes_per_record: 8, bytes_per_hit: 4, ..Budget::UNLIMITED };
    let estimate = |lights| Estimate::new(&world, &view, lights, &AtomicBool::new(false)).unwrap();
    let hits = traced_for_all(&world, &view);
    let counts = hits.counts();
    let taken = hits.bytes() + counts.hits * (4 + 12 * 8);
    let foreseen = estimate(All).bytes(&budget);
    // The sample of pixels is small. Apart from that, the estimate is near, and not below: what the stores take for a
    // hit is less in such a small scene.
    let sampled = counts.hits as f64 / estimate(All).hits as f64;
    let near = |bytes: u64, scale: f64| {
        let ratio = scale * bytes as f64 / taken as f64;
        assert!((1.0..1.3).contains(&ratio), "{bytes} for {taken}");
    };
    near(foreseen, sampled);
    assert_eq!(estimate(All).hits, estimate(Reaching).hits);
    assert!(estimate(All).records > 3 * estimate(Reaching).records / 2);
    // Between both estimates, formulas that read `visible` are refused, before tracing or before they are prepared.
    let tight = Budget { bytes: (foreseen + estimate(Reaching).bytes(&budget)) / 2, ..budget };
    let traced_within = |lights| trace(&world, &view, lights, &tight, &|_| {}, &AtomicBool::new(false));
    let small = traced_within(Reaching).unwrap();
    assert!(tight.check_hits(&small, Reaching).is_ok());
    for (refused, scale) in [(traced_within(All).err(), sampled), (tight.check_hits(&small, All).err(), 1.0)] {
        let Some(TraceError::Memory(Shortage { needed, .. })) = refused else { panic!("{refused:?}") };
        near(needed, scale);
    }
    // The count while tracing exceeds what is taken.
    let counted = Budget { bytes: taken - 1, ..budget };
    assert!(trace(&world, &view, All, &counted, &|_| {}, &AtomicBool::new(false)).is_err());
}
