//! The language server, asked as an editor asks it: over pipes, in the words of the protocol.

use crate::folder;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

const URI: &str = "file:///tmp/model%20a.formula";

/// An editor with its server.
struct EditorSession {
    server: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    asked: i32,
}

impl EditorSession {
    /// Starts the server without a word.
    fn silent() -> Self {
        let home = folder();
        let mut server = Command::new(env!("CARGO_BIN_EXE_illuminator"))
            .arg("lsp")
            .env("HOME", home.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the server starts");
        let (to, from) = (server.stdin.take().expect("a pipe"), server.stdout.take().expect("a pipe"));
        Self { server, to, from: BufReader::new(from), asked: 0 }
    }

    /// Starts the server and greets it.
    fn begun() -> Self {
        let mut session = Self::silent();
        let capabilities = json!({"textDocument": {"hover": {"contentFormat": ["markdown", "plaintext"]}}});
        let answer = session.ask("initialize", &json!({"processId": null, "rootUri": null, "capabilities": capabilities}));
        let offered = &answer["result"]["capabilities"];
        assert_eq!(offered["textDocumentSync"]["change"], 2, "{answer}");
        for provider in ["hoverProvider", "definitionProvider", "documentFormattingProvider", "referencesProvider"] {
            assert_eq!(offered[provider], true, "{answer}");
        }
        assert_eq!(offered["renameProvider"]["prepareProvider"], true);
        session.tell("initialized", &json!({}));
        session
    }

    fn write(&mut self, bytes: &[u8]) {
        self.to.write_all(bytes).and_then(|()| self.to.flush()).expect("the server reads");
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        self.write(format!("Content-Length: {}\r\n\r\n{text}", text.len()).as_bytes());
    }

    fn tell(&mut self, method: &str, params: &Value) {
        self.send(&json!({"jsonrpc": "2.0", "method": method, "params": params}));
    }

    /// The answer to a request. Nothing else may come before it.
    fn ask(&mut self, method: &str, params: &Value) -> Value {
        self.asked += 1;
        self.send(&json!({"jsonrpc": "2.0", "id": self.asked, "method": method, "params": params}));
        let answer = self.heard();
        assert_eq!(answer["id"], self.asked, "{answer}");
        answer
    }

    /// The next message of the server.
    fn heard(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(self.from.read_line(&mut line).expect("a line") > 0, "the server has ended");
            match line.trim_end().split_once(": ") {
                Some(("Content-Length", bytes)) => length = bytes.parse().expect("a number"),
                Some(_) => {}
                None => break,
            }
        }
        let mut text = vec![0; length];
        self.from.read_exact(&mut text).expect("a message");
        serde_json::from_slice(&text).expect("JSON")
    }

    /// Opens a text. Returns what is wrong with it.
    fn open(&mut self, language: &str, text: &str) -> Vec<Value> {
        let document = json!({"uri": URI, "languageId": language, "version": 1, "text": text});
        self.tell("textDocument/didOpen", &json!({"textDocument": document}));
        self.published(1)
    }

    fn published(&mut self, version: i32) -> Vec<Value> {
        let heard = self.heard();
        assert_eq!(heard["method"], "textDocument/publishDiagnostics", "{heard}");
        assert_eq!((&heard["params"]["uri"], &heard["params"]["version"]), (&json!(URI), &json!(version)));
        heard["params"]["diagnostics"].as_array().expect("a list").clone()
    }

    /// The answer at a place of the open text.
    fn ask_at(&mut self, method: &str, line: u32, character: u32, more: &Value) -> Value {
        let mut params = json!({"textDocument": {"uri": URI}, "position": {"line": line, "character": character}});
        let fields = more.as_object().cloned().unwrap_or_default();
        params.as_object_mut().expect("fields").extend(fields);
        self.ask(method, &params)
    }

