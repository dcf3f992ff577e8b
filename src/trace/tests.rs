//! What is true of every traced picture: the store says what the trees of rays say, replaying it gives the same bits,
//! and neither scale nor threads matter.

use super::*;
use crate::bvh::MeshTree;
use crate::lang::source::Source;
use crate::mesh::{MeshParts, Reading, TriangleMesh};
use crate::scene::light::PointLight;
use crate::scene::{BodyId, Light, LightKind, Scene};
use crate::world::{Assets, EmitterId, MeshKey};
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Mutex;

/// The scene that this text describes.
fn scene(text: &str) -> Scene {
    let source = Source::new("scene", text);
    Scene::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source))).0
}

/// The world that this text describes.
pub(super) fn world(text: &str) -> Arc<World> {
    Arc::new(World::new(scene(text), &Assets::NONE).unwrap())
}

/// A glass ball and a metal one on a floor before a mirror, two lamps; everything `scale` times as large.
pub(super) fn room(scale: f64) -> Arc<World> {
    let at = |x: f64, y: f64, z: f64| format!("<{:e}, {:e}, {:e}>", scale * x, scale * y, scale * z);
    world(&format!(
        "bodies;
         glass: sphere, center {}, radius {:e}, refractive_index 1.52;
         metal: sphere, center {}, radius {:e}, opaque;
         floor: rectangle, {}, {}, {}, opaque;
         mirror: rectangle, {}, {}, {}, opaque;
         chalk: sphere, center {}, radius {:e}, opaque, matte;
         lights;
         key: point, {};
         fill: point, {};
         camera;
         position {}; gaze <0, -0.12, -1>; up <0, 1, 0>; fov 50;",
        at(-1.0, 1.0, 0.3),
        scale,
        at(1.2, 0.8, -0.4),
        0.8 * scale,
        at(-4.0, 0.0, 4.0),
        at(-4.0, 0.0, -3.0),
        at(4.0, 0.0, -3.0),
        at(-3.0, 0.0, -2.9),
        at(-3.0, 3.0, -2.9),
        at(3.0, 3.0, -2.9),
        at(0.3, 0.25, 1.4),
        0.25 * scale,
        at(3.0, 5.0, 4.0),
        at(-4.0, 3.0, 2.0),
        at(0.0, 1.6, 6.0),
    ))
}

/// The same room with a block and a wedge of glass in it, which are meshes.
pub(super) fn room_with_meshes() -> Arc<World> {
    let mut scene = Scene::clone(room(1.0).scene());
    let more = scene_of_meshes();
    scene.bodies.extend(more.bodies.iter().cloned());
    let corner = |at: u32| DVec3::new(f64::from(at & 1), f64::from(at >> 1 & 1), f64::from(at >> 2));
    let cube = MeshParts {
        positions: (0..8).map(corner).collect(),
        triangles: vec![
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
        ],
        ..MeshParts::default()
    };
    let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
    let mut assets = Assets::NONE;
    for body in &more.bodies {
        let (mesh, _) = TriangleMesh::new("cube", cube.clone(), &reading).unwrap();
        let mesh = mesh.smooth("cube", &reading).unwrap();
        assets.meshes.insert(MeshKey::of(body).unwrap(), Arc::new(MeshTree::new(Arc::new(mesh), &|_| true).unwrap()));
    }
    Arc::new(World::new(scene, &assets).unwrap())
}

fn scene_of_meshes() -> Scene {
    scene(
        "bodies;
         block: mesh, \"cube.obj\", flat, scale <0.6, 0.9, 0.4>, rotate <1, 2, 3> 40, translate <0, 0.4, 1.8>, refractive_index 1.4;
         wedge: mesh, \"cube.obj\", smooth, scale 0.7, rotate <0, 1, 0> 25, translate <1.4, 0.1, 1.2>;
         lights; camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 50;",
    )
}

