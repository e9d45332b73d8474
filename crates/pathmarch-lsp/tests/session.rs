//! A session with an editor over a connection in memory.

use lsp_server::{Connection, Message, Notification, Request, Response};
use pathmarch_lsp::{ServeError, serve};
use serde_json::{Value, json};
use std::thread::JoinHandle;
use std::time::Duration;

/// What an editor waits at most.
const PATIENCE: Duration = Duration::from_secs(600);

/// An editor.
struct Editor {
    connection: Connection,
    server: JoinHandle<Result<(), ServeError>>,
    requests: i32,
    /// Diagnostics that arrived while it waited for a response.
    published: Vec<Value>,
}

impl Editor {
    fn start() -> Self {
        let (here, there) = Connection::memory();
        let server = std::thread::spawn(move || serve(&there));
        let mut editor = Self { connection: here, server, requests: 0, published: Vec::new() };
        let snippets = json!({"textDocument": {"completion": {"completionItem": {"snippetSupport": true}}}});
        let answer = editor.ask("initialize", json!({"capabilities": snippets}));
        assert_eq!(answer["capabilities"]["hoverProvider"], true, "{answer}");
        editor.tell("initialized", json!({}));
        editor
    }
    fn tell(&self, method: &str, parameters: Value) {
        let message = Notification::new(method.to_owned(), parameters);
        self.connection.sender.send(message.into()).expect("the server is there");
    }
    fn next(&self) -> Message {
        self.connection.receiver.recv_timeout(PATIENCE).expect("the server answers")
    }
    fn answer(&mut self, method: &str, parameters: Value) -> Response {
        self.requests += 1;
        let request = Request::new(self.requests.into(), method.to_owned(), parameters);
        self.connection.sender.send(request.into()).expect("the server is there");
        loop {
            match self.next() {
                Message::Response(response) => return response,
                Message::Notification(note) => self.published.push(note.params),
                Message::Request(request) => panic!("{request:?}"),
            }
        }
    }
    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        let answer = serde_json::to_value(self.answer(method, parameters)).expect("JSON");
        assert!(answer.get("error").is_none(), "{method}: {answer}");
        answer["result"].clone()
    }
    /// The next diagnostics of a file whose URI ends like this.
    fn diagnostics(&mut self, end: &str) -> Vec<Value> {
        loop {
            let is_of = |note: &Value| note["uri"].as_str().is_some_and(|uri| uri.ends_with(end));
            if let Some(index) = self.published.iter().position(is_of) {
                let note = self.published.remove(index);
                return note["diagnostics"].as_array().expect("a list").clone();
            }
            match self.next() {
                Message::Notification(note) => self.published.push(note.params),
                other => panic!("{other:?}"),
            }
        }
    }
    fn open(&self, uri: &str, text: &str) {
        let document = json!({"uri": uri, "languageId": "pathmarch", "version": 1, "text": text});
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }
    /// Ends the session.
    fn end(mut self) {
        self.ask("shutdown", Value::Null);
        self.tell("exit", Value::Null);
        self.server.join().expect("no panic").expect("a good end");
    }
}

const URI: &str = "file:///nowhere/scene.kdl";

/// A scene with two misspelt names. The comment has characters of one, two and three UTF-16 code units in all.
const BROKEN: &str = "pathmarch 1
camera { position 0 1 5; target 0 1 0 }
sky 1
/* é𝄞 */ material \"gold\" { metal 1 0.78 0.34; roughnes 0.2 }
object  \"ball\" material=\"glod\" { sphere 1 }
";

fn at(line: u32, character: u32) -> Value {
    json!({"textDocument": {"uri": URI}, "position": {"line": line, "character": character}})
}

fn document() -> Value {
    json!({"textDocument": {"uri": URI}})
}

fn range(line: u32, start: u32, end: u32) -> Value {
    json!({"start": {"line": line, "character": start}, "end": {"line": line, "character": end}})
}

