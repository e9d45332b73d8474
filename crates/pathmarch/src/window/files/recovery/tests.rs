//! Tests of crash recovery.

use super::abandoned::lock_of;
use super::format::{FIRST_LINE, LAST_LINE};
use super::*;
#[cfg(unix)]
use std::ffi::OsString;

fn directory() -> tempfile::TempDir {
    tempfile::tempdir().expect("a directory")
}

/// Simulates a crash: the work remains, and nobody holds its lock.
fn crash(mut recovery: Recovery) {
    recovery.flush();
    drop(recovery);
}

#[test]
fn texts_and_paths_come_back_byte_for_byte() {
    let directory = directory();
    let mut paths = vec![None, Some(PathBuf::from("/a b/ü%41 // x: y.kdl")), Some(PathBuf::from("/line\nbreak\r.kdl"))];
    #[cfg(unix)]
    paths.push(Some(PathBuf::from(<OsString as std::os::unix::ffi::OsStringExt>::from_vec(b"/\xff\xfe.kdl".to_vec()))));
    let texts = ["", "\n", "a\r\nb\r\n", "no end", "// text:\n// scene: /x\n", "\u{feff}ü\0", "pathmarch 1\n"];
    for path in &paths {
        for text in texts {
            let mut recovery = Recovery::new(directory.path());
            recovery.keep(path.as_deref(), text, None);
            let file = recovery.file().to_owned();
            crash(recovery);
            let mut found = find_abandoned_work(directory.path());
            assert_eq!(found.len(), 1);
            let found = found.remove(0);
            assert_eq!((&found.scene_path, found.text.as_deref(), &found.file), (path, Ok(text), &file));
            assert!(found.saved_at.elapsed().unwrap_or_default() < Duration::from_secs(600));
            found.discard().expect("removed");
            assert_eq!(fs::read_dir(directory.path()).expect("there").count(), 0);
        }
    }
}

/// Output of `printf old | sha256sum`.
const HASH_OF_OLD: &str = "cba06b5736faf67e54b07b561eae94395e774c517a7d910a54369e1263ccfbd4";

#[test]
fn work_knows_which_version_of_the_file_it_is_based_on() {
    let directory = directory();
    let path = Path::new("/a.kdl");
    let left = |base: Option<&str>, then: Option<&str>| {
        let mut recovery = Recovery::new(directory.path());
        recovery.keep(Some(path), "mine", base);
        recovery.flush();
        // The same text with another base is stored again.
        recovery.keep(Some(path), "mine", then);
        crash(recovery);
        find_abandoned_work(directory.path()).remove(0)
    };
    for (base, then) in [("old", "old"), ("older", "old"), ("", "old")] {
        let found = left(Some(base), Some(then));
        assert!(found.is_based_on("old") && !found.is_based_on("older") && !found.is_based_on("mine"));
        let text = fs::read_to_string(&found.file).expect("read");
        assert!(text.contains(&format!("// based on: sha256 {HASH_OF_OLD}\n")), "{text}");
        found.discard().expect("removed");
    }
    // An empty file is a version, too; an unknown version is none.
    let found = left(Some(""), Some(""));
    assert!(found.is_based_on(""));
    found.discard().expect("removed");
    let found = left(Some("old"), None);
    assert!(!found.is_based_on("old") && !found.is_based_on(""));
    found.discard().expect("removed");
}

#[test]
fn files_of_older_programs_open_without_a_version() {
    let directory = directory();
    let file = directory.path().join(format!("1-1-0.{KEPT}"));
    for line in ["", "// based on: \n", "// based on: sha256 12\n", "// based on: md5 99\n", "// other: thing\n"] {
        let old = format!(
            "{FIRST_LINE}\n// scene: /x.kdl\n// saved: 7\n// program: 0.1.0\n{line}// bytes: 4\n{LAST_LINE}\nabcd"
        );
        fs::write(&file, old).expect("written");
        let found = find_abandoned_work(directory.path()).remove(0);
        assert_eq!(found.text.as_deref(), Ok("abcd"));
        assert!(!found.is_based_on("abcd") && !found.is_based_on(""), "{line}");
    }
}

#[test]
fn only_unsaved_work_is_kept() {
    let directory = directory();
    let mut recovery = Recovery::new(directory.path());
    let path = Path::new("/a.kdl");
    recovery.keep(Some(path), "a", Some("a"));
    recovery.flush();
    assert!(!recovery.file().exists());
    recovery.keep(Some(path), "b", Some("a"));
    recovery.flush();
    assert!(recovery.file().exists());
    recovery.keep(Some(path), "a", Some("a"));
    recovery.flush();
    assert!(!recovery.file().exists());
    recovery.keep(Some(path), "c", Some("a"));
    recovery.clear();
    drop(recovery);
    assert_eq!(fs::read_dir(directory.path()).expect("there").count(), 0, "neither work nor lock");
}