/// The same room, with this many more lamps around it.
pub(super) fn bright_room(lamps: u32) -> Arc<World> {
    let mut scene = Scene::clone(room(1.0).scene());
    for lamp in 0..lamps {
        let (z, x) = (1.3 + std::f64::consts::TAU * f64::from(lamp) / f64::from(lamps)).sin_cos();
        let kind = LightKind::Point(PointLight::new([5.0 * x, 4.0, 5.0 * z].into()));
        scene.lights.push(Light { name: format!("lamp{lamp}"), kind, ..scene.lights[0].clone() });
    }
    Arc::new(World::new(scene, &Assets::NONE).unwrap())
}

/// The emitters for which a formula is evaluated at a hit.
pub(super) fn emitters(node: &RayNode) -> Vec<EmitterId> {
    node.lights.iter().map(|light| light.emitter).collect()
}

pub(super) fn view(width: u32, height: u32, depth: u32) -> View {
    View::new(width, height).unwrap().with_depth(depth).unwrap()
}

pub(super) fn traced(world: &Arc<World>, view: &View) -> Hits {
    trace(world, view, EvaluatedLights::Reaching, &Budget::UNLIMITED, &|_| {}, &AtomicBool::new(false)).unwrap()
}

/// The ray of a tree at the end of a path.
fn child_at(tree: &Tree, steps: &[(PathId, Edge, Option<BodyId>)]) -> Child {
    let mut at = tree.primary;
    for (_, edge, _) in steps {
        at = match (edge, at) {
            (Edge::Primary, primary) => primary,
            (Edge::Reflected, Child::Hit(node)) => tree.nodes[node].reflected,
            (Edge::Refracted, Child::Hit(node)) => tree.nodes[node].refracted,
            (_, Child::None | Child::Miss(_)) => panic!("a path over a ray that does not exist"),
        };
    }
    at
}

/// The pixels of some segments, counted from the tile's first.
fn pixels_of(segments: &[Segment]) -> impl Iterator<Item = usize> {
    segments.iter().flat_map(|segment| segment.pixels())
}

#[test]
fn store_and_replay_are_what_the_trees_say_bit_for_bit() {
    let (room, bright, meshes) = (room(1.0), bright_room(10), room_with_meshes());
    for (world, view) in [
        (&room, view(160, 120, 5)),
        (&room, view(40, 30, 9).with_pass(3)),
        (&room, view(40, 30, 4).with_shadows(false)),
        (&bright, view(80, 60, 5)),
        (&meshes, view(80, 60, 6)),
    ] {
        let hits = traced(world, &view);
        let mut scattered: BTreeMap<(u32, usize), Vec<EmitterId>> = BTreeMap::new();
        let tracer = Tracer::new(world, &view);
        let trees: Vec<Tree> = (0..view.pixels()).map(|pixel| ray_tree(&tracer, pixel, EvaluatedLights::Reaching)).collect();
        let mut seen = 0;
        for tile in &hits.tiles {
            for group in &tile.groups {
                let mut last = None;
                replay(&tracer, tile, group, group.hits.clone(), |hit, key, surface| {
                    assert_eq!(hit, last.map_or(group.hits.start, |last: u32| last + 1));
                    last = Some(hit);
                    let span = tile.spans_of(group).iter().find(|span| span.hits.contains(&hit)).unwrap();
                    let pixel_in_tile = pixels_of(tile.segments_of(span)).nth((hit - span.hits.start) as usize).unwrap();
                    assert_eq!(key.pixel as usize, tile.pixels.start as usize + pixel_in_tile);
                    let tree = &trees[key.pixel as usize];
                    let Child::Hit(node) = child_at(tree, &tile.steps(span.path)) else { panic!("no hit") };
                    if group.scattered {
                        scattered.entry((key.pixel, node)).or_default().extend(&group.emitters);
                    }
                    let node = &tree.nodes[node];
                    assert_eq!((node.hit, node.key), (*surface, *key));
                    assert_eq!(node.hit.body, group.body);
                    if !group.scattered {
                        assert_eq!(emitters(node), *group.emitters);
                    }
                    seen += 1;
                })
                .unwrap();
            }
            for span in &tile.misses {
                let mut pixels = pixels_of(tile.miss_segments_of(span));
                replay_misses(&tracer, tile, span, |pixel, direction| {
                    assert_eq!(Some((pixel - tile.pixels.start) as usize), pixels.next());
                    // The same bits, too: directions are compared, not points.
                    assert_eq!(child_at(&trees[pixel as usize], &tile.steps(span.path)), Child::Miss(direction));
                })
                .unwrap();
                assert_eq!(pixels.next(), None);
            }
        }
        let nodes: usize = trees.iter().map(|tree| tree.nodes.len()).sum();
        let misses = |tree: &Tree| {
            let children = tree.nodes.iter().flat_map(|node| [node.reflected, node.refracted]);
            children.chain([tree.primary]).filter(|child| matches!(child, Child::Miss(_))).count()
        };
        // Scattered hits are once in a group of each of their lights.
        for ((pixel, node), lights) in &scattered {
            assert_eq!(emitters(&trees[*pixel as usize].nodes[*node]), **lights);
        }
        assert_eq!(scattered.is_empty(), world.scene().lights.len() < 10);
        let copies: u32 = hits.tiles.iter().map(|tile| tile.copies).sum();
        assert_eq!(copies as usize, scattered.values().map(|lights| lights.len() - 1).sum::<usize>());
        assert_eq!(seen, nodes + copies as usize);
        assert_eq!(hits.counts().hits, nodes as u64);
        assert_eq!(hits.counts().misses, trees.iter().map(misses).sum::<usize>() as u64);
        let records: usize = trees.iter().flat_map(|tree| &tree.nodes).map(|node| node.lights.len()).sum();
        assert_eq!(hits.counts().records, records as u64);
    }
}

