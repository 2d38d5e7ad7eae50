//! Packs: opening, and the facts, arrays and primitives of their hulls.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char};
use std::path::PathBuf;

use hullmap::OpenError;

use crate::border::{self, Out, call};
use crate::failure::{Failure, Fallible};
use crate::handles::Pack;
use crate::types::{
    Bounds, DQuat, DVec3, HullArrays, HullFacts, MassProperties, OPEN_BORROW, OPEN_MAP, OPEN_SKIP_CONTENTS, Pose,
    PrimitiveKind, Replacement, Result, Solid, Text,
};

/// Opens a pack file. By default the file is copied into memory and checked completely, so that no
/// file can harm a later query.
///
/// path: in UTF-8 on Windows, in the system's bytes elsewhere. flags: 0, or HULLMAP_OPEN_MAP,
/// HULLMAP_OPEN_SKIP_CONTENTS or both.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_open(path: *const c_char, flags: u32, pack: *mut *mut Pack) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (out, path) = unsafe { (Out::of_handle("pack", pack)?, border::text("path", path)?) };
        let path = native(path)?;
        check_flags(flags, OPEN_MAP | OPEN_SKIP_CONTENTS)?;
        let opened = match (flags & OPEN_MAP != 0, flags & OPEN_SKIP_CONTENTS != 0) {
            (false, false) => hullmap::Pack::open(path),
            (false, true) => hullmap::Pack::open_skipping_contents(path),
            // SAFETY: by setting the flag, the caller promises that no process writes to the file
            // or truncates it while the pack exists.
            (true, false) => unsafe { hullmap::Pack::map(path) },
            // SAFETY: as above.
            (true, true) => unsafe { hullmap::Pack::map_skipping_contents(path) },
        };
        out.give(Pack::new(opened.map_err(not_opened)?));
        Ok(())
    })
}

#[cold]
pub(super) fn not_opened(error: OpenError) -> Failure {
    let code = match error {
        OpenError::Io { .. } => Result::Io,
        OpenError::Invalid { .. } => Result::InvalidPack,
    };
    Failure::new(code, error)
}

#[cfg(unix)]
pub(super) fn native(path: &CStr) -> Fallible<PathBuf> {
    use std::os::unix::ffi::OsStrExt;
    Ok(std::ffi::OsStr::from_bytes(path.to_bytes()).into())
}

#[cfg(not(unix))]
pub(super) fn native(path: &CStr) -> Fallible<PathBuf> {
    path.to_str().map(PathBuf::from).map_err(|error| Failure::argument("path", error))
}

/// Alignment of bytes that are used in place.
const ALIGNMENT: usize = 64;

fn check_flags(flags: u32, known: u32) -> Fallible<()> {
    let unknown = flags & !known;
    if unknown == 0 {
        return Ok(());
    }
    Err(Failure::argument("flags", format_args!("{unknown:#x} is not a flag of this function")))
}

/// Opens a pack that is in memory: all bytes of a file.
///
/// flags: 0, or HULLMAP_OPEN_BORROW, HULLMAP_OPEN_SKIP_CONTENTS or both. By default the bytes are
/// copied, and may be freed after the call; any alignment will do. With HULLMAP_OPEN_BORROW they
/// are used in place: they start on a multiple of 64 bytes, and nobody writes to them or frees them
/// while the pack or a shape made from it exists.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_from_memory(
    bytes: *const u8,
    length: usize,
    flags: u32,
    pack: *mut *mut Pack,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header. With the flag, the caller
        // also promises that the bytes stay as they are for as long as a pack or a shape exists.
        // Without it, nothing keeps a reference to them after this call.
        let (out, bytes) = unsafe { (Out::of_handle("pack", pack)?, border::array("bytes", bytes, length)?) };
        check_flags(flags, OPEN_BORROW | OPEN_SKIP_CONTENTS)?;
        if flags & OPEN_BORROW != 0 && !bytes.as_ptr().addr().is_multiple_of(ALIGNMENT) {
            let message = format_args!("they are not aligned to {ALIGNMENT} bytes; align them, or do not borrow them");
            return Err(Failure::argument("bytes", message));
        }
        let opened = match (flags & OPEN_BORROW != 0, flags & OPEN_SKIP_CONTENTS != 0) {
            (false, false) => hullmap::Pack::from_bytes(bytes),
            (false, true) => hullmap::Pack::from_bytes_skipping_contents(bytes),
            (true, false) => hullmap::Pack::from_static(bytes),
            (true, true) => hullmap::Pack::from_static_skipping_contents(bytes),
        };
        out.give(Pack::new(opened.map_err(|error| Failure::new(Result::InvalidPack, error))?));
        Ok(())
    })
}

/// Frees a pack; NULL is allowed. Shapes made from it stay valid, and keep its memory.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_free(pack: *mut Pack) {
    // SAFETY: the caller keeps the rules at the head of the header.
    unsafe { border::free(pack) }
}

/// Number of hulls of a pack, at least 1; 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_hull_count(pack: *const Pack) -> usize {
    let mut count = 0;
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        count = unsafe { border::handle("pack", pack)? }.pack().hull_count();
        Ok(())
    });
    count
}

/// Index of the first hull with this name. O(number of hulls).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_find(pack: *const Pack, name: *const c_char, index: *mut usize) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (pack, name, out) =
            unsafe { (border::handle("pack", pack)?, border::text("name", name)?, Out::new("index", index)?) };
        let found = pack.pack().shared_hull_named(&name.to_string_lossy());
        out.write(found.map_err(|error| Failure::new(Result::NotFound, error))?.index());
        Ok(())
    })
}