#[test]
fn the_last_of_many_changes_is_kept() {
    let directory = directory();
    let mut recovery = Recovery::new(directory.path());
    for number in 0..1000 {
        recovery.keep(None, &number.to_string(), None);
    }
    drop(recovery);
    assert_eq!(find_abandoned_work(directory.path())[0].text.as_deref(), Ok("999"));
}

#[test]
fn the_work_of_a_running_window_is_not_listed() {
    let directory = directory();
    let (mut one, mut two) = (Recovery::new(directory.path()), Recovery::new(directory.path()));
    one.keep(None, "one", None);
    two.keep(None, "two", None);
    one.flush();
    two.flush();
    assert_ne!(one.file(), two.file());
    assert!(find_abandoned_work(directory.path()).is_empty());
    drop(one);
    let found = find_abandoned_work(directory.path());
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].text.as_deref(), Ok("one"));
}

#[test]
fn a_process_that_was_killed_leaves_its_work() {
    let directory = directory();
    let recovery = {
        let mut recovery = Recovery::new(directory.path());
        recovery.keep(None, "work", None);
        recovery.flush();
        recovery
    };
    // A copy simulates the files that a killed process leaves: the lock file exists, and nobody holds the lock.
    let elsewhere = tempfile::tempdir().expect("a directory");
    for entry in fs::read_dir(directory.path()).expect("there") {
        let path = entry.expect("an entry").path();
        fs::copy(&path, elsewhere.path().join(path.file_name().expect("a name"))).expect("copied");
    }
    assert!(find_abandoned_work(directory.path()).is_empty());
    let found = find_abandoned_work(elsewhere.path());
    assert_eq!(found[0].text.as_deref(), Ok("work"));
    drop(recovery);
}

#[test]
fn damaged_files_are_listed_and_stay() {
    let directory = directory();
    let whole = format!("{FIRST_LINE}\n// scene: /x.kdl\n// saved: 7\n// bytes: 4\n{LAST_LINE}\nabcd");
    let mut contents: Vec<Vec<u8>> = (0..whole.len()).map(|end| whole.as_bytes()[..end].to_vec()).collect();
    contents.push(b"\xff\xfe\n\n".to_vec());
    contents.push(whole.replace("abcd", "abcde").into_bytes());
    contents.push(whole.replace("saved: 7", "saved: 99999999999999999999").replace("abcd", "abc").into_bytes());
    contents.push([whole.replace("bytes: 4\n", "bytes: x\n").as_bytes(), b"\xff"].concat());
    let file = directory.path().join(format!("1-1-0.{KEPT}"));
    for content in contents {
        fs::write(&file, &content).expect("written");
        let found = find_abandoned_work(directory.path());
        assert_eq!(found.len(), 1);
        let message = found[0].text.as_ref().expect_err("it is damaged");
        assert!(message.contains(KEPT), "{message}");
        assert!(file.exists());
    }
    fs::write(&file, whole).expect("written");
    let found = find_abandoned_work(directory.path());
    assert_eq!(found[0].text.as_deref(), Ok("abcd"));
    assert_eq!(found[0].saved_at, UNIX_EPOCH + Duration::from_secs(7));
    assert_eq!(found[0].scene_path.as_deref(), Some(Path::new("/x.kdl")));
}

#[test]
fn old_locks_without_work_are_removed() {
    let directory = directory();
    let running = Recovery::new(directory.path());
    let path = |name: &str| directory.path().join(name);
    for name in ["1-1-0.lock", "2-2-0.lock", "2-2-0.unsaved.kdl"] {
        fs::write(path(name), "").expect("written");
    }
    let long_ago = SystemTime::now() - Duration::from_secs(7 * 24 * 60 * 60);
    for entry in fs::read_dir(directory.path()).expect("there") {
        let file = OpenOptions::new().write(true).open(entry.expect("an entry").path()).expect("opened");
        file.set_modified(long_ago).expect("set");
    }
    fs::write(path("3-3-0.lock"), "").expect("written");
    remove_stale_locks(directory.path());
    let left = ["1-1-0.lock", "2-2-0.lock", "2-2-0.unsaved.kdl", "3-3-0.lock"].map(|name| path(name).exists());
    assert_eq!(left, [false, true, true, true]);
    assert!(lock_of(running.file()).exists());
}

#[test]
fn a_failure_to_store_work_is_reported() {
    let directory = directory();
    let in_the_way = directory.path().join("file");
    fs::write(&in_the_way, "").expect("written");
    let mut recovery = Recovery::new(&in_the_way.join("recovery"));
    assert!(recovery.problem().expect("a problem").contains("file"));
    recovery.keep(None, "a", None);
    recovery.flush();
    recovery.clear();
    assert!(find_abandoned_work(&in_the_way).is_empty());

    let mut recovery = Recovery::new(directory.path());
    assert_eq!(recovery.problem(), None);
    fs::create_dir(recovery.file()).expect("made");
    recovery.keep(None, "a", None);
    recovery.flush();
    let message = recovery.problem().expect("a problem");
    assert!(message.contains("crash recovery failed"), "{message}");
}