#[test]
fn a_part_of_a_group_replays_as_in_the_whole() {
    let (world, view) = (room(1.0), view(80, 60, 5));
    let hits = traced(&world, &view);
    let tracer = Tracer::new(&world, &view);
    let tile = hits.tiles.iter().max_by_key(|tile| tile.spans.len()).unwrap();
    let group = tile.groups.iter().max_by_key(|group| group.spans.len()).unwrap();
    let collect = |range: Range<u32>| {
        let mut all = Vec::new();
        replay(&tracer, tile, group, range, |lane, _, surface| all.push((lane, *surface))).unwrap();
        all
    };
    let whole = collect(0..u32::MAX);
    assert_eq!(whole.len(), group.hits.len());
    for cut in [1, 5, group.hits.len() as u32 / 3] {
        let middle = group.hits.start + cut..group.hits.end - cut;
        let within: Vec<_> = whole.iter().filter(|(hit, _)| middle.contains(hit)).copied().collect();
        assert_eq!(collect(middle), within);
    }
    assert!(collect(group.hits.end..group.hits.end).is_empty());
}

#[test]
fn a_store_of_another_scene_is_noticed() {
    let (world, view) = (room(1.0), view(40, 30, 3));
    let hits = traced(&world, &view);
    let mut other = Scene::clone(world.scene());
    other.camera =
        crate::scene::Camera::new([0.0, 100.0, 0.0].into(), [0.0, 1.0, 0.0].into(), [1.0, 0.0, 0.0].into(), 45.0).unwrap();
    let other = World::new(other, &Assets::NONE).unwrap();
    let (tracer, tile) = (Tracer::new(&other, &view), &hits.tiles[0]);
    assert_eq!(replay(&tracer, tile, &tile.groups[0], 0..u32::MAX, |_, _, _| {}), Err(Mismatch));
    let after_a_hit = tile.misses.iter().find(|span| tile.steps(span.path).len() > 1).unwrap();
    assert_eq!(replay_misses(&tracer, tile, after_a_hit, |_, _| {}), Err(Mismatch));
}