/// Facts that the bake recorded about the hull of index `hull`, counted from 0. The caller sets
/// facts->struct_size first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_hull_facts(pack: *const Pack, hull: usize, facts: *mut HullFacts) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (pack, out) = unsafe {
            border::check_size("facts", facts)?;
            (border::handle("pack", pack)?, Out::new("facts", facts)?)
        };
        let hull = pack.hull(hull)?;
        let [min, max] = hull.bounds().map(|corner| corner.as_dvec3());
        out.write(HullFacts {
            struct_size: size_of::<HullFacts>(),
            name: Text { data: hull.name().as_ptr().cast(), length: hull.name().len() },
            vertex_count: hull.vertex_count(),
            face_count: hull.face_count(),
            rank: hull.rank(),
            part: hull.part(),
            volume: hull.volume(),
            surface_area: hull.surface_area(),
            centroid: hull.centroid(),
            inertia: hull.inertia_tensor().transpose().to_cols_array(),
            bounds: Bounds { min, max },
            diameter: hull.diameter(),
            interior_point: hullmap::SupportMap::interior_point(&hull),
            inner_radius: hullmap::SupportMap::inner_radius(&hull),
            outer_radius: hullmap::SupportMap::outer_radius(&hull),
            containment_error: hull.containment_error(),
            outer_error: hull.outer_error(),
            origin: hull.origin(),
            part_count: hull.part_count(),
            solid: Solid::from(hull.solid()) as u32,
            uncovered: hull.uncovered().unwrap_or(0.0),
            protrusion: hull.protrusion().unwrap_or(0.0),
            protrusion_at: hull.protrusion_at().unwrap_or_default(),
            voids: hull.voids().map_or(-1.0, |voids| voids.share),
            voids_error: hull.voids().map_or(0.0, |voids| voids.error),
        });
        Ok(())
    })
}

/// The primitive that may replace the hull of index `hull` (option `primitives`). Its kind is
/// HULLMAP_PRIMITIVE_KIND_NONE if there is none, or the bake did not look for primitives.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_hull_primitive(
    pack: *const Pack,
    hull: usize,
    primitive: *mut Replacement,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (pack, out) = unsafe { (border::handle("pack", pack)?, Out::new("primitive", primitive)?) };
        out.write(match pack.hull(hull)?.primitive() {
            Some(found) => {
                let pose = Pose { translation: found.center, rotation: found.rotation };
                let kind = PrimitiveKind::from(found.kind) as u32;
                Replacement { kind, pose, sizes: found.sizes, protrusion: found.protrusion }
            }
            None => {
                let pose = Pose { translation: DVec3::ZERO, rotation: DQuat::from_array([0.0; 4]) };
                Replacement { kind: PrimitiveKind::None as u32, pose, sizes: [0.0; 3], protrusion: 0.0 }
            }
        });
        Ok(())
    })
}

/// Mass properties of `count` hulls from the one of index `first`, as one rigid body of uniform
/// density: mass per volume. All hulls of a pack: 0 and hullmap_pack_hull_count.
///
/// An object whose parts are all among the hulls has the mass of its mesh, if the pack records it.
/// Others have the sum of their hulls, which counts overlaps twice; mass->source states which.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_mass_properties(
    pack: *const Pack,
    first: usize,
    count: usize,
    density: f64,
    mass: *mut MassProperties,
) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (pack, out) = unsafe { (border::handle("pack", pack)?, Out::new("mass", mass)?) };
        // NaN takes the failing branch.
        if !(0.0..f64::INFINITY).contains(&density) {
            return Err(Failure::argument("density", format_args!("{density} is negative or not finite")));
        }
        if count == 0 {
            return Err(Failure::argument("count", "0 hulls have no mass: pass at least 1"));
        }
        // The last index is in range, so all are.
        pack.hull(first.saturating_add(count - 1))?;
        let found = pack.pack().mass_properties_of(first..first + count, density);
        let found = found.map_err(|error| Failure::new(Result::NotFound, error))?;
        out.write(MassProperties {
            mass: found.mass,
            center_of_mass: found.center_of_mass,
            inertia: found.inertia.transpose().to_cols_array(),
            source: found.source,
        });
        Ok(())
    })
}

/// The vertices, faces and neighbours of the hull of index `hull`, in place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hullmap_pack_hull_arrays(pack: *const Pack, hull: usize, arrays: *mut HullArrays) -> Result {
    call(|| {
        // SAFETY: the caller keeps the rules at the head of the header.
        let (pack, out) = unsafe { (border::handle("pack", pack)?, Out::new("arrays", arrays)?) };
        let found = pack.hull(hull)?.arrays();
        let found =
            found.ok_or_else(|| Failure::unsupported("packs hold little-endian numbers, this processor does not"))?;
        out.write(HullArrays {
            vertices: found.vertices.as_ptr().cast(),
            source_vertices: found.source_vertices.as_ptr(),
            neighbour_starts: found.neighbour_starts.as_ptr(),
            vertex_count: found.vertices.len(),
            neighbours: found.neighbours.as_ptr(),
            neighbour_count: found.neighbours.len(),
            face_starts: found.face_starts.as_ptr(),
            face_count: found.face_starts.len(),
            face_vertices: found.face_vertices.as_ptr(),
            face_vertex_count: found.face_vertices.len(),
        });
        Ok(())
    })
}
