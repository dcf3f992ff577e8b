//! Embree, by the library that a wheel of `embreex` or a package of the system brings along.
//!
//! Only what the comparison needs is declared here, after the header `rtcore.h` of Embree 4.

#![allow(unsafe_code)]

use glam::DVec3;
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::ptr;

/// A ray and what it hits, as Embree lays them out.
#[repr(C, align(16))]
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    /// The distance; negative if an occlusion ray hit something.
    pub(crate) far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    uv: [f32; 2],
    /// The number of the triangle.
    pub(crate) triangle: u32,
    /// `u32::MAX` without a hit.
    pub(crate) geometry: u32,
    instance: [u32; 2],
}

impl RayHit {
    /// A ray that has not hit anything.
    pub(crate) fn new(origin: DVec3, direction: DVec3) -> Self {
        Self {
            origin: origin.as_vec3().to_array(),
            near: 0.0,
            direction: direction.as_vec3().to_array(),
            time: 0.0,
            far: f32::INFINITY,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            uv: [0.0; 2],
            triangle: u32::MAX,
            geometry: u32::MAX,
            instance: [u32::MAX; 2],
        }
    }
}

type Handle = *mut c_void;
type Cast = unsafe extern "C" fn(Handle, *mut RayHit, *mut c_void);

/// A committed scene of one mesh.
pub(crate) struct Embree {
    scene: Handle,
    intersect: Cast,
    occluded: Cast,
    // Never unloaded: its threads go on to the end of the program.
    _library: ManuallyDrop<Library>,
}

const TRIANGLES: u32 = 0;
const BUFFER_INDEX: u32 = 0;
const BUFFER_VERTEX: u32 = 1;
const FORMAT_UINT3: u32 = 0x5003;
const FORMAT_FLOAT3: u32 = 0x9003;
const ROBUST: u32 = 1 << 2;

impl Embree {
    /// Loads the library and builds a scene, on this many threads. `isa` is the instruction set, such as `avx2`.
    pub(crate) fn new(
        path: &Path,
        mesh: &illuminator::mesh::TriangleMesh,
        isa: &str,
        threads: usize,
    ) -> Result<Self, libloading::Error> {
        let config = CString::new(format!("isa={isa},threads={threads}")).unwrap_or_default();
        // SAFETY: The signatures are those of rtcore.h of Embree 4. Buffers have the sizes that Embree was told, and
        // its own allocation is written within them. The handles are used while the library is loaded.
        unsafe {
            let library = Library::new(path)?;
            let new_device: unsafe extern "C" fn(*const c_char) -> Handle = *library.get(c"rtcNewDevice".to_bytes_with_nul())?;
            let new_scene: unsafe extern "C" fn(Handle) -> Handle = *library.get(c"rtcNewScene".to_bytes_with_nul())?;
            let set_flags: unsafe extern "C" fn(Handle, u32) = *library.get(name(c"rtcSetSceneFlags"))?;
            let new_geometry: unsafe extern "C" fn(Handle, u32) -> Handle = *library.get(name(c"rtcNewGeometry"))?;
            let new_buffer: unsafe extern "C" fn(Handle, u32, u32, u32, usize, usize) -> *mut c_void =
                *library.get(name(c"rtcSetNewGeometryBuffer"))?;
            let commit_geometry: unsafe extern "C" fn(Handle) = *library.get(name(c"rtcCommitGeometry"))?;
            let attach: unsafe extern "C" fn(Handle, Handle) -> u32 = *library.get(name(c"rtcAttachGeometry"))?;
            let commit: unsafe extern "C" fn(Handle) = *library.get(name(c"rtcCommitScene"))?;
            let device = new_device(config.as_ptr());
            let scene = new_scene(device);
            set_flags(scene, ROBUST);
            let geometry = new_geometry(device, TRIANGLES);
            let positions = mesh.positions();
            let vertices = new_buffer(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT3, 12, positions.len()).cast::<[f32; 3]>();
            for (index, position) in positions.iter().enumerate() {
                ptr::write(vertices.add(index), position.as_vec3().to_array());
            }
            let triangles = mesh.triangles();
            let indices = new_buffer(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, 12, triangles.len()).cast::<[u32; 3]>();
            ptr::copy_nonoverlapping(triangles.as_ptr(), indices, triangles.len());
            commit_geometry(geometry);
            attach(scene, geometry);
            commit(scene);
            let intersect: Cast = *library.get(name(c"rtcIntersect1"))?;
            let occluded: Cast = *library.get(name(c"rtcOccluded1"))?;
            Ok(Self { scene, intersect, occluded, _library: ManuallyDrop::new(library) })
        }
    }

    /// Finds what each ray hits first.
    pub(crate) fn intersect(&self, rays: &mut [RayHit]) {
        // SAFETY: A ray has the layout of RTCRayHit, and the arguments may be null.
        rays.iter_mut().for_each(|ray| unsafe { (self.intersect)(self.scene, ray, ptr::null_mut()) });
    }

    /// Finds whether each ray hits anything.
    pub(crate) fn occluded(&self, rays: &mut [RayHit]) {
        // SAFETY: A ray begins with the layout of RTCRay, and the arguments may be null.
        rays.iter_mut().for_each(|ray| unsafe { (self.occluded)(self.scene, ray, ptr::null_mut()) });
    }
}

fn name(name: &CStr) -> &[u8] {
    name.to_bytes_with_nul()
}
