//! Tests of the commands for editors, with the program itself: `fmt` and `lsp`.

mod program;

use program::{code, pathmarch, stderr};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};

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

/// Sends a message of the language server protocol.
fn send(input: &mut ChildStdin, message: &Value) {
    let text = message.to_string();
    write!(input, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("the server reads");
}

/// The next message, up to one that fits.
fn receive(output: &mut BufReader<ChildStdout>, fits: impl Fn(&Value) -> bool) -> Value {
    loop {
        let (mut header, mut length) = (String::new(), 0);
        while header != "\r\n" {
            header.clear();
            assert!(output.read_line(&mut header).expect("the server writes") > 0, "the server is gone");
            length =
                header.strip_prefix("Content-Length: ").map_or(length, |text| text.trim().parse().expect("a number"));
        }
        let mut bytes = vec![0; length];
        output.read_exact(&mut bytes).expect("a message");
        let message = serde_json::from_slice(&bytes).expect("JSON");
        if fits(&message) {
            return message;
        }
    }
}

#[test]
fn lsp_serves_an_editor() {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pathmarch"))
        .args(["lsp", "--stdio"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut input = program.stdin.take().expect("a pipe");
    let mut output = BufReader::new(program.stdout.take().expect("a pipe"));
    let request =
        |id: i32, method: &str, params: Value| json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params});
    let note = |method: &str, params: Value| json!({"jsonrpc": "2.0", "method": method, "params": params});
    send(&mut input, &request(1, "initialize", json!({"capabilities": {}})));
    let answer = receive(&mut output, |message| message["id"] == 1);
    assert_eq!(answer["result"]["capabilities"]["colorProvider"], true, "{answer}");
    send(&mut input, &note("initialized", json!({})));
    let uri = "file:///nowhere/wrong.kdl";
    let document = json!({"uri": uri, "languageId": "pathmarch", "version": 1, "text": "pathmarch 1\ncamra 1\n"});
    send(&mut input, &note("textDocument/didOpen", json!({ "textDocument": document })));
    let found = receive(&mut output, |message| message["method"] == "textDocument/publishDiagnostics");
    let wrong = &found["params"]["diagnostics"];
    assert!(
        wrong
            .as_array()
            .is_some_and(|all| all.iter().any(|one| one["range"]["end"] == json!({"line": 1, "character": 5}))),
        "{wrong}"
    );
    let place = json!({"textDocument": {"uri": uri}, "position": {"line": 1, "character": 3}});
    send(&mut input, &request(2, "textDocument/completion", place));
    let answer = receive(&mut output, |message| message["id"] == 2);
    assert!(
        answer["result"].as_array().is_some_and(|all| all.iter().any(|item| item["label"] == "camera")),
        "{answer}"
    );
    send(&mut input, &request(3, "shutdown", Value::Null));
    receive(&mut output, |message| message["id"] == 3);
    send(&mut input, &note("exit", Value::Null));
    drop(input);
    assert_eq!(program.wait().expect("it ends").code(), Some(0));
}

#[test]
fn reference_prints_every_word_as_markdown() {
    let directory = tempfile::tempdir().expect("a directory");
    let output = pathmarch(&["reference"], directory.path());
    let page = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    for part in ["## Shapes", "### sphere", "| `roughness` | number | 0.2 |", "### fbm", "`smoothstep`"] {
        assert!(page.contains(part), "{part}");
    }
}
