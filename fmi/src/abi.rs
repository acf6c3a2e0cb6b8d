//! The functions of `fmi3Functions.h` (FMI 3.0.2, 2.3). The only unsafe code: pointers come from the importer, which the standard binds to their lengths.
//!
//! Functions of capabilities that the description does not claim return `fmi3Error`. A panic does not leave the library.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::description::{Description, Type};
use crate::instance::Instance;

/// `fmi3Status`.
pub type Status = c_int;
/// `fmi3OK`.
pub const OK: Status = 0;
/// `fmi3Error`.
pub const ERROR: Status = 3;
/// `fmi3Fatal`.
pub const FATAL: Status = 4;

/// `fmi3LogMessageCallback`.
pub type LogMessage = Option<unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char)>;

/// The target of an `fmi3Instance`.
#[derive(Debug)]
pub struct Component {
    instance: Instance,
    log: Log,
}

#[derive(Clone, Copy, Debug)]
struct Log {
    environment: *mut c_void,
    message: LogMessage,
}

impl Log {
    /// Gives the reason of an error to the importer.
    fn error(self, status: Status, why: &str) {
        let (Some(message), Ok(why)) = (self.message, CString::new(why.replace('\0', " "))) else {
            return;
        };
        // SAFETY: the importer gave the function with its environment for as long as the instance is there; both texts end with 0.
        unsafe { message(self.environment, status, c"error".as_ptr(), why.as_ptr()) };
    }
}

/// Works on an instance; an error goes to its log.
///
/// # Safety
/// `instance` is one of [`fmi3InstantiateCoSimulation`] that was not freed, and no other call works on it.
unsafe fn on(instance: *mut c_void, work: impl FnOnce(&mut Instance) -> Result<(), String>) -> Status {
    // SAFETY: the pointer is that of a box that was leaked, and calls do not overlap, by the contract of this function.
    let Some(component) = (unsafe { instance.cast::<Component>().as_mut() }) else {
        return ERROR;
    };
    let Component { instance, log } = component;
    match catch_unwind(AssertUnwindSafe(|| work(instance))) {
        Ok(Ok(())) => OK,
        Ok(Err(why)) => {
            log.error(ERROR, &why);
            ERROR
        }
        Err(_) => FATAL,
    }
}

/// The text of a pointer.
///
/// # Safety
/// It is null or ends with 0.
unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a str> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: it ends with 0, by the contract of this function.
    unsafe { CStr::from_ptr(pointer) }.to_str().ok()
}

/// A slice of the importer.
///
/// # Safety
/// `pointer` is null or has `length` values.
unsafe fn slice<'a, T>(pointer: *const T, length: usize) -> &'a [T] {
    if pointer.is_null() || length == 0 {
        return &[];
    }
    // SAFETY: it has as many values, by the contract of this function.
    unsafe { std::slice::from_raw_parts(pointer, length) }
}

/// The same to write to.
///
/// # Safety
/// As of [`slice`].
unsafe fn slice_mut<'a, T>(pointer: *mut T, length: usize) -> &'a mut [T] {
    if pointer.is_null() || length == 0 {
        return &mut [];
    }
    // SAFETY: it has as many values, by the contract of this function.
    unsafe { std::slice::from_raw_parts_mut(pointer, length) }
}

/// Writes where the importer wants a value.
///
/// # Safety
/// `pointer` is null or can be written to.
unsafe fn put<T>(pointer: *mut T, value: T) {
    if !pointer.is_null() {
        // SAFETY: by the contract of this function.
        unsafe { pointer.write(value) };
    }
}

/// The version of FMI.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Errors are always logged, and nothing else.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetDebugLogging(_: *mut c_void, _: bool, _: usize, _: *const *const c_char) -> Status {
    OK
}

/// A machine of the files in the resources.
///
/// # Safety
/// The pointers are those of the importer by FMI 3.0.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _required: *const u32,
    _count: usize,
    environment: *mut c_void,
    message: LogMessage,
    _update: *const c_void,
) -> *mut c_void {
    let log = Log { environment, message };
    // SAFETY: texts of the importer end with 0.
    let (token, resources) = unsafe { (text(token), text(resources)) };
    let read = catch_unwind(|| {
        let resources = resources.ok_or("the FMU has no resources")?;
        let description = Description::read(Path::new(resources))?;
        match token.map(str::trim) {
            Some(token) if token == description.token => Ok(Instance::new(description)),
            _ => Err("the instantiation token is not that of the resources".to_owned()),
        }
    });
    match read {
        Ok(Ok(instance)) => Box::into_raw(Box::new(Component { instance, log })).cast(),
        Ok(Err(why)) => {
            log.error(ERROR, &why);
            std::ptr::null_mut()
        }
        Err(_) => std::ptr::null_mut(),
    }
}