#[test]
fn groups_and_spans_are_in_order_and_complete() {
    let hits = traced(&room(1.0), &view(200, 150, 5));
    // 1875 pixels would make 16 tiles; they have the next multiple of 256.
    assert_eq!(hits.tiles.len(), 15);
    assert_eq!(hits.tiles.last().unwrap().pixels.end, 30_000);
    for tile in &hits.tiles {
        assert!(tile.paths.iter().enumerate().all(|(id, path)| path.parent.is_none_or(|parent| parent.index() < id)));
        assert!(tile.groups.is_sorted_by(|a, b| (a.body, &a.emitters, a.scattered) < (b.body, &b.emitters, b.scattered)));
        let mut next = (0, 0);
        for span in tile.groups.iter().flat_map(|group| {
            let spans = tile.spans_of(group);
            assert_eq!(group.hits, spans[0].hits.start..spans[spans.len() - 1].hits.end);
            // A path goes on in another span only in the next chunk.
            let chunk = |hit: u32| (hit - group.hits.start) as usize / CHUNK_HITS;
            assert!(spans.iter().all(|span| chunk(span.hits.start) == chunk(span.hits.end - 1)));
            let begins = |span: &Span| ((span.hits.start - group.hits.start) as usize).is_multiple_of(CHUNK_HITS);
            assert!(spans.is_sorted_by(|a, b| a.path < b.path || a.path == b.path && begins(b)));
            spans
        }) {
            assert_eq!((span.hits.start, span.segments.start), next);
            next = (span.hits.end, span.segments.end);
            assert_eq!(span.hits.len(), pixels_of(tile.segments_of(span)).count());
            let group = tile.groups.iter().find(|group| group.hits.contains(&span.hits.start)).unwrap();
            let mut hit = (span.hits.start - group.hits.start) as usize;
            for segment in tile.segments_of(span) {
                // Its hits follow those before, in one chunk.
                assert_eq!(segment.first_hit(), hit % CHUNK_HITS);
                assert!(segment.first_hit() + segment.hits() <= CHUNK_HITS);
                hit += segment.hits();
            }
            assert!(pixels_of(tile.segments_of(span)).is_sorted_by(|a, b| a < b));
        }
        assert_eq!(next.1 as usize, tile.segments.len());
    }
    assert!(hits.bytes() < 8 * (hits.counts().hits + hits.counts().misses), "{} {:?}", hits.bytes(), hits.counts());
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let (world, view) = (room(1.0), view(256, 192, 5));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            (
                traced(&world, &view).tiles,
                Estimate::new(&world, &view, EvaluatedLights::Reaching, &AtomicBool::new(false)).unwrap(),
            )
        })
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn a_scene_looks_the_same_at_any_scale() {
    let view = view(64, 48, 7);
    let shape = |scale| -> Vec<(usize, usize)> {
        let world = room(scale);
        let tracer = Tracer::new(&world, &view);
        let trees = (0..view.pixels()).map(|pixel| ray_tree(&tracer, pixel, EvaluatedLights::Reaching));
        trees.map(|tree| (tree.nodes.len(), tree.nodes.iter().map(|node| node.lights.len()).sum())).collect()
    };
    let unit = shape(1.0);
    for scale in [1e-12, 1e-3, 1e-2, 1e-1, 10.0, 1e2, 1e3, 1e4, 1e12] {
        let scaled = shape(scale);
        let differing = (0..unit.len()).filter(|pixel| unit[*pixel] != scaled[*pixel]).count();
        assert_eq!(differing, 0, "at scale {scale:e}");
    }
}

#[test]
fn nothing_but_the_primary_rays_at_depth_one() {
    let hits = traced(&room(1.0), &view(64, 48, 1));
    assert_eq!(hits.counts().hits + hits.counts().misses, 64 * 48);
    assert!(hits.tiles[0].paths.iter().all(|path| path.edge == Edge::Primary && path.parent.is_none()));
}

#[test]
fn a_scene_without_bodies_is_all_background() {
    let empty = world("bodies; lights; camera; position <0,0,0>; gaze <0,0,-1>; up <0,1,0>; fov 45;");
    let hits = traced(&empty, &view(10, 10, 5));
    assert_eq!(hits.counts(), Counts { hits: 0, records: 0, paths: 1, groups: 0, misses: 100 });
    assert_eq!(hits.tiles[0].paths, [Path { parent: None, edge: Edge::Primary, body: None }]);
}

