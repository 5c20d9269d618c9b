//! The exports, called with possible errors of a host, and from several threads.
#![expect(unsafe_code, reason = "calls exports as a foreign host does")]
#![expect(clippy::float_cmp, reason = "codes and copied values are exact")]

use crate::fixtures;
use crate::support::documents;
use linewright::contract::machine::Machine;
use linewright::mealy;
use linewright::station::load::Library;
use linewright::station::{Controller, ErrorCode, Package, Toolchain};
use std::ffi::{CStr, c_char, c_int};
use std::sync::Arc;

/// `UF_Value` of the default profile.
#[repr(C)]
#[derive(Clone, Copy)]
struct Value {
    tag: c_int,
    bits: u64,
}

fn integer(i: i32) -> Value {
    Value {
        tag: 1,
        bits: u64::from(i as u32),
    }
}
fn real(x: f64) -> Value {
    Value {
        tag: 2,
        bits: x.to_bits(),
    }
}
fn string(s: &CStr) -> Value {
    Value {
        tag: 3,
        bits: s.as_ptr() as u64,
    }
}
fn as_integer(v: Value) -> i32 {
    assert_eq!(v.tag, 1, "an integer");
    v.bits as u32 as i32
}
fn as_real(v: Value) -> f64 {
    assert_eq!(v.tag, 2, "a real number");
    f64::from_bits(v.bits)
}

/// A text of a library that is still loaded; no other text of its instance was returned since.
fn as_string(v: Value) -> String {
    assert_eq!(v.tag, 3, "a string");
    // SAFETY: the library keeps a text that it returned until the next one of the same instance.
    unsafe { CStr::from_ptr(v.bits as *const c_char) }
        .to_string_lossy()
        .into_owned()
}

struct Host(libloading::Library);

impl Host {
    fn new(
        fixture: &(Arc<Machine>, Arc<Vec<mealy::Controller>>),
        folder: &std::path::Path,
    ) -> Self {
        let package = Package::emit(&fixture.0, &fixture.1);
        let built = Toolchain::host().build(&package, folder, false).unwrap();
        // SAFETY: our own C.
        Self(unsafe { libloading::Library::new(built.path) }.unwrap())
    }
    fn call(&self, name: &str, arguments: &mut [Value]) -> Value {
        let mut answer = Value { tag: 0, bits: 0 };
        // SAFETY: the signature is that of every export of the adapter.
        unsafe {
            let export: libloading::Symbol<'_, unsafe extern "C" fn(*mut Value, *mut Value)> =
                self.0.get(name).unwrap();
            export(&raw mut answer, arguments.as_mut_ptr());
        }
        answer
    }
    fn instantiate(&self) -> i32 {
        as_integer(self.call("instantiate", &mut []))
    }
    fn last_error(&self, handle: i32) -> String {
        as_string(self.call("last_error", &mut [integer(handle)]))
    }
    fn simulate(&self, handle: Value, operation: Value, values: [Value; 3]) -> f64 {
        as_real(self.call(
            "simulate",
            &mut [handle, operation, values[0], values[1], values[2]],
        ))
    }
}

const GOOD: [f64; 3] = [90.0, 1.0, 0.3];

