//! Test harness for tests that need hardware: a GPU adapter or a display.
//!
//! Whether a machine has it is known only at run time, when the standard harness can no longer ignore a test. This
//! harness reports such tests as *ignored*, with the reason, or as failed if an environment variable requires the
//! hardware, as in CI. Arguments and output are those of `cargo test` (libtest-mimic); the output of tests is not
//! captured. `PATHMARCH_TEST_TIMES=FILE` records how long each took. `cargo nextest` also lists them as ignored.
//!
//! A test file ends with the list of its tests, [`tests!`]. A function missing from the list is dead code, which the
//! compiler reports; an attribute `#[test]`, which would have no effect, fails the test [`LISTED`].

use libtest_mimic::{Arguments, Completion, Failed, Trial};
use std::any::Any;
use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What not every run has: hardware, or the time for long tests.
pub struct Requirement {
    /// Environment variable that makes tests fail without it.
    pub variable: &'static str,
    /// Reason why it is missing; `None` if it is there.
    pub missing: fn() -> Option<String>,
}

/// A test.
pub struct Test {
    name: String,
    requirements: Vec<&'static Requirement>,
    run: Box<dyn FnOnce() + Send>,
}

impl Test {
    /// Creates a test that runs on every machine.
    pub fn new(name: &str, run: impl FnOnce() + Send + 'static) -> Self {
        Self { name: name.to_owned(), requirements: Vec::new(), run: Box::new(run) }
    }

    /// Creates a test that is ignored if the hardware is missing.
    pub fn requiring(name: &str, requirement: &'static Requirement, run: impl FnOnce() + Send + 'static) -> Self {
        Self { requirements: vec![requirement], ..Self::new(name, run) }
    }

    /// The same test, ignored unless `PATHMARCH_LONG_TESTS` is set.
    #[must_use]
    pub fn long(mut self) -> Self {
        self.requirements.push(&LONG_TESTS);
        self
    }

    fn trial(self, listing: bool) -> Trial {
        let Self { name, requirements, run } = self;
        let is_missing =
            |requirement: &&Requirement| !is_set(requirement.variable) && (requirement.missing)().is_some();
        // For programs that list the tests and run each one separately.
        let ignored = listing && requirements.iter().any(is_missing);
        let outcome = move || {
            for requirement in requirements {
                if let Some(reason) = (requirement.missing)() {
                    missing(requirement.variable, reason);
                }
            }
            run();
        };
        let label = name.clone();
        let test = Trial::ignorable_test(name, move || {
            let start = Instant::now();
            let outcome = catch_unwind(AssertUnwindSafe(outcome));
            record_time(&label, start.elapsed());
            match outcome {
                Ok(()) => Ok(Completion::Completed),
                Err(payload) => match payload.downcast::<Ignored>() {
                    Ok(ignored) => Ok(Completion::ignored_with(ignored.0)),
                    Err(payload) => Err(failure(&*payload)),
                },
            }
        });
        test.with_ignored_flag(ignored)
    }
}

/// Appends the time of a test, seconds, and its name to the file that `PATHMARCH_TEST_TIMES` names.
fn record_time(name: &str, time: Duration) {
    let Some(path) = std::env::var_os("PATHMARCH_TEST_TIMES") else { return };
    let file = OpenOptions::new().create(true).append(true).open(path);
    // Without the file the test's own outcome still counts.
    let _ = file.and_then(|mut file| file.write_all(format!("{:8.2} {name}\n", time.as_secs_f64()).as_bytes()));
}

/// Time for long tests, which only the environment gives.
static LONG_TESTS: Requirement = Requirement {
    variable: "PATHMARCH_LONG_TESTS",
    missing: || {
        let variable = LONG_TESTS.variable;
        (!is_set(variable)).then(|| format!("a long test; {variable}=1 runs it"))
    },
};

/// Cases of a test: every `step`-th from the first on, or all if `PATHMARCH_LONG_TESTS` is set.
///
/// ```
/// let cases = pathmarch_testing::some_of(1..=9, 4);
/// # if std::env::var_os("PATHMARCH_LONG_TESTS").is_none() {
/// assert_eq!(cases.collect::<Vec<_>>(), [1, 5, 9]);
/// # }
/// ```
pub fn some_of<T>(cases: impl IntoIterator<Item = T>, step: usize) -> impl Iterator<Item = T> {
    cases.into_iter().step_by(if long_tests_run() { 1 } else { step })
}

/// True if `PATHMARCH_LONG_TESTS` is set, so that tests go through all of their cases.
pub fn long_tests_run() -> bool {
    is_set(LONG_TESTS.variable)
}