/// Frees an instance.
///
/// # Safety
/// It is one that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: it comes from `Box::into_raw` and is freed once, by the contract of this function.
        drop(unsafe { Box::from_raw(instance.cast::<Component>()) });
    }
}

/// Takes the time of tick 0.
///
/// # Safety
/// As of [`fmi3FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _: bool,
    _: f64,
    start: f64,
    _: bool,
    _: f64,
) -> Status {
    // SAFETY: by the contract of this function.
    unsafe {
        on(instance, |instance| {
            instance.set_start(start);
            Ok(())
        })
    }
}

/// Begins tick 0 and the program.
///
/// # Safety
/// As of [`fmi3FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> Status {
    // SAFETY: by the contract of this function.
    unsafe {
        on(instance, |instance| {
            instance.begin();
            Ok(())
        })
    }
}

/// The machine before its first tick.
///
/// # Safety
/// As of [`fmi3FreeInstance`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> Status {
    // SAFETY: by the contract of this function.
    unsafe { on(instance, Instance::reset) }
}

/// Lets ticks pass.
///
/// # Safety
/// As of [`fmi3FreeInstance`]; the other pointers can be written to.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    point: f64,
    step: f64,
    _: bool,
    event: *mut bool,
    terminate: *mut bool,
    early: *mut bool,
    last: *mut f64,
) -> Status {
    let mut time = point;
    // SAFETY: by the contract of this function.
    unsafe {
        let status = on(instance, |instance| {
            let stepped = instance.step_to(point + step);
            time = if stepped.is_ok() { point + step } else { instance.time() };
            stepped
        });
        put(event, false);
        put(terminate, false);
        put(early, false);
        put(last, time);
        status
    }
}

macro_rules! variables {
    ($($get:ident, $set:ident: $rust:ty, $of:ident, $out:expr, $in:expr;)*) => {$(
        /// Reads variables.
        ///
        /// # Safety
        /// As of [`fmi3FreeInstance`]; arrays have their lengths.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut $rust, length: usize,
        ) -> Status {
            // SAFETY: by the contract of this function.
            unsafe {
                let (references, values) = (slice(references, count), slice_mut(values, length));
                on(instance, |instance| {
                    if references.len() != values.len() {
                        return Err(format!("{} values of {} variables", values.len(), references.len()));
                    }
                    for (reference, value) in references.iter().zip(values) {
                        *value = $out(instance.get(*reference, Type::$of)?);
                    }
                    Ok(())
                })
            }
        }

        /// Writes inputs and parameters.
        ///
        /// # Safety
        /// As of [`fmi3FreeInstance`]; arrays have their lengths.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const $rust, length: usize,
        ) -> Status {
            // SAFETY: by the contract of this function.
            unsafe {
                let (references, values) = (slice(references, count), slice(values, length));
                on(instance, |instance| {
                    if references.len() != values.len() {
                        return Err(format!("{} values of {} variables", values.len(), references.len()));
                    }
                    for (reference, value) in references.iter().zip(values) {
                        instance.set(*reference, Type::$of, $in(*value))?;
                    }
                    Ok(())
                })
            }
        }
    )*};
}

variables! {
    fmi3GetFloat64, fmi3SetFloat64: f64, Float64, |value: f64| value, |value: f64| value;
    fmi3GetInt32, fmi3SetInt32: i32, Int32, |value: f64| value as i32, f64::from;
    fmi3GetBoolean, fmi3SetBoolean: bool, Boolean, |value: f64| value != 0.0, |value: bool| f64::from(u8::from(value));
}

/// Functions that have nothing to do.
macro_rules! nothing {
    ($($name:ident)*) => {$(
        /// Has no effect.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(_: *mut c_void) -> Status {
            OK
        }
    )*};
}

nothing! { fmi3Terminate }

/// Functions of capabilities that the FMU does not have.
macro_rules! none {
    ($($name:ident($($argument:ty),*);)*) => {$(
        /// The FMU does not have this capability.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(_: *mut c_void $(, _: $argument)*) -> Status {
            ERROR
        }
    )*};
}

type References = *const u32;
type In<T> = *const T;
type Out<T> = *mut T;

