//! A test harness for tests that need hardware: a GPU adapter, a display.
//!
//! Whether a machine has them is known only when the tests run, and the standard harness cannot ignore a test then: it
//! would have to pass. Tests of this harness are reported as *ignored*, with the reason, and fail where an environment
//! variable requires the hardware, as in CI. Arguments and output are those of `cargo test` (libtest-mimic); output of
//! tests is not captured. `cargo nextest` lists such tests as ignored, too.
//!
//! A file ends with the list of its tests, [`tests!`]: a function that is missing there is dead code, which the compiler
//! reports, and an attribute `#[test]`, which would do nothing, fails the test [`LISTED`].

use libtest_mimic::{Arguments, Completion, Failed, Trial};
use std::any::Any;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};

/// Something that not every machine has.
pub struct Requirement {
    /// Environment variable that makes tests fail where it is missing.
    pub variable: &'static str,
    /// Reason why this machine does not have it, if so.
    pub missing: fn() -> Option<String>,
}

/// One test.
pub struct Test {
    name: String,
    requirement: Option<&'static Requirement>,
    run: Box<dyn FnOnce() + Send>,
}

impl Test {
    /// A test that every machine can run.
    pub fn new(name: &str, run: impl FnOnce() + Send + 'static) -> Self {
        Self { name: name.to_owned(), requirement: None, run: Box::new(run) }
    }

    /// A test that is ignored where something is missing.
    pub fn requiring(name: &str, requirement: &'static Requirement, run: impl FnOnce() + Send + 'static) -> Self {
        Self { requirement: Some(requirement), ..Self::new(name, run) }
    }

    fn trial(self, listing: bool) -> Trial {
        let Self { name, requirement, run } = self;
        let is_missing = |requirement: &Requirement| !is_set(requirement.variable) && (requirement.missing)().is_some();
        // For programs that read the list and run each test by itself.
        let ignored = listing && requirement.is_some_and(is_missing);
        let outcome = move || {
            if let Some(requirement) = requirement
                && let Some(reason) = (requirement.missing)()
            {
                missing(requirement.variable, reason);
            }
            run();
        };
        let test = Trial::ignorable_test(name, move || match catch_unwind(AssertUnwindSafe(outcome)) {
            Ok(()) => Ok(Completion::Completed),
            Err(payload) => match payload.downcast::<Ignored>() {
                Ok(ignored) => Ok(Completion::ignored_with(ignored.0)),
                Err(payload) => Err(failure(&*payload)),
            },
        });
        test.with_ignored_flag(ignored)
    }
}

fn is_set(variable: &str) -> bool {
    std::env::var_os(variable).is_some()
}

/// The reason why a test is ignored, on its way out of the test.
struct Ignored(String);

fn failure(payload: &(dyn Any + Send)) -> Failed {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or(payload.downcast_ref::<&str>().copied()).unwrap_or("it panicked").into()
}

/// Ends the test that calls it, on its own thread, as ignored.
///
/// # Panics
/// Always: this is how the test ends.
pub fn ignore(reason: impl Display) -> ! {
    // A reason of several lines would break the line of the test.
    resume_unwind(Box::new(Ignored(reason.to_string().split_whitespace().collect::<Vec<_>>().join(" "))))
}

/// Ends the test that calls it as [`ignore`] does, or as failed where the environment variable is set.
///
/// # Panics
/// Always: this is how the test ends.
pub fn missing(variable: &str, reason: impl Display) -> ! {
    assert!(!is_set(variable), "{reason} ({variable} is set)");
    ignore(reason)
}

/// Lists the tests of a file by kind: each kind is a function `fn(name: &str, test) -> impl IntoIterator<Item = Test>`.
/// The names of slow tests contain `slow`, which a quick run skips.
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
    (@speed []) => { "" };
    (@extend $tests:ident $kind:ident $speed:tt $($test:ident)*) => {
        $(
            let name = concat!(module_path!(), "::", $crate::tests!(@speed $speed), stringify!($test));
            // The first part is the crate's.
            $tests.extend($kind(name.split_once("::").map_or(name, |(_, name)| name), $test));
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

/// The kind of tests that need nothing.
pub fn plain(name: &str, test: fn()) -> [Test; 1] {
    [Test::new(name, test)]
}

/// The test that no file contains a test which never runs.
pub const LISTED: &str = "every_test_is_listed";

/// Runs the tests that the command line names, and ends the program. `sources` are the files and directories that
/// contain them.
pub fn run(sources: &[PathBuf], mut tests: Vec<Test>) -> ! {
    let arguments = Arguments::from_args();
    let (sources, names) = (sources.to_vec(), tests.iter().map(|test| test.name.clone()).collect::<Vec<_>>());
    tests.push(Test::new(LISTED, move || sources.iter().for_each(|path| check_listed(path, &names))));
    let trials = tests.into_iter().map(|test| test.trial(arguments.list)).collect();
    libtest_mimic::run(&arguments, trials).exit()
}

/// Fails where a file has an attribute that does nothing here, or where a directory has a file without a test of its name.
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