#[test]
fn handles_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let host = Host::new(&fixtures::manipulator(), folder.path());
    let other = Host::new(&fixtures::belt(), folder.path());
    let mut handle = host.instantiate();
    assert!(handle > 0);
    let foreign = other.instantiate();
    assert!(foreign > 0);
    let good = GOOD.map(real);
    for bad in [
        0,
        -1,
        1,
        i32::MAX,
        i32::MIN,
        foreign,
        handle ^ 1,
        handle ^ (1 << 10),
        handle ^ (1 << 21),
    ] {
        assert!(
            host.simulate(integer(bad), integer(0), good) == -1.0,
            "{bad}"
        );
        assert_eq!(as_integer(host.call("reset", &mut [integer(bad)])), -1);
        assert_eq!(
            as_integer(host.call("deinstantiate", &mut [integer(bad)])),
            -1
        );
        assert_eq!(
            as_integer(host.call("get_real", &mut [integer(bad), string(c"seconds")])),
            -1
        );
        assert!(host.last_error(bad).contains("never issued"));
    }
    // A handle must be an integer, and there must be one.
    for value in [
        real(f64::from(handle)),
        string(c"1"),
        Value {
            tag: 77,
            bits: handle as u64,
        },
    ] {
        assert!(host.simulate(value, integer(0), good) == -2.0);
        assert_eq!(as_integer(host.call("deinstantiate", &mut [value])), -2);
    }
    // Destroyed handles stay invalid, even when their slot is reused.
    let mut dead = Vec::new();
    for _ in 0..3000 {
        assert_eq!(
            as_integer(host.call("deinstantiate", &mut [integer(handle)])),
            0
        );
        dead.push(handle);
        handle = host.instantiate();
        assert!(handle > 0);
    }
    for dead in dead {
        assert_eq!(as_integer(host.call("reset", &mut [integer(dead)])), -1);
    }
    assert!(host.simulate(integer(handle), integer(0), good) > 0.0);
}

#[test]
fn results_are_read_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let host = Host::new(&fixtures::manipulator(), folder.path());
    let handle = host.instantiate();
    let get = |how: &str, name: &CStr| host.call(how, &mut [integer(handle), string(name)]);
    let words = |name: &CStr| as_string(get("get_string", name));
    let whole = |name: &CStr| as_integer(get("get_integer", name));
    // Before anything has happened.
    assert_eq!((whole(c"verdict"), words(c"verdict").as_str()), (0, "ok"));
    for name in [c"time", c"energy", c"steps", c"angle"] {
        assert_eq!(as_integer(get("get_real", name)), -2);
    }
    assert!(host.last_error(handle).contains("no operation has ended"));
    assert_eq!(whole(c"output.turn.angle"), -2);
    assert!(host.last_error(handle).contains("no step has been made"));

    let seconds = host.simulate(integer(handle), integer(0), GOOD.map(real));
    assert!(seconds > 0.0);
    for name in [c"time", c"seconds"] {
        assert!(as_real(get("get_real", name)) == seconds);
    }
    let energy = as_real(get("get_real", c"energy"));
    assert!(energy > 0.0 && energy == as_real(get("get_real", c"joules")));
    let steps = whole(c"steps");
    assert!(steps > 0 && as_real(get("get_real", c"steps")) == f64::from(steps));
    assert_eq!(words(c"steps"), steps.to_string());
    let control = as_real(get("get_real", c"control_time"));
    assert!(control > 0.0 && control < seconds, "{control} of {seconds}");
    // A value that is no integer has no integer result.
    assert_eq!(whole(c"time"), -2);
    assert!(host.last_error(handle).contains("use get_real"));
    let output = whole(c"output.turn.angle");
    assert!(as_real(get("get_real", c"output.turn.angle")) == f64::from(output));

    // A refusal has a verdict and a rule, and keeps the results of the last completed operation.
    assert!(host.simulate(integer(handle), integer(0), [90.0, 0.0, 0.3].map(real)) == -5.0);
    assert_eq!(
        (whole(c"verdict"), words(c"verdict").as_str()),
        (-5, "assumption")
    );
    assert_eq!(words(c"rule"), "turn: gripped");
    assert!(as_real(get("get_real", c"time")) == seconds);
    assert!(host.simulate(integer(handle), string(c"nothing"), GOOD.map(real)) == -4.0);
    assert_eq!(
        (words(c"verdict").as_str(), words(c"rule").as_str()),
        ("operation", "")
    );
    // Unknown names, one longer than the part that is stored.
    let long = std::ffi::CString::new("\u{e4}".repeat(200)).unwrap();
    for name in [c"nothing", c"output.nothing", c"property.", &long] {
        assert_eq!(whole(name), -2);
        assert!(
            host.last_error(handle).starts_with("there is no result `"),
            "{name:?}"
        );
    }
    assert!(host.last_error(handle).ends_with("...`"));
}

