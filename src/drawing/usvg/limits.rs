//! Bounds the time and memory for reading a document, whatever it makes the libraries do: entities
//! that multiply, thousands of attributes or rules, endless text.
//!
//! The document is read in its own thread, whose allocations are counted. An allocation beyond the
//! bound never returns: the thread sleeps from then on. The caller notices this, or that the thread has
//! used up its CPU time, and abandons the thread, because the libraries cannot be cancelled. CPU time is
//! what counts because a busy machine makes no document a bad one. The thread's stack is large enough
//! for deeply nested documents.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{mpsc, Arc};
use std::time::Duration;

const STACK_BYTES: usize = 64 << 20; // the libraries recurse
const MOST_BYTES: isize = 640 << 20;
const SECONDS: f64 = 3.5;
const SECONDS_PER_MB: f64 = 0.4; // for the part of a document beyond two megabytes

thread_local! {
    static USED: Cell<isize> = const { Cell::new(0) };
    static BOUND: Cell<Option<*const AtomicBool>> = const { Cell::new(None) }; // set when the bound is reached
}

#[repr(C)]
struct TimeSpec {
    seconds: std::ffi::c_long,
    nanoseconds: std::ffi::c_long,
}

extern "C" {
    fn pthread_self() -> usize;
    fn pthread_getcpuclockid(thread: usize, clock: *mut i32) -> i32;
    fn clock_gettime(clock: i32, time: *mut TimeSpec) -> i32;
}

/// The clock of this thread's CPU time, for others to read.
fn own_clock() -> Option<i32> {
    let mut clock = 0;
    (unsafe { pthread_getcpuclockid(pthread_self(), &mut clock) } == 0).then_some(clock)
}

/// CPU time [s]; none where the thread has ended.
fn cpu_seconds(clock: i32) -> Option<f64> {
    let mut time = TimeSpec { seconds: 0, nanoseconds: 0 };
    (unsafe { clock_gettime(clock, &mut time) } == 0).then_some(time.seconds as f64 + 1e-9 * time.nanoseconds as f64)
}

struct Counting;

fn count(bytes: isize) {
    let used = USED.get() + bytes;
    USED.set(used);
    if used > MOST_BYTES {
        if let Some(reached) = BOUND.get() {
            unsafe { &*reached }.store(true, Ordering::Release); // kept alive by the thread that set BOUND
            loop {
                std::thread::sleep(Duration::from_secs(3600));
            }
        }
    }
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        System.alloc(layout)
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        System.dealloc(pointer, layout)
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        System.alloc_zeroed(layout)
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as isize - layout.size() as isize);
        System.realloc(pointer, layout, size)
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Returns read(document), or an error if it panics or exceeds the bounds on time or memory.
pub fn within<T: Send + 'static>(document: Vec<u8>, read: fn(&[u8]) -> Result<T, String>) -> Result<T, String> {
    let gave_up = || "usvg gave up on it".to_string();
    let megabytes = document.len() as f64 / 1e6;
    let seconds = SECONDS + SECONDS_PER_MB * (megabytes - 2.0).max(0.0);
    let reached = Arc::new(AtomicBool::new(false)); // a sleeping thread still refers to it
    let in_thread = reached.clone();
    let (sender, receiver) = mpsc::channel();
    let (clock_sender, clock_receiver) = mpsc::channel();
    let work = move || {
        let _ = clock_sender.send(own_clock());
        BOUND.set(Some(Arc::as_ptr(&in_thread)));
        let result = catch_unwind(AssertUnwindSafe(|| read(&document))).unwrap_or_else(|_| Err(gave_up()));
        BOUND.set(None);
        let _ = sender.send(result);
    };
    let thread = std::thread::Builder::new()
        .stack_size(STACK_BYTES)
        .spawn(work)
        .map_err(|error| format!("no thread to read it in: {error}"))?;
    let clock = clock_receiver.recv().ok().flatten();
    loop {
        match receiver.recv_timeout(Duration::from_millis(20)) {
            Ok(result) => {
                let _ = thread.join(); // a process that forks now has no thread with a lock
                return result;
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => return Err(gave_up()),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
        }
        if reached.load(Ordering::Acquire) {
            return Err(format!("it takes more than {} MB to read", MOST_BYTES >> 20));
        }
        if clock.and_then(cpu_seconds).is_some_and(|used| used > seconds) {
            return Err(format!("it takes longer than {seconds:.1} s to read"));
        }
    }
}