fn is_set(variable: &str) -> bool {
    std::env::var_os(variable).is_some()
}

/// Panic payload that marks a test as ignored, with the reason.
struct Ignored(String);

fn failure(payload: &(dyn Any + Send)) -> Failed {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or(payload.downcast_ref::<&str>().copied()).unwrap_or("it panicked").into()
}

/// Ends the calling test as ignored; call it on the test's own thread.
///
/// # Panics
/// Always: this is how the test ends.
pub fn ignore(reason: impl Display) -> ! {
    // A line break in the reason would break the line of the test.
    resume_unwind(Box::new(Ignored(reason.to_string().split_whitespace().collect::<Vec<_>>().join(" "))))
}

/// Ends the calling test as [`ignore`] does, or as failed if the environment variable is set.
///
/// # Panics
/// Always: this is how the test ends.
pub fn missing(variable: &str, reason: impl Display) -> ! {
    assert!(!is_set(variable), "{reason} ({variable} is set)");
    ignore(reason)
}

/// Lists the tests of a file by kind. A kind is a function `fn(name: &str, test) -> impl IntoIterator<Item = Test>`.
/// Slow tests get `slow` in their names, so that a quick run can skip them; long ones do so, too, and are
/// ignored unless `PATHMARCH_LONG_TESTS` is set.
///
/// ```
/// use pathmarch_testing::{plain, tests};
///
/// fn addition() {
///     assert_eq!(1 + 1, 2);
/// }
/// fn every_sum() {
///     (0..1000).for_each(|n| assert_eq!((0..=n).sum::<i32>(), n * (n + 1) / 2));
/// }
///
/// tests! {
///     plain: [addition],
///     plain slow: [every_sum],
/// }
/// # fn main() {
/// assert_eq!(tests().len(), 2);
/// # }
/// ```
#[macro_export]
macro_rules! tests {
    (@speed [slow]) => { "slow::" };
    (@speed [long]) => { "slow::" };
    (@speed []) => { "" };
    (@when [long] $tests:expr) => { $tests.into_iter().map($crate::Test::long) };
    (@when $speed:tt $tests:expr) => { $tests };
    (@extend $tests:ident $kind:ident $speed:tt $($test:ident)*) => {
        $(
            let name = concat!(module_path!(), "::", $crate::tests!(@speed $speed), stringify!($test));
            // Remove the name of the crate.
            let tests = $kind(name.split_once("::").map_or(name, |(_, name)| name), $test);
            $tests.extend($crate::tests!(@when $speed tests));
        )*
    };
    ($($kind:ident $($speed:ident)?: [$($test:ident),* $(,)?]),* $(,)?) => {
        /// The tests of this file.
        pub fn tests() -> Vec<$crate::Test> {
            let mut tests = Vec::new();
            $($crate::tests!(@extend tests $kind [$($speed)?] $($test)*);)*
            tests
        }
    };
}

/// Kind of tests that need no hardware.
pub fn plain(name: &str, test: fn()) -> [Test; 1] {
    [Test::new(name, test)]
}

/// Name of the test that checks the lists of tests.
pub const LISTED: &str = "every_test_is_listed";

/// Runs the tests selected on the command line, then exits. `sources` are the files and directories of the tests.
pub fn run(sources: &[PathBuf], mut tests: Vec<Test>) -> ! {
    let arguments = Arguments::from_args();
    let (sources, names) = (sources.to_vec(), tests.iter().map(|test| test.name.clone()).collect::<Vec<_>>());
    tests.push(Test::new(LISTED, move || sources.iter().for_each(|path| check_listed(path, &names))));
    let trials = tests.into_iter().map(|test| test.trial(arguments.list)).collect();
    libtest_mimic::run(&arguments, trials).exit()
}

/// Fails if a file contains `#[test]`, or if a directory has a file without listed tests.
fn check_listed(path: &Path, names: &[String]) {
    if !path.is_dir() {
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        for (number, line) in text.lines().enumerate() {
            let place = format!("{}:{}", path.display(), number + 1);
            assert!(line.trim() != "#[test]", "{place}: list the test in `tests!` at the end of the file instead");
        }
        return;
    }
    for entry in std::fs::read_dir(path).expect("a directory of tests") {
        let path = entry.expect("a file").path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default().to_owned();
        if path.extension().is_some_and(|extension| extension == "rs") {
            check_listed(&path, names);
            let listed = stem == "main" || names.iter().any(|name| name.starts_with(&format!("{stem}::")));
            assert!(listed, "{}: no test of this file is run; list the file in main.rs", path.display());
        }
    }
}