/// A returned text is not changed by other calls on the instance, nor by texts of others.
#[test]
fn texts_stay_for_a_while() {
    let folder = tempfile::tempdir().unwrap();
    let host = Host::new(&fixtures::manipulator(), folder.path());
    let handles = [(); 40].map(|()| host.instantiate());
    let texts = handles.map(|handle| {
        host.simulate(integer(handle), integer(7 + handle % 1000), GOOD.map(real));
        let text = host.call("last_error", &mut [integer(handle)]);
        host.simulate(integer(handle), string(c"nothing"), GOOD.map(real));
        text
    });
    for (handle, text) in handles.into_iter().zip(texts) {
        let wanted = format!("there is no operation {}", 7 + handle % 1000);
        assert_eq!(as_string(text), wanted);
    }
}

#[test]
fn instances_are_limited() {
    let folder = tempfile::tempdir().unwrap();
    let host = Host::new(&fixtures::belt(), folder.path());
    let handles: Vec<i32> = (0..1024).map(|_| host.instantiate()).collect();
    assert!(handles.iter().all(|h| *h > 0));
    assert_eq!(host.instantiate(), ErrorCode::Memory as i32);
    assert!(
        host.last_error(0)
            .contains("slots for instances are in use")
    );
    assert_eq!(
        as_integer(host.call("deinstantiate", &mut [integer(handles[500])])),
        0
    );
    assert!(host.instantiate() > 0);
}

#[test]
fn arguments_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let host = Host::new(&fixtures::manipulator(), folder.path());
    let handle = host.instantiate();
    let good = GOOD.map(real);
    let simulate =
        |operation: Value, values: [Value; 3]| host.simulate(integer(handle), operation, values);
    assert_eq!(
        as_integer(host.call("get_real", &mut [integer(handle), string(c"seconds")])),
        -2
    );
    for operation in [
        integer(2),
        integer(-1),
        integer(i32::MAX),
        string(c"nothing"),
    ] {
        assert!(simulate(operation, good) == -4.0);
        assert!(host.last_error(handle).contains("there is no operation"));
    }
    for operation in [
        real(0.0),
        Value { tag: 3, bits: 0 },
        Value { tag: 0, bits: 0 },
    ] {
        assert!(simulate(operation, good) == -2.0);
    }
    assert!(simulate(integer(0), [real(90.0), string(c"yes"), real(0.3)]) == -2.0);
    assert!(
        host.last_error(handle)
            .contains("property `grip` must be a real number")
    );
    assert!(simulate(integer(0), [real(91.0), real(1.0), real(0.3)]) == -3.0);
    assert!(simulate(integer(0), [real(90.0), real(0.0), real(0.3)]) == -5.0);
    assert!(host.last_error(handle).contains("(R-12)"));
    // An operation by name, and integers where numbers are expected.
    let by_name = simulate(string(c"turning"), [integer(90), integer(1), real(0.3)]);
    assert!(by_name > 0.0);
    let get = |name: &CStr| host.call("get_real", &mut [integer(handle), string(name)]);
    assert!(as_real(get(c"seconds")) == by_name);
    assert!(as_real(get(c"joules")) > 0.0);
    assert!(as_real(get(c"angle")) == 90.0 && as_real(get(c"property.angle")) == 90.0);
    // A property's name that is also a result's.
    assert!(as_real(get(c"steps")) >= 1.0);
    assert!(as_real(get(c"property.steps")) == 0.3);
    assert_eq!(as_integer(get(c"weight")), -2);
    assert_eq!(
        as_integer(host.call("get_real", &mut [integer(handle), integer(1)])),
        -2
    );
    // After an error the results of the last operation are still available, and the state is
    // unchanged.
    assert!(simulate(integer(0), [real(90.0), real(0.0), real(0.3)]) == -5.0);
    assert!(as_real(get(c"seconds")) == by_name);
    let description = host.call("station_describe", &mut []);
    // SAFETY: a static text.
    let text = unsafe { CStr::from_ptr(description.bits as *const c_char) }
        .to_str()
        .unwrap();
    let json = documents::assert_valid(text.as_bytes()).remove(0);
    assert_eq!(json["schema"], "linewright/station/1");
    assert_eq!(json["exports"]["simulate"], 5);
    assert_eq!(json["plant"][0]["labels"][2], "pick");
}

