//! The meshes of the shader ball. They are made here: `UPDATE_MESHES=1` writes their files.

mod lathe;
mod parts;

use glam::DVec3;
use illuminator::mesh::{MeshRepairs, Reading, TriangleMesh, read_bytes};
use illuminator::workspace::presets::MESHES;
use std::collections::HashMap;
use std::path::Path;

/// All files together have at most this many bytes.
const MOST_BYTES: usize = 400_000;

fn mesh(name: &str, bytes: &[u8]) -> TriangleMesh {
    let (mesh, repairs) = read_bytes(Path::new("part.ply"), bytes, &Reading::unwatched(1 << 28)).expect(name);
    assert_eq!(repairs, MeshRepairs::default(), "{name}");
    mesh
}

/// The stored meshes, by name.
fn stored() -> Vec<(&'static str, TriangleMesh)> {
    let bytes = |name| MESHES.iter().find(|mesh| mesh.name == name).expect(name).bytes;
    parts::parts().iter().map(|(name, _)| (*name, mesh(name, bytes(name)))).collect()
}

/// How often each edge is passed in each direction, from position to position.
fn edges(mesh: &TriangleMesh) -> HashMap<[[u64; 3]; 2], u32> {
    // Adding 0 makes -0 the same as 0.
    let place = |vertex: u32| mesh.positions()[vertex as usize].to_array().map(|number| (number + 0.0).to_bits());
    let mut edges = HashMap::new();
    for [a, b, c] in mesh.triangles() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry([place(*from), place(*to)]).or_insert(0) += 1;
        }
    }
    edges
}

/// The volume inside, positive if the front is outside: corners go clockwise.
fn volume(mesh: &TriangleMesh) -> f64 {
    let corner = |vertex: u32| mesh.positions()[vertex as usize];
    -mesh.triangles().iter().map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c)))).sum::<f64>() / 6.0
}

#[test]
fn files_are_what_the_program_makes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("presets/mesh");
    let mut whole = 0;
    for (name, model) in parts::parts() {
        let fresh = model.ply();
        whole += fresh.len();
        let path = folder.join(format!("{name}.ply"));
        if std::env::var_os("UPDATE_MESHES").is_some() {
            std::fs::write(&path, &fresh).expect("a writable file");
        }
        let stored = mesh(name, &std::fs::read(&path).expect("a stored mesh"));
        let fresh = mesh(name, &fresh);
        // Sines differ in the last digit from one machine to another.
        let near = |(one, other): (&DVec3, &DVec3)| one.distance(*other) < 1e-5;
        let same = stored.triangles() == fresh.triangles() && stored.positions().iter().zip(fresh.positions()).all(near);
        assert!(same, "{} is old; run this test with UPDATE_MESHES=1", path.display());
    }
    assert!(whole <= MOST_BYTES, "{whole} bytes");
}

#[test]
fn parts_are_closed_and_turn_their_front_outside() {
    for (name, mesh) in stored() {
        let edges = edges(&mesh);
        assert!(edges.values().all(|times| *times == 1), "{name}: an edge of more than two triangles");
        let open = edges.keys().filter(|[from, to]| !edges.contains_key(&[*to, *from])).count();
        if name == "backdrop" {
            // An open sheet of 28 rows: two edges at its ends, and 28 on each side.
            assert_eq!(open, 2 + 2 * 28, "{name}");
            continue;
        }
        assert_eq!(open, 0, "{name}: an open edge");
        let mut corners: Vec<_> = edges.keys().map(|[from, _]| *from).collect();
        corners.sort_unstable();
        corners.dedup();
        // Vertices - edges + triangles: 2 of a sphere, 0 of a torus.
        let euler = corners.len() as i64 - edges.len() as i64 / 2 + mesh.triangles().len() as i64;
        assert_eq!(euler, if name == "shaderball-ring" { 0 } else { 2 }, "{name}");
        assert!(volume(&mesh) > 0.0, "{name} is inside out");
    }
}

#[test]
fn the_shell_has_the_volume_of_its_formula() {
    let meshes = stored();
    let (_, ball) = meshes.iter().find(|(name, _)| *name == "shaderball-ball").expect("the ball");
    // A spherical sector of half angle 180 - 40 degrees between the radii 0.88 and 1, and half a torus as its lip.
    let pi = std::f64::consts::PI;
    let (opening, radius) = (40_f64.to_radians(), 0.06);
    let sector = 2.0 / 3.0 * pi * (1.0 - 0.88_f64.powi(3)) * (1.0 + opening.cos());
    // Pappus: the area of the half disc times the way of its centroid.
    let (sine, cosine) = opening.sin_cos();
    let centroid = 0.94 * sine - 4.0 * radius / (3.0 * pi) * cosine;
    let lip = pi * radius * radius / 2.0 * 2.0 * pi * centroid;
    let found = volume(ball);
    // The grooves take away 0.4 % of it, and the facets a little more.
    assert!((found / (sector + lip) - 1.0).abs() < 0.02, "{found} beside {}", sector + lip);
}

#[test]
fn normals_and_coordinates_suit_the_surface() {
    for (name, mesh) in stored() {
        assert!(mesh.uvs().iter().all(|uv| uv.cmpge(glam::Vec2::ZERO).all() && uv.cmple(glam::Vec2::ONE).all()), "{name}");
        let mesh = mesh.smooth(name, &Reading::unwatched(1 << 28)).expect("memory");
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|vertex| mesh.positions()[vertex as usize]);
            let front = (c - a).cross(b - a).normalize();
            for vertex in triangle {
                // No facet is far from the smooth surface: a corner that is not rounded would have 45 degrees.
                let cosine = mesh.normals()[*vertex as usize].as_dvec3().dot(front);
                assert!(cosine > 32_f64.to_radians().cos(), "{name}: {} degrees at {a}", cosine.acos().to_degrees());
            }
            // No triangle goes back over the seam.
            let u = triangle.map(|vertex| mesh.uvs()[vertex as usize].x);
            let wide = u.iter().copied().fold(f32::MIN, f32::max) - u.iter().copied().fold(f32::MAX, f32::min);
            assert!(name == "backdrop" || wide < 0.03, "{name}: u jumps by {wide} at {a}");
        }
    }
}