#[test]
fn mistakes_are_published_and_vanish_when_they_are_fixed() {
    let mut editor = Editor::start();
    editor.open(URI, BROKEN);
    let found = editor.diagnostics("scene.kdl");
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(found[0]["range"], range(3, 47, 55), "columns are UTF-16 code units: {found:?}");
    assert_eq!((&found[0]["code"], &found[0]["severity"]), (&json!("pathmarch::unknown_node"), &json!(1)));
    assert!(found[0]["message"].as_str().is_some_and(|message| message.contains("Did you mean `roughness`?")));
    assert_eq!(found[1]["range"], range(4, 24, 30));

    // Both quick fixes, as an editor applies them.
    for (line, start, end, title, new) in
        [(3, 47, 55, "Change to `roughness`", "roughness"), (4, 25, 25, "Change to `gold`", "\"gold\"")]
    {
        let mut asked = document();
        asked["range"] = range(line, start, end);
        asked["context"] = json!({"diagnostics": []});
        let actions = editor.ask("textDocument/codeAction", asked);
        assert_eq!((actions.as_array().map(Vec::len), &actions[0]["title"]), (Some(1), &json!(title)), "{actions}");
        let edit = &actions[0]["edit"]["changes"][URI][0];
        assert_eq!(edit["newText"], new, "{actions}");
        let change = json!([{"range": edit["range"], "text": new}]);
        let document = json!({"uri": URI, "version": 2});
        editor.tell("textDocument/didChange", json!({"textDocument": document, "contentChanges": change}));
    }
    let mut left = editor.diagnostics("scene.kdl");
    while !left.is_empty() {
        left = editor.diagnostics("scene.kdl");
    }
    editor.end();
}

#[test]
fn a_scene_is_completed_explained_and_formatted() {
    let mut editor = Editor::start();
    editor.open(URI, BROKEN);
    let items = editor.ask("textDocument/completion", at(3, 50));
    let items = items.as_array().expect("a list");
    let roughness = items.iter().find(|item| item["label"] == "roughness").expect("there");
    assert_eq!(roughness["textEdit"], json!({"range": range(3, 47, 55), "newText": "roughness ${1:0.2}"}));
    assert!(roughness["documentation"]["value"].as_str().is_some_and(|help| help.contains("0 is a mirror")));
    let items = editor.ask("textDocument/completion", at(4, 26));
    assert_eq!(items[0]["textEdit"], json!({"range": range(4, 25, 29), "newText": "gold"}));

    let help = editor.ask("textDocument/hover", at(4, 35));
    assert_eq!(help["range"], range(4, 33, 39));
    assert!(help["contents"]["value"].as_str().is_some_and(|help| help.contains("**shape `sphere`**")), "{help}");
    assert_eq!(editor.ask("textDocument/hover", at(3, 4)), Value::Null, "comments mean nothing");

    let symbols = editor.ask("textDocument/documentSymbol", document());
    let names: Vec<&str> = symbols.as_array().expect("a list").iter().filter_map(|one| one["name"].as_str()).collect();
    assert_eq!(names, ["camera", "sky", "gold", "ball"]);

    let edits = editor.ask(
        "textDocument/formatting",
        json!({"textDocument": {"uri": URI}, "options": {"tabSize": 4, "insertSpaces": true}}),
    );
    assert_eq!(edits.as_array().map(Vec::len), Some(1), "{edits}");
    assert_eq!(edits[0]["newText"], "object \"ball\" material=\"glod\" { sphere 1 }\n", "only the line that changes");

    let change = json!([{"range": range(4, 25, 29), "text": "gold"}]);
    let versioned = json!({"uri": URI, "version": 2});
    editor.tell("textDocument/didChange", json!({"textDocument": versioned, "contentChanges": change}));
    let place = editor.ask("textDocument/definition", at(4, 27));
    assert_eq!(place, json!({"uri": URI, "range": range(3, 19, 25)}));
    editor.end();
}

