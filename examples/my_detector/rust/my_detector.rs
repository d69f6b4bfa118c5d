// A broad phase for cdb in Rust: bodies sorted along x, and each compared with those that begin
// before it ends. The order of the last cycle is nearly that of this one.
//
//   rustc --edition 2021 -O --crate-type cdylib my_detector.rs -o my_detector.so
//   cdb run compare.cdb
//
// The declarations are those of cdb/detector_c.h.
use std::os::raw::{c_char, c_int, c_uint, c_void};
use std::ptr::null;

#[repr(C)]
struct Vec3 {
    x: f64,
    y: f64,
    z: f64,
}

#[repr(C)]
struct Box3 {
    lower: Vec3,
    upper: Vec3,
}

#[repr(C)]
struct Filter {
    group: u32,
    mask: u32,
    is_fixed: u8,
    is_kinematic: u8,
}

#[repr(C)]
struct Scene {
    size: usize,
    boxes: *const Box3,
    filters: *const Filter,
    poses: *const c_void,
    shapes: *const c_void,
    is_asleep: *const u8,
}

#[repr(C)]
#[derive(Clone, Copy)]
struct Pair {
    a: u32,
    b: u32,
}

#[repr(C)]
struct Pairs {
    data: *const Pair,
    size: usize,
}

#[repr(C)]
struct Options {
    threads: c_uint,
}

type Failure = *const c_char; // null if all went well

#[repr(C)]
struct Functions {
    make: Option<extern "C" fn(*const Options) -> *mut c_void>,
    destroy: Option<extern "C" fn(*mut c_void)>,
    prepare: Option<extern "C" fn(*mut c_void, *const Scene) -> Failure>,
    find_pairs: Option<extern "C" fn(*mut c_void, *const Scene, *mut Pairs) -> Failure>,
    find_changes: *const c_void,
    handles: *const c_void,
    find_contacts: *const c_void,
}
unsafe impl Sync for Functions {}

#[repr(C)]
struct Detector {
    name: *const c_char,
    phases: *const c_char,
    needs_poses: c_int,
    max_bodies: u64,
    functions: *const Functions,
}
unsafe impl Sync for Detector {}

#[repr(C)]
pub struct Plugin {
    abi: u32,
    count: usize,
    detectors: *const Detector,
}
unsafe impl Sync for Plugin {}

struct SortedAlongX {
    order: Vec<u32>,
    pairs: Vec<Pair>,
}

impl SortedAlongX {
    fn find(&mut self, boxes: &[Box3], filters: &[Filter]) {
        let lower = |id: &u32| boxes[*id as usize].lower.x;
        self.order.sort_by(|a, b| lower(a).total_cmp(&lower(b)));
        self.pairs.clear();
        for (i, &a) in self.order.iter().enumerate() {
            let one = &boxes[a as usize];
            for &b in &self.order[i + 1..] {
                let other = &boxes[b as usize];
                if other.lower.x > one.upper.x {
                    break;
                }
                if overlap(one, other) && may_collide(&filters[a as usize], &filters[b as usize]) {
                    self.pairs.push(Pair { a, b });
                }
            }
        }
    }
}

fn overlap(a: &Box3, b: &Box3) -> bool {
    a.lower.y <= b.upper.y && b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z
}

fn may_collide(a: &Filter, b: &Filter) -> bool {
    !(a.is_fixed != 0 && b.is_fixed != 0) && a.group & b.mask != 0 && b.group & a.mask != 0
}

extern "C" fn make(_: *const Options) -> *mut c_void {
    Box::into_raw(Box::new(SortedAlongX { order: Vec::new(), pairs: Vec::new() })) as *mut c_void
}

extern "C" fn destroy(this: *mut c_void) {
    drop(unsafe { Box::from_raw(this as *mut SortedAlongX) });
}

extern "C" fn prepare(this: *mut c_void, scene: *const Scene) -> Failure {
    let (this, scene) = unsafe { (&mut *(this as *mut SortedAlongX), &*scene) };
    this.order = (0..scene.size as u32).collect();
    null()
}

extern "C" fn find_pairs(this: *mut c_void, scene: *const Scene, pairs: *mut Pairs) -> Failure {
    unsafe {
        let (this, scene) = (&mut *(this as *mut SortedAlongX), &*scene);
        this.find(
            std::slice::from_raw_parts(scene.boxes, scene.size),
            std::slice::from_raw_parts(scene.filters, scene.size),
        );
        *pairs = Pairs { data: this.pairs.as_ptr(), size: this.pairs.len() };
    }
    null()
}

static FUNCTIONS: Functions = Functions {
    make: Some(make),
    destroy: Some(destroy),
    prepare: Some(prepare),
    find_pairs: Some(find_pairs),
    find_changes: null(),
    handles: null(),
    find_contacts: null(),
};

static DETECTORS: [Detector; 1] = [Detector {
    name: b"sorted_in_rust\0".as_ptr() as *const c_char,
    phases: b"broad\0".as_ptr() as *const c_char,
    needs_poses: 0,
    max_bodies: 0,
    functions: &FUNCTIONS,
}];

static PLUGIN: Plugin = Plugin { abi: 2, count: 1, detectors: DETECTORS.as_ptr() };

// The interface, and a line for each detector: name, phases, limit of bodies.
const MANIFEST: [u8; 28] = *b"2\tC\nsorted_in_rust\tbroad\t0\n\0";

#[no_mangle]
#[link_section = ".cdb_detectors"]
pub static cdb_manifest: [u8; MANIFEST.len()] = MANIFEST;

#[no_mangle]
pub extern "C" fn cdb_c_plugin_table() -> *const Plugin {
    &PLUGIN
}