    /// Says goodbye. Returns the exit status.
    fn end(mut self) -> Option<i32> {
        assert_eq!(self.ask("shutdown", &Value::Null)["result"], Value::Null);
        self.tell("exit", &Value::Null);
        self.server.wait().expect("the server ends").code()
    }
}

fn range(start: [u32; 2], end: [u32; 2]) -> Value {
    let place = |[line, character]: [u32; 2]| json!({"line": line, "character": character});
    json!({"start": place(start), "end": place(end)})
}

/// A formula with a character that is two UTF-16 units long in front of names.
const TEXT: &str = "body_specific;\nkd: scalar, default 0.5; // the matte part\nformula;\nF(x) = x*kd;\n/* 😀 */ = F(1)*IL*Cb;\n";

#[test]
fn a_formula_is_written_with_the_help_of_the_server() {
    let mut editor = EditorSession::begun();
    let found = editor.open("illuminator-formula", TEXT);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0]["range"], range([4, 19], [4, 21]));
    let told = "`Cb` is not known\nno parameter, macro, variable or function has this name\n\
                help: declare it, as in `Cb: scalar, constraint 0..1, slider;`";
    assert_eq!(found[0]["message"], told);

    let change = json!({"range": range([4, 20], [4, 21]), "text": "d"});
    let changed = json!({"textDocument": {"uri": URI, "version": 2}, "contentChanges": [change]});
    editor.tell("textDocument/didChange", &changed);
    assert_eq!(editor.published(2), Vec::<Value>::new());

    let hover = editor.ask_at("textDocument/hover", 4, 19, &json!({}));
    assert_eq!(hover["result"]["range"], range([4, 19], [4, 21]));
    let text = hover["result"]["contents"]["value"].as_str().expect("a text").to_owned();
    assert!(text.starts_with("```illuminator-formula\nCd: vector\n```\n") && text.contains("colour of the body"), "{text}");
    let hover = editor.ask_at("textDocument/hover", 3, 9, &json!({}));
    let text = hover["result"]["contents"]["value"].as_str().expect("a text").to_owned();
    assert!(text.contains("kd: scalar, default 0.5\n") && text.contains("the matte part"), "{text}");
    assert_eq!(editor.ask_at("textDocument/hover", 2, 8, &json!({}))["result"], Value::Null);

    let definition = editor.ask_at("textDocument/definition", 3, 10, &json!({}));
    assert_eq!(definition["result"], json!({"uri": URI, "range": range([1, 0], [1, 2])}));
    let definition = editor.ask_at("textDocument/definition", 3, 7, &json!({}));
    assert_eq!(definition["result"]["range"], range([3, 2], [3, 3]), "an argument");
    let uses = editor.ask_at("textDocument/references", 3, 0, &json!({"context": {"includeDeclaration": false}}));
    assert_eq!(uses["result"], json!([{"uri": URI, "range": range([4, 11], [4, 12])}]));
    let outline = editor.ask("textDocument/documentSymbol", &json!({"textDocument": {"uri": URI}}));
    let names: Vec<&Value> = outline["result"].as_array().expect("a list").iter().map(|one| &one["name"]).collect();
    assert_eq!(names, ["kd", "F"]);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn terms_of_the_lighting_equation_are_completed_and_explained() {
    const TERMS: &str =
        "formula;\nambient = Cd;\nemission = 0.1*Cd; // the glow\nreflected = kr*(1 - eta)*total;\nref\n= IL*Cd*visible;\n";
    let mut editor = EditorSession::begun();
    editor.open("illuminator-formula", TERMS);
    let refused = editor.ask_at("textDocument/prepareRename", 3, 2, &json!({}));
    let told = refused["error"]["message"].as_str().expect("a reason");
    assert!(told.starts_with("the name `reflected` has a meaning: "), "{refused}");
    let completion = editor.ask_at("textDocument/completion", 4, 3, &json!({}));
    let items = completion["result"]["items"].as_array().expect("a list");
    assert_eq!(items.len(), 1, "`reflected` is there already: {items:?}");
    assert_eq!(items[0]["textEdit"], json!({"range": range([4, 0], [4, 3]), "newText": "refracted = "}));
    assert_eq!((&items[0]["label"], &items[0]["detail"]), (&json!("refracted"), &json!("scalar or vector")));
    assert_eq!(items[0]["documentation"], "weight of the refracted ray, a scalar or a colour, in place of kt");

    let given = json!({"range": range([4, 0], [4, 3]), "text": "refracted = 1 - eta;"});
    let changed = json!({"textDocument": {"uri": URI, "version": 2}, "contentChanges": [given]});
    editor.tell("textDocument/didChange", &changed);
    assert_eq!(editor.published(2), Vec::<Value>::new());
    let mut told = |line: u32, character: u32| {
        let hover = editor.ask_at("textDocument/hover", line, character, &json!({}));
        hover["result"]["contents"]["value"].as_str().unwrap_or_default().replace('\\', "")
    };
    for (place, head, doc) in [
        ([1, 0], "ambient = Cd", "ambient light at a hit"),
        ([2, 7], "emission = 0.1*Cd", "light that a hit sends out by itself"),
        ([2, 7], "", "\n\nthe glow"),
        ([3, 3], "reflected = kr*(1 - eta)*total", "weight of the reflected ray"),
        ([4, 0], "refracted = 1 - eta", "weight of the refracted ray"),
        ([3, 22], "eta: scalar", "n1/n2 of the refractive indices"),
        ([3, 28], "total: scalar", "1 where refraction is total reflection"),
        ([5, 10], "visible: scalar", "1 if no body lies between the hit and the light"),
    ] {
        let text = told(place[0], place[1]);
        assert!(text.contains(head) && text.contains(doc), "{place:?}: {text}");
    }
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn names_are_completed_and_changed() {
    let mut editor = EditorSession::begun();
    editor.open("plaintext", &TEXT.replace("Cb;", "ma"));
    let completion = editor.ask_at("textDocument/completion", 4, 21, &json!({}));
    let items = completion["result"]["items"].as_array().expect("a list");
    let max = items.iter().find(|item| item["label"] == "max").expect("max");
    assert_eq!(max["textEdit"], json!({"range": range([4, 19], [4, 21]), "newText": "max("}));
    assert!(items.iter().all(|item| item["sortText"].is_string()));

    let place = editor.ask_at("textDocument/prepareRename", 4, 11, &json!({}));
    assert_eq!(place["result"], json!({"range": range([4, 11], [4, 12]), "placeholder": "F"}));
    let rename = editor.ask_at("textDocument/rename", 4, 11, &json!({"newName": "falloff"}));
    let edit = |start, end| json!({"range": range(start, end), "newText": "falloff"});
    assert_eq!(rename["result"]["changes"][URI], json!([edit([3, 0], [3, 1]), edit([4, 11], [4, 12])]));
    for (name, told) in [("kd", "`kd` has another meaning in this file"), ("N", "`N` is already"), ("a b", "`a b` is not a name")]
    {
        let refused = editor.ask_at("textDocument/rename", 4, 11, &json!({"newName": name}));
        assert!(refused["error"]["message"].as_str().is_some_and(|message| message.starts_with(told)), "{refused}");
    }
    assert_eq!(editor.ask_at("textDocument/prepareRename", 4, 16, &json!({}))["result"], Value::Null, "IL is not its own");
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn texts_are_formatted_unless_they_have_mistakes() {
    let mut editor = EditorSession::begun();
    editor.open("illuminator-formula", "formula;\nA=1;\n\n\n\nB =A+ A;\n= B*Cd;\n");
    let options = json!({"tabSize": 4, "insertSpaces": true});
    let asked = json!({"textDocument": {"uri": URI}, "options": options});
    let formatted = editor.ask("textDocument/formatting", &asked);
    assert_eq!(formatted["result"], json!([{"range": range([1, 0], [6, 0]), "newText": "A = 1;\n\nB = A + A;\n"}]));
    let scene = "bodies;\n ball:sphere,center <0,0,0>,radius 1;\nlights;\ncamera;\n position <0,1,6>; gaze <0,0,-1>; up <0,1,0>; fov 40;\n";
    let changed = json!({"textDocument": {"uri": URI, "version": 2}, "contentChanges": [{"text": "formula;\n=A+;"}]});
    editor.tell("textDocument/didChange", &changed);
    assert!(!editor.published(2).is_empty());
    assert_eq!(editor.ask("textDocument/formatting", &asked)["result"], Value::Null);
    editor.tell("textDocument/didClose", &json!({"textDocument": {"uri": URI}}));
    assert_eq!(editor.heard()["params"]["diagnostics"], json!([]));
    assert_eq!(editor.open("illuminator-scene", scene), Vec::<Value>::new());
    let formatted = editor.ask("textDocument/formatting", &asked);
    let text = formatted["result"][0]["newText"].as_str().expect("a text");
    assert!(text.starts_with(" ball: sphere, center <0, 0, 0>, radius 1;\n"), "{text}");
    let hover = editor.ask_at("textDocument/hover", 1, 1, &json!({}));
    let text = "```illuminator-scene\nball: sphere,center <0,0,0>,radius 1\n```";
    assert_eq!(hover["result"]["contents"]["value"], text);
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn bad_input_does_not_end_the_server() {
    let mut editor = EditorSession::silent();
    assert_eq!(editor.ask("textDocument/hover", &json!({}))["error"]["code"], -32002, "before `initialize`");
    let mut editor = EditorSession::begun();
    editor.write(b"garbage\r\nContent-Length: -1\r\n\r\nContent-Length: 5\r\n\r\n{]}{[");
    for _ in 0..2 {
        assert_eq!(editor.heard()["method"], "window/logMessage");
    }
    let heard = editor.heard();
    assert_eq!((&heard["id"], &heard["error"]["code"]), (&Value::Null, &json!(-32700)), "{heard}");
    editor.send(&json!({"jsonrpc": "2.0", "id": "x", "method": 7}));
    let heard = editor.heard();
    assert_eq!((&heard["id"], &heard["error"]["code"]), (&json!("x"), &json!(-32600)), "{heard}");
    assert_eq!(editor.ask("workspace/unheardOf", &json!({}))["error"]["code"], -32601);
    assert_eq!(editor.ask("textDocument/hover", &json!({"position": 7}))["error"]["code"], -32602);
    editor.tell("textDocument/didOpen", &json!([1, 2]));
    assert_eq!(editor.heard()["method"], "window/logMessage");
    assert_eq!(editor.ask_at("textDocument/hover", 0, 0, &json!({}))["result"], Value::Null, "the text is not open");
    editor.open("illuminator-formula", &"(".repeat(5000));
    let far = range([9, 999], [4_000_000_000, 0]);
    let changes = json!([{"range": far, "text": "\u{0}😀\r"}, {"range": range([0, 3], [0, 1]), "text": ""}]);
    editor.tell("textDocument/didChange", &json!({"textDocument": {"uri": URI, "version": -2}, "contentChanges": changes}));
    assert!(!editor.published(-2).is_empty());
    for method in ["hover", "definition", "completion", "prepareRename"] {
        assert!(editor.ask_at(&format!("textDocument/{method}"), 7, 7_000, &json!({}))["error"].is_null());
    }
    assert_eq!(editor.end(), Some(0));
}

#[test]
fn a_server_that_is_left_alone_ends() {
    let EditorSession { mut server, to, from, .. } = EditorSession::begun();
    drop(to);
    assert_eq!(server.wait().expect("the server ends").code(), Some(1));
    drop(from);
    let mut editor = EditorSession::begun();
    editor.tell("exit", &Value::Null);
    assert_eq!(editor.server.wait().expect("the server ends").code(), Some(1), "without `shutdown`");
}
