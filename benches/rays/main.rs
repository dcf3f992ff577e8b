//! Time for a ray in a mesh: coherent primary rays, incoherent secondary rays and shadow rays, each on one thread, and
//! the time to build the tree on all threads.
//!
//! ```text
//! cargo bench --bench rays                                  # generated meshes of 7e4, 1e6 and 1e7 triangles
//! cargo bench --bench rays -- 70000 bunny.ply               # of this many triangles; of a file
//! cargo bench --bench rays -- balls                         # scenes of 10 to 1e5 balls instead
//! EMBREE=…/libembree4.so.4 cargo bench --bench rays         # beside Embree on the same rays, in its robust mode
//! EMBREE_ISA=avx2                                           # the instruction set that Embree may use (the default)
//! ILLUMINATOR_LANES=4                                       # without AVX2
//! ```

#![allow(clippy::panic, reason = "a benchmark that cannot go on has failed")]

mod balls;
mod embree;

use embree::{Embree, RayHit};
use glam::DVec3;
use illuminator::bvh::MeshTree;
use illuminator::mesh::{MeshParts, Reading, TriangleMesh, read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Primary rays are those of a square picture of this many pixels a side.
const SIDE: usize = 1024;
/// Times are the least of this many rounds.
const ROUNDS: usize = 7;

struct Rays {
    name: &'static str,
    occlusion: bool,
    rays: Vec<(DVec3, DVec3)>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let named = if arguments.is_empty() { vec!["70000".into(), "1000000".into(), "10000000".into()] } else { arguments };
    for name in named {
        if name == "balls" {
            (1..=5).for_each(|power| balls::measure(10_usize.pow(power)));
            continue;
        }
        let mesh = Arc::new(match name.parse::<f64>() {
            Ok(triangles) => generated(triangles),
            Err(_) => with_reading(|reading| read(Path::new(&name), reading)).unwrap_or_else(|error| panic!("{error:?}")).0,
        });
        compare(&name, &mesh);
    }
}

fn with_reading<T>(work: impl FnOnce(&Reading) -> T) -> T {
    let cancelled = AtomicBool::new(false);
    work(&Reading { memory: 64 << 30, progress: &|_| (), cancelled: &cancelled })
}

/// A lumpy ball: rounded boulders of several sizes, with about this many triangles.
fn generated(triangles: f64) -> TriangleMesh {
    let rows = (triangles / 4.0).sqrt() as u32;
    let columns = 2 * rows;
    let mut parts = MeshParts::default();
    for row in 0..=rows {
        for column in 0..columns {
            let (latitude, longitude) = (
                std::f64::consts::PI * (f64::from(row) / f64::from(rows) - 0.5),
                std::f64::consts::TAU * f64::from(column) / f64::from(columns),
            );
            let at = DVec3::new(latitude.cos() * longitude.cos(), latitude.sin(), latitude.cos() * longitude.sin());
            let lump = |frequency: f64| {
                let place = (frequency * at).to_array();
                place.iter().zip([1.3, 0.7, 2.1]).map(|(number, shift)| (number + shift).sin()).product::<f64>() / frequency
            };
            let radius = 1.0 + 0.5 * [3.0, 7.0, 17.0, 41.0, 97.0].map(lump).iter().sum::<f64>();
            // Rounded as in files, so that Embree gets the same mesh.
            parts.positions.push((at * radius).as_vec3().as_dvec3());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = |row: u32, column: u32| row * columns + column % columns;
            let [a, b, c, d] = [at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)];
            parts.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    with_reading(|reading| TriangleMesh::new("generated", parts, reading)).unwrap_or_else(|error| panic!("{error:?}")).0
}

/// A number from 0 to 1 by the index, without order.
fn scattered(index: usize) -> f64 {
    let mut number = (index as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    number = (number ^ number >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    number = (number ^ number >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    (number >> 11) as f64 / (1u64 << 53) as f64
}

/// A direction into the half space about the normal, by the cosine.
fn hemisphere(normal: DVec3, index: usize) -> DVec3 {
    let (z, angle) = (2.0 * scattered(2 * index) - 1.0, std::f64::consts::TAU * scattered(2 * index + 1));
    let across = (1.0 - z * z).sqrt();
    (normal + DVec3::new(across * angle.cos(), across * angle.sin(), z)).normalize()
}

fn all_rays(tree: &MeshTree) -> Vec<Rays> {
    let [low, high] = tree.mesh().bounding_box();
    let (center, size) = (low.midpoint(high), (high - low).length());
    let eye = center + size * DVec3::new(0.4, 0.3, 1.1);
    let forward = (center - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let pixel = |index: usize| {
        let [x, y] = [index % SIDE, index / SIDE].map(|at| (at as f64 + 0.5) / SIDE as f64 - 0.5);
        (eye, (forward + 0.9 * (x * right - y * up)).normalize())
    };
    // Rounded, so that Embree gets the same rays.
    let rounded = |(origin, direction): (DVec3, DVec3)| (origin.as_vec3().as_dvec3(), direction.as_vec3().as_dvec3());
    let primary: Vec<_> = (0..SIDE * SIDE).map(pixel).map(rounded).collect();
    let mut secondary = Vec::new();
    let mut shadow = Vec::new();
    let light = center + size * DVec3::new(-1.0, 1.5, 0.7);
    for (index, (origin, direction)) in primary.iter().enumerate() {
        let Some(hit) = tree.nearest(*origin, *direction, f64::INFINITY, |_| true) else { continue };
        let [a, b, c] = tree.corners(hit.triangle);
        let normal = (b - a).cross(c - a).normalize();
        let normal = if normal.dot(*direction) > 0.0 { -normal } else { normal };
        let at = *origin + hit.distance * *direction + 1e-4 * size * normal;
        secondary.push(rounded((at, hemisphere(normal, index))));
        shadow.push(rounded((at, light - at)));
    }
    vec![
        Rays { name: "primary", occlusion: false, rays: primary },
        Rays { name: "secondary", occlusion: false, rays: secondary },
        Rays { name: "shadow", occlusion: true, rays: shadow },
    ]
}

/// Time and number of hits of our own tree.
fn own(tree: &MeshTree, rays: &Rays) -> (Duration, usize) {
    let start = Instant::now();
    let any = |ray: &&(DVec3, DVec3)| tree.any(ray.0, ray.1, f64::INFINITY, |_| true);
    let nearest = |ray: &&(DVec3, DVec3)| tree.nearest(ray.0, ray.1, f64::INFINITY, |_| true).is_some();
    let hits = if rays.occlusion { rays.rays.iter().filter(any).count() } else { rays.rays.iter().filter(nearest).count() };
    (start.elapsed(), hits)
}

/// Time and number of hits of Embree.
fn theirs(embree: &Embree, rays: &Rays) -> (Duration, usize) {
    let mut work: Vec<RayHit> = rays.rays.iter().map(|(origin, direction)| RayHit::new(*origin, *direction)).collect();
    let start = Instant::now();
    if rays.occlusion {
        embree.occluded(&mut work);
    } else {
        embree.intersect(&mut work);
    }
    let time = start.elapsed();
    let is_hit = |ray: &&RayHit| if rays.occlusion { ray.far < 0.0 } else { ray.geometry != u32::MAX };
    (time, work.iter().filter(is_hit).count())
}

fn compare(name: &str, mesh: &Arc<TriangleMesh>) {
    let start = Instant::now();
    let tree = MeshTree::new(Arc::clone(mesh), &|_| true).unwrap_or_else(|| unreachable!("nothing ends it"));
    let built = start.elapsed().as_secs_f64();
    let bytes = tree.memory() as f64 / mesh.triangles().len() as f64;
    println!("{name}: {} triangles, tree built in {:.0} ms, {bytes:.0} bytes a triangle", mesh.triangles().len(), built * 1e3);
    let embree = std::env::var_os("EMBREE").map(|path| {
        let isa = std::env::var("EMBREE_ISA").unwrap_or_else(|_| "avx2".into());
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let start = Instant::now();
        let embree = Embree::new(Path::new(&path), mesh, &isa, threads).unwrap_or_else(|error| panic!("{error}"));
        println!("  Embree, {isa}: built in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
        embree
    });
    for rays in all_rays(&tree) {
        let rounds: Vec<_> =
            (0..ROUNDS).map(|_| (own(&tree, &rays), embree.as_ref().map(|embree| theirs(embree, &rays)))).collect();
        let count = rays.rays.len() as f64;
        let nanoseconds = |time: Option<Duration>| time.unwrap_or_default().as_secs_f64() / count * 1e9;
        let share = |hits: usize| hits as f64 / count * 100.0;
        let time = nanoseconds(rounds.iter().map(|(own, _)| own.0).min());
        print!("  {:<10} {time:7.1} ns a ray, {:5.1} % hit", rays.name, share(rounds[0].0.1));
        if let Some((_, hits)) = rounds[0].1 {
            let embree = nanoseconds(rounds.iter().filter_map(|(_, theirs)| Some((*theirs)?.0)).min());
            print!("; Embree {embree:7.1} ns, {:5.1} % hit; ratio {:.2}", share(hits), time / embree);
        }
        println!();
    }
}
