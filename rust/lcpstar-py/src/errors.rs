//! Core errors become the exceptions of `lcpstar.errors`; entering the core catches panics, once, here.

use lcpstar::LcpError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering, fence};
use std::sync::{Mutex, OnceLock};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

/// Runs `f` with the interpreter released. A panic in the core becomes `lcpstar.InternalError`, never a `BaseException`.
pub fn enter_core<T: Send>(py: Python<'_>, f: impl FnOnce() -> lcpstar::Result<T> + Send) -> PyResult<T> {
    let released = || {
        let result = catch_unwind(AssertUnwindSafe(f));
        if !announce_return() {
            park();
        }
        result
    };
    let result = py.detach(released);
    RETURNING.fetch_sub(1, Ordering::SeqCst);
    outcome(py, result)
}

/// Holds this thread until the process ends.
fn park() {
    loop {
        std::thread::park();
    }
}

/// The thread in which the interpreter has begun to shut down.
static CLOSING: OnceLock<ThreadId> = OnceLock::new();
/// Threads on their way from the core to the interpreter.
static RETURNING: AtomicUsize = AtomicUsize::new(0);
/// How long the interpreter waits for them.
const PATIENCE: Duration = Duration::from_secs(1);

/// Called once by the interpreter before it shuts down: lets those in that are waiting for it already.
#[pyfunction]
pub fn close(py: Python<'_>) {
    CLOSING.get_or_init(|| std::thread::current().id());
    fence(Ordering::SeqCst);
    let start = Instant::now();
    while RETURNING.load(Ordering::SeqCst) > 0 && start.elapsed() < PATIENCE {
        py.detach(|| std::thread::sleep(Duration::from_millis(1)));
    }
}

/// Counts this thread among [`RETURNING`], and says whether it may return.
///
/// A daemon thread must not come back to an interpreter that shuts down: before Python 3.14 that unwinds it through
/// Rust, which aborts the process. Either it sees `CLOSING`, or `close` sees it and waits.
fn announce_return() -> bool {
    RETURNING.fetch_add(1, Ordering::SeqCst);
    fence(Ordering::SeqCst);
    let stays = CLOSING.get().is_some_and(|&closing| closing != std::thread::current().id());
    if stays {
        RETURNING.fetch_sub(1, Ordering::SeqCst);
    }
    !stays
}

/// Asks the interpreter from inside the core; `None` when it shuts down and nobody answers.
pub fn ask<T>(question: impl FnOnce(Python<'_>) -> T) -> Option<T> {
    if !announce_return() {
        return None;
    }
    let answer = Python::try_attach(question);
    RETURNING.fetch_sub(1, Ordering::SeqCst);
    answer
}

/// As [`enter_core`] with the interpreter held: for calls that end sooner than it could be released and taken back.
pub fn enter_core_briefly<T>(py: Python<'_>, f: impl FnOnce() -> lcpstar::Result<T>) -> PyResult<T> {
    outcome(py, catch_unwind(AssertUnwindSafe(f)))
}

fn outcome<T>(py: Python<'_>, result: std::thread::Result<lcpstar::Result<T>>) -> PyResult<T> {
    match result {
        Ok(result) => result.map_err(|e| to_python(py, &e)),
        Err(panic) => {
            let text = panic
                .downcast_ref::<&str>()
                .map(ToString::to_string)
                .or_else(|| panic.downcast_ref::<String>().cloned())
                .unwrap_or_else(|| "unknown".to_owned());
            Err(raise(py, "InternalError", &format!("please report this: the core panicked with: {text}")))
        }
    }
}

/// The Python exception of a core error.
pub fn to_python(py: Python<'_>, error: &LcpError) -> PyErr {
    let class = match error {
        LcpError::NotSquare { .. } | LcpError::WrongLength { .. } => "ShapeError",
        LcpError::NotFinite { .. } => "NotFiniteError",
        LcpError::UnknownName { .. } => "UnknownNameError",
        LcpError::BadIndex { .. } => "IndexSetError",
        LcpError::SingularBlock { .. } => "SingularBlockError",
        LcpError::NotStrictlyFeasible { .. } => "StartError",
        LcpError::TooLarge { .. } => "TooLargeError",
        _ => "OptionError",
    };
    raise(py, class, &error.to_string())
}

/// An exception of `lcpstar.errors` by name: the classes have two bases each and live in Python.
pub fn raise(py: Python<'_>, class: &str, message: &str) -> PyErr {
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let module = MODULE.get_or_try_init(py, || py.import("lcpstar.errors").map(Bound::unbind));
    let made = module.and_then(|m| m.bind(py).getattr(class)).and_then(|class| class.call1((message,)));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Ctrl-C while the interpreter is released: asked once per iteration, looks at most every 50 ms, so that a short
/// solve never takes the interpreter back and a long one stops within a blink.
///
/// Python runs signal handlers in its main thread alone, so only the thread that made this looks; those that it started
/// are told. Once true, the answer stays true: whoever asks first, the next one stops as well.
pub struct Signals {
    caller: ThreadId,
    next: Mutex<Instant>,
    interrupted: AtomicBool,
    pending: Mutex<Option<PyErr>>,
}

const SIGNAL_PERIOD: Duration = Duration::from_millis(50);

impl Signals {
    /// A call that begins now.
    pub fn new() -> Self {
        Self::since(Instant::now())
    }

    /// A call that began at `start`.
    pub fn since(start: Instant) -> Self {
        Self {
            caller: std::thread::current().id(),
            next: Mutex::new(start + SIGNAL_PERIOD),
            interrupted: AtomicBool::new(false),
            pending: Mutex::new(None),
        }
    }

    /// Whether a signal handler raised; the exception is kept for [`Signals::raise`].
    pub fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed) || (std::thread::current().id() == self.caller && self.look())
    }

    fn look(&self) -> bool {
        let Ok(mut next) = self.next.try_lock() else { return false };
        let now = Instant::now();
        if now < *next {
            return false;
        }
        *next = now + SIGNAL_PERIOD;
        let Some(Err(error)) = ask(|py| py.check_signals()) else { return false };
        self.pending.lock().map(|mut pending| pending.replace(error)).ok();
        self.interrupted.store(true, Ordering::Relaxed);
        true
    }

    /// Raises what a signal handler raised.
    pub fn raise(&self) -> PyResult<()> {
        match self.pending.lock().ok().and_then(|mut pending| pending.take()) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}