none! {
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EvaluateDiscreteStates();
    fmi3EnterContinuousTimeMode();
    fmi3UpdateDiscreteStates(Out<bool>, Out<bool>, Out<bool>, Out<bool>, Out<bool>, Out<f64>);
    fmi3CompletedIntegratorStep(bool, Out<bool>, Out<bool>);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(In<f64>, usize);
    fmi3GetContinuousStateDerivatives(Out<f64>, usize);
    fmi3GetEventIndicators(Out<f64>, usize);
    fmi3GetContinuousStates(Out<f64>, usize);
    fmi3GetNominalsOfContinuousStates(Out<f64>, usize);
    fmi3GetNumberOfEventIndicators(Out<usize>);
    fmi3GetNumberOfContinuousStates(Out<usize>);
    fmi3GetFloat32(References, usize, Out<f32>, usize);
    fmi3SetFloat32(References, usize, In<f32>, usize);
    fmi3GetInt8(References, usize, Out<i8>, usize);
    fmi3SetInt8(References, usize, In<i8>, usize);
    fmi3GetUInt8(References, usize, Out<u8>, usize);
    fmi3SetUInt8(References, usize, In<u8>, usize);
    fmi3GetInt16(References, usize, Out<i16>, usize);
    fmi3SetInt16(References, usize, In<i16>, usize);
    fmi3GetUInt16(References, usize, Out<u16>, usize);
    fmi3SetUInt16(References, usize, In<u16>, usize);
    fmi3GetUInt32(References, usize, Out<u32>, usize);
    fmi3SetUInt32(References, usize, In<u32>, usize);
    fmi3GetInt64(References, usize, Out<i64>, usize);
    fmi3SetInt64(References, usize, In<i64>, usize);
    fmi3GetUInt64(References, usize, Out<u64>, usize);
    fmi3SetUInt64(References, usize, In<u64>, usize);
    fmi3GetString(References, usize, Out<In<c_char>>, usize);
    fmi3SetString(References, usize, In<In<c_char>>, usize);
    fmi3GetBinary(References, usize, Out<usize>, Out<In<u8>>, usize);
    fmi3SetBinary(References, usize, In<usize>, In<In<u8>>, usize);
    fmi3GetClock(References, usize, Out<bool>);
    fmi3SetClock(References, usize, In<bool>);
    fmi3GetNumberOfVariableDependencies(u32, Out<usize>);
    fmi3GetVariableDependencies(u32, Out<usize>, Out<u32>, Out<usize>, Out<c_int>, usize);
    fmi3GetFMUState(Out<*mut c_void>);
    fmi3SetFMUState(*mut c_void);
    fmi3FreeFMUState(Out<*mut c_void>);
    fmi3SerializedFMUStateSize(*mut c_void, Out<usize>);
    fmi3SerializeFMUState(*mut c_void, Out<u8>, usize);
    fmi3DeserializeFMUState(In<u8>, usize, Out<*mut c_void>);
    fmi3GetDirectionalDerivative(References, usize, References, usize, In<f64>, usize, Out<f64>, usize);
    fmi3GetAdjointDerivative(References, usize, References, usize, In<f64>, usize, Out<f64>, usize);
    fmi3GetIntervalDecimal(References, usize, Out<f64>, Out<c_int>);
    fmi3GetIntervalFraction(References, usize, Out<u64>, Out<u64>, Out<c_int>);
    fmi3GetShiftDecimal(References, usize, Out<f64>);
    fmi3GetShiftFraction(References, usize, Out<u64>, Out<u64>);
    fmi3SetIntervalDecimal(References, usize, In<f64>);
    fmi3SetIntervalFraction(References, usize, In<u64>, In<u64>);
    fmi3SetShiftDecimal(References, usize, In<f64>);
    fmi3SetShiftFraction(References, usize, In<u64>, In<u64>);
    fmi3GetOutputDerivatives(References, usize, In<i32>, Out<f64>, usize);
    fmi3ActivateModelPartition(u32, f64);
}

/// The FMU is for co-simulation only.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateModelExchange(
    _: In<c_char>,
    _: In<c_char>,
    _: In<c_char>,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: LogMessage,
) -> *mut c_void {
    std::ptr::null_mut()
}

/// The FMU is for co-simulation only.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub extern "C" fn fmi3InstantiateScheduledExecution(
    _: In<c_char>,
    _: In<c_char>,
    _: In<c_char>,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: LogMessage,
    _: In<c_void>,
    _: In<c_void>,
    _: In<c_void>,
) -> *mut c_void {
    std::ptr::null_mut()
}