#[test]
fn plain_steps_check_their_counts() {
    let folder = tempfile::tempdir().unwrap();
    let host = Host::new(&fixtures::belt(), folder.path());
    let handle = host.instantiate();
    let (plant, mut outputs) = ([0_i64, 0], [-1_i64; 4]);
    // SAFETY: the signature of `lw_step`, with pointers to as many values as are promised, or to
    // none.
    unsafe {
        let step: libloading::Symbol<
            '_,
            unsafe extern "C" fn(i32, *const i64, usize, *mut i64, usize) -> i32,
        > = host.0.get("lw_step").unwrap();
        let out = outputs.as_mut_ptr();
        assert_eq!(step(handle, plant.as_ptr(), 1, out, 4), -2);
        assert_eq!(step(handle, std::ptr::null(), 2, out, 4), -2);
        assert_eq!(step(handle, plant.as_ptr(), 2, out, 3), -2);
        assert_eq!(step(handle, plant.as_ptr(), 2, std::ptr::null_mut(), 4), -2);
        assert_eq!(step(0, plant.as_ptr(), 2, out, 4), -1);
        assert_eq!(*out, -1, "left alone on an error");
        assert_eq!(step(handle, plant.as_ptr(), 2, std::ptr::null_mut(), 0), 0);
        assert_eq!(step(handle, plant.as_ptr(), 2, out, 4), 0);
    }
    assert_eq!(outputs, [0, 0, 0, 1]);
}

#[test]
fn threads_share_libraries_and_instances() {
    let folder = tempfile::tempdir().unwrap();
    let (machine, controllers) = fixtures::manipulator();
    let package = Package::emit(&machine, &controllers);
    let built = Toolchain::host()
        .build(&package, folder.path(), false)
        .unwrap();
    let library = Library::open(&built.path).unwrap();
    let alone = library
        .instance()
        .unwrap()
        .simulate(0, &mut GOOD.clone())
        .unwrap();
    // Many instances, one per thread: as if each were alone.
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..200 {
                    let mut instance = library.instance().unwrap();
                    assert_eq!(instance.simulate(0, &mut GOOD.clone()).unwrap(), alone);
                    assert!(instance.simulate(0, &mut [1.0, 1.0, 0.0]).is_err());
                }
            });
        }
    });
    // One instance in several threads, some of which end it: every answer is one that a single
    // thread could get.
    let host = Host::new(&(machine, controllers), folder.path());
    for _ in 0..50 {
        let handle = host.instantiate();
        std::thread::scope(|scope| {
            for thread in 0..4 {
                let host = &host;
                scope.spawn(move || {
                    for call in 0..40 {
                        if thread == 3 && call == 20 {
                            host.call("deinstantiate", &mut [integer(handle)]);
                        }
                        let code = host.simulate(integer(handle), integer(0), GOOD.map(real));
                        assert!(code > 0.0 || code == -1.0, "{code}");
                        let _ = host.call("reset", &mut [integer(handle)]);
                    }
                });
            }
        });
        assert_eq!(as_integer(host.call("reset", &mut [integer(handle)])), -1);
    }
}