#[test]
fn colours_are_shown_and_written() {
    let mut editor = Editor::start();
    editor.open(URI, &BROKEN.replace("metal 1 0.78 0.34", "emit 15 7.5 0"));
    let found = editor.ask("textDocument/documentColor", document());
    assert_eq!(found[1]["range"], range(3, 33, 41), "{found}");
    let [red, green, blue] = ["red", "green", "blue"].map(|name| found[1]["color"][name].as_f64().expect("a number"));
    assert!(red == 1.0 && (green - 0.735).abs() < 0.001 && blue == 0.0, "{found}");
    let mut asked = document();
    asked["color"] = json!({"red": 0.0, "green": 1.0, "blue": 0.0, "alpha": 1.0});
    asked["range"] = found[1]["range"].clone();
    let ways = editor.ask("textDocument/colorPresentation", asked.clone());
    assert_eq!(ways.as_array().map(Vec::len), Some(1), "{ways}");
    assert_eq!(ways[0]["label"], "0 15 0", "a lamp keeps its strength");
    asked["range"] = found[0]["range"].clone();
    let ways = editor.ask("textDocument/colorPresentation", asked);
    assert_eq!((&ways[0]["label"], &ways[1]["label"]), (&json!("0 1 0"), &json!("\"#00ff00\"")));
    editor.end();
}

#[test]
fn mistakes_of_included_files_are_published_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path().canonicalize().expect("a path");
    let part = root.join("metals.kdl");
    std::fs::write(&part, "pathmarch 1\nmaterial \"steel\" { metl 0.6 }\n").expect("written");
    let uri = format!("file://{}", root.join("main.kdl").display());
    let mut editor = Editor::start();
    editor.open(
        &uri,
        "pathmarch 1\ninclude \"metals.kdl\"\ncamera { position 0 1 5; target 0 1 0 }\nobject \"a\" { sphere 1 }\n",
    );
    let found = editor.diagnostics("metals.kdl");
    assert_eq!((found.len(), &found[0]["range"]), (1, &range(1, 19, 23)), "{found:?}");
    assert_eq!(editor.diagnostics("main.kdl"), Vec::<Value>::new());
    std::fs::write(&part, "pathmarch 1\nmaterial \"steel\" { metal 0.6 }\n").expect("written");
    editor.tell("textDocument/didSave", json!({"textDocument": {"uri": uri}}));
    assert_eq!(editor.diagnostics("metals.kdl"), Vec::<Value>::new(), "fixed on the disk");
    editor.end();
}

#[test]
fn closed_documents_have_no_mistakes() {
    let mut editor = Editor::start();
    editor.open(URI, BROKEN);
    assert_eq!(editor.diagnostics("scene.kdl").len(), 2);
    editor.tell("textDocument/didClose", document());
    assert_eq!(editor.diagnostics("scene.kdl").len(), 0);
    assert_eq!(editor.ask("textDocument/hover", at(4, 35)), Value::Null);
    editor.end();
}

#[test]
fn what_is_not_understood_is_refused_and_the_session_goes_on() {
    let mut editor = Editor::start();
    editor.tell("textDocument/didOpen", json!({"nonsense": 1}));
    editor.tell("nonsense", Value::Null);
    for (method, parameters, code) in [
        ("nonsense", Value::Null, -32601),
        ("textDocument/hover", json!({"nonsense": 1}), -32602),
        (
            "textDocument/completion",
            json!({"textDocument": {"uri": "%%"}, "position": {"line": 0, "character": 0}}),
            -32602,
        ),
    ] {
        let answer = serde_json::to_value(editor.answer(method, parameters)).expect("JSON");
        assert_eq!(answer["error"]["code"], code, "{method}: {answer}");
    }
    editor.open(URI, BROKEN);
    assert_eq!(editor.diagnostics("scene.kdl").len(), 2);
    let far = editor.ask("textDocument/completion", at(999, 999));
    assert!(far.as_array().is_some_and(|items| items.iter().any(|item| item["label"] == "object")), "{far}");
    editor.end();
}
