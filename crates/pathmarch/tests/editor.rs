//! Tests of the commands for editors, with the program itself: `fmt` and `lsp`.

mod program;

use program::{code, pathmarch, stderr};
use std::io::Write;
use std::process::{Command, Stdio};

const RAGGED: &str = "pathmarch 1\ncamera {position 0 1 5;target 0 1 0} // the only one\n";
const FORMATTED: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 } // the only one\n";

#[test]
fn fmt_writes_formatted_files_and_no_others() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = |name: &str| directory.path().join(name);
    let read = |name: &str| std::fs::read_to_string(file(name)).expect("a file");
    for (name, text) in
        [("ragged.kdl", RAGGED), ("right.kdl", FORMATTED), ("broken.kdl", "camera {"), ("wrong.kdl", "shpere  1")]
    {
        std::fs::write(file(name), text).expect("written");
    }
    let check = pathmarch(&["fmt", "--check", "ragged.kdl", "right.kdl"], directory.path());
    assert_eq!((code(&check), String::from_utf8_lossy(&check.stdout).trim()), (1, "ragged.kdl"));
    assert_eq!(read("ragged.kdl"), RAGGED, "a check writes nothing");

    let output = pathmarch(&["fmt", "broken.kdl", "ragged.kdl", "right.kdl", "wrong.kdl"], directory.path());
    assert_eq!(code(&output), 2, "one is broken");
    let message = stderr(&output);
    assert!(message.contains("This { is never closed.") && message.contains("broken.kdl:1:8"), "{message}");
    assert!(message.contains("formatted ragged.kdl") && !message.contains("formatted right.kdl"), "{message}");
    assert_eq!(read("broken.kdl"), "camera {");
    assert_eq!(read("ragged.kdl"), FORMATTED);
    assert_eq!(read("wrong.kdl"), "shpere 1\n", "mistakes of meaning do not matter");

    let check = pathmarch(&["fmt", "--check", "ragged.kdl", "right.kdl", "wrong.kdl"], directory.path());
    assert_eq!((code(&check), check.stdout.len()), (0, 0));
    let missing = pathmarch(&["fmt", "missing.kdl"], directory.path());
    assert_eq!(code(&missing), 2);
    assert!(stderr(&missing).contains("there is no such file"), "{}", stderr(&missing));
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 4, "nothing else is left behind");
}

#[test]
fn fmt_formats_standard_input() {
    for arguments in [&["fmt", "-"][..], &["fmt", "--stdin"]] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_pathmarch"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        program.stdin.take().expect("a pipe").write_all(RAGGED.as_bytes()).expect("written");
        let output = program.wait_with_output().expect("it ends");
        assert_eq!((code(&output), String::from_utf8_lossy(&output.stdout).as_ref()), (0, FORMATTED));
    }
}