#[test]
fn hits_that_no_light_reaches_are_kept_for_the_ambient_light() {
    let dark = world(
        "bodies; s: sphere, center <0,0,-5>, radius 1, opaque, matte; lights;
         camera; position <0,0,0>; gaze <0,0,-1>; up <0,1,0>; fov 10;",
    );
    let hits = traced(&dark, &view(10, 10, 5));
    assert_eq!(hits.counts(), Counts { hits: 100, records: 0, paths: 1, groups: 1, misses: 0 });
    assert!(hits.tiles[0].groups[0].emitters.is_empty());
}

#[test]
fn the_estimate_is_near_the_truth() {
    let (world, view) = (room(1.0), view(320, 240, 5));
    let estimate = Estimate::new(&world, &view, EvaluatedLights::Reaching, &AtomicBool::new(false)).unwrap();
    let counts = traced(&world, &view).counts();
    for (foreseen, found) in [(estimate.hits, counts.hits), (estimate.records, counts.records), (estimate.misses, counts.misses)]
    {
        assert!((foreseen as f64 / found as f64 - 1.0).abs() < 0.05, "{foreseen} for {found}");
    }
    let tiny = Estimate::new(&world, &self::view(1, 1, 5), EvaluatedLights::Reaching, &AtomicBool::new(false)).unwrap();
    assert_eq!(tiny.hits, traced(&world, &self::view(1, 1, 5)).counts().hits);
}

#[test]
fn memory_beyond_the_budget_is_refused_beforehand_or_meanwhile() {
    let (world, view) = (room(1.0), view(320, 240, 5));
    let budget = Budget { bytes: 1 << 20, bytes_per_record: 64, bytes_per_hit: 16, bytes_per_pixel: 12, ..Budget::UNLIMITED };
    let refused =
        trace(&world, &view, EvaluatedLights::Reaching, &budget, &|_| panic!("it was foreseen"), &AtomicBool::new(false));
    let Err(error @ TraceError::Memory(Shortage { needed, pairs: 0, budget: 1_048_576, pixels: 76_800, .. })) = refused else {
        panic!("{refused:?}");
    };
    assert!(needed > 10 << 20 && needed < 40 << 20, "{needed}");
    assert!(error.to_string().contains("1.0 MiB may be used"), "{error}");
    // The estimate leaves out the tables of a tile; the meter does not.
    let estimate = Estimate::new(&world, &view, EvaluatedLights::Reaching, &AtomicBool::new(false)).unwrap();
    let tight = Budget { bytes: estimate.hits * 2, ..Budget::UNLIMITED };
    let meter = MemoryMeter::start(&tight, Estimate { hits: 1, ..Estimate::default() }).unwrap();
    assert!(meter.add(1, 0, tight.bytes).is_ok());
    assert!(matches!(meter.add(1, 0, 1), Err(TraceError::Memory(_))));
}

#[test]
fn progress_reaches_the_end_and_cancelling_ends_the_work() {
    let (world, view) = (room(1.0), view(320, 240, 3));
    let told = Mutex::new(Vec::new());
    trace(
        &world,
        &view,
        EvaluatedLights::Reaching,
        &Budget::UNLIMITED,
        &|share| told.lock().unwrap().push(share),
        &AtomicBool::new(false),
    )
    .unwrap();
    let told = told.into_inner().unwrap();
    assert_eq!(told.iter().copied().fold(0.0, f64::max), 1.0);
    assert!(told.iter().all(|share| (0.0..=1.0).contains(share)));
    let cancelled = AtomicBool::new(false);
    let stop = |_| cancelled.store(true, Ordering::Relaxed);
    assert_eq!(
        trace(&world, &view, EvaluatedLights::Reaching, &Budget::UNLIMITED, &stop, &cancelled).err(),
        Some(TraceError::Cancelled)
    );
    assert_eq!(
        trace(&world, &view, EvaluatedLights::Reaching, &Budget::UNLIMITED, &|_| {}, &cancelled).err(),
        Some(TraceError::Cancelled)
    );
}
