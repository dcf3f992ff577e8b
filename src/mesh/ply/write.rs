//! Writes meshes as binary PLY files, which read back as they were.

use crate::mesh::triangle_mesh::TriangleMesh;
use std::io::{self, Write};

/// Writes a mesh. Coordinates are written in single precision if that loses nothing, and else in double precision.
///
/// # Errors
/// The writer fails.
pub fn write_ply(mesh: &TriangleMesh, writer: &mut impl Write) -> io::Result<()> {
    let mut coordinates = mesh.positions().iter().flat_map(|position| position.to_array());
    let is_single = coordinates.all(|coordinate| f64::from(coordinate as f32) == coordinate);
    write_header(mesh, if is_single { "float" } else { "double" }, writer)?;
    for (vertex, position) in mesh.positions().iter().enumerate() {
        for coordinate in position.to_array() {
            if is_single {
                writer.write_all(&(coordinate as f32).to_le_bytes())?;
            } else {
                writer.write_all(&coordinate.to_le_bytes())?;
            }
        }
        let normal = mesh.normals().get(vertex).map(|normal| normal.to_array());
        let uv = mesh.uvs().get(vertex).map(|uv| uv.to_array());
        for number in normal.iter().flatten().chain(uv.iter().flatten()) {
            writer.write_all(&number.to_le_bytes())?;
        }
    }
    for [a, b, c] in mesh.triangles() {
        // Counter-clockwise, as in all such files.
        writer.write_all(&[3])?;
        [a, c, b].into_iter().try_for_each(|vertex| writer.write_all(&vertex.to_le_bytes()))?;
    }
    Ok(())
}

/// Writes what the records are made of. `coordinate` is the type of positions.
fn write_header(mesh: &TriangleMesh, coordinate: &str, writer: &mut impl Write) -> io::Result<()> {
    writeln!(writer, "ply\nformat binary_little_endian 1.0\nelement vertex {}", mesh.positions().len())?;
    let normals: &[&str] = if mesh.normals().is_empty() { &[] } else { &["nx", "ny", "nz"] };
    let uvs: &[&str] = if mesh.uvs().is_empty() { &[] } else { &["s", "t"] };
    for name in ["x", "y", "z"] {
        writeln!(writer, "property {coordinate} {name}")?;
    }
    for name in normals.iter().chain(uvs) {
        writeln!(writer, "property float {name}")?;
    }
    let count = mesh.triangles().len();
    writeln!(writer, "element face {count}\nproperty list uchar uint vertex_indices\nend_header")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::parse;
    use crate::mesh::{MeshParts, Reading};
    use glam::{DVec3, Vec2, Vec3};
    use proptest::prelude::*;
    use std::sync::atomic::AtomicBool;

    fn mesh(parts: MeshParts) -> Option<TriangleMesh> {
        let reading = Reading { memory: 1 << 20, progress: &|_| (), cancelled: &AtomicBool::new(false) };
        TriangleMesh::new("parts", parts, &reading).ok().map(|(mesh, _)| mesh)
    }

    fn written(mesh: &TriangleMesh) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_ply(mesh, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn single_precision_is_used_where_it_suffices() {
        let parts = |x: f64| MeshParts {
            positions: vec![DVec3::ZERO, DVec3::new(x, 0.0, 0.0), DVec3::Y],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        };
        let [single, double] = [0.5, 0.1].map(|x| written(&mesh(parts(x)).unwrap()));
        let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
            property float z\nelement face 1\nproperty list uchar uint vertex_indices\nend_header\n";
        assert!(single.starts_with(header.as_bytes()));
        // The corners go counter-clockwise in the file.
        assert_eq!(single[header.len() + 36..], [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(double.len(), single.len() + 36 + 3, "8 bytes for each of 9 numbers, and `double`");
    }

    proptest! {
        #[test]
        fn a_written_mesh_reads_back_as_it_was(
            positions in prop::collection::vec(prop::array::uniform3(-9.0..9.0_f64), 3..12),
            triangles in prop::collection::vec(prop::array::uniform3(0..12_u32), 1..9),
            has in prop::array::uniform2(any::<bool>()),
            is_single in any::<bool>(),
        ) {
            let count = positions.len() as u32;
            let round = |number: f64| if is_single { f64::from(number as f32) } else { number };
            let positions: Vec<DVec3> = positions.into_iter().map(|position| DVec3::from_array(position.map(round))).collect();
            let normals = if has[0] { positions.iter().map(|position| position.as_vec3() + Vec3::splat(0.1)).collect() } else { Vec::new() };
            let uvs = if has[1] { positions.iter().map(|position| Vec2::new(position.x as f32, 0.5)).collect() } else { Vec::new() };
            let triangles = triangles.into_iter().map(|triangle| triangle.map(|vertex| vertex % count)).collect();
            if let Some(mesh) = mesh(MeshParts { positions, normals, uvs, triangles, bytes_behind: 0 }) {
                let (read, repairs) = parse("a.ply", written(&mesh));
                prop_assert_eq!(repairs, Default::default());
                prop_assert_eq!(read.positions(), mesh.positions());
                prop_assert_eq!(read.triangles(), mesh.triangles());
                prop_assert_eq!(read.uvs(), mesh.uvs());
                // Unit vectors are made unit vectors once more.
                prop_assert!(read.normals().iter().zip(mesh.normals()).all(|(one, other)| (*one - *other).length() < 2e-7));
                prop_assert_eq!(read.normals().len(), mesh.normals().len());
            }
        }
    }
}
