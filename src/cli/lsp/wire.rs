//! The messages of the Language Server Protocol as bytes: a head with the length, and JSON.
//!
//! The reader takes any bytes. What is no message is reported, and the next message is read.

use illuminator::files::reason;
use lsp_server::{ErrorCode, Message};
use serde_json::{Value, json};
use std::io::{self, BufRead, Read};

/// The largest message that is read, in bytes. The largest texts are well below it.
const LARGEST: u64 = 64 << 20;
/// The longest line of a head, in bytes.
const LONGEST_LINE: u64 = 4 << 10;

/// What was read.
#[derive(Debug)]
pub(super) enum Received {
    /// A message.
    Message(Message),
    /// Bytes outside of messages, or a message that is too large; the text says what is wrong.
    Stray(String),
    /// Something else in the place of a message.
    Malformed(RefusedMessage),
    /// The end of the input.
    End,
}

/// The answer to what is no message.
#[derive(Debug)]
pub(super) struct RefusedMessage {
    /// What the editor has called it; null if that is not known.
    id: Value,
    code: ErrorCode,
    message: String,
}

impl RefusedMessage {
    /// The answer as bytes. `lsp_server` has no answers without an identifier.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let error = json!({ "code": self.code as i32, "message": self.message });
        let text = json!({ "jsonrpc": "2.0", "id": self.id, "error": error }).to_string();
        format!("Content-Length: {}\r\n\r\n{text}", text.len()).into_bytes()
    }
}

/// Reads the next message.
///
/// # Errors
/// The input cannot be read.
pub(super) fn receive(input: &mut impl BufRead) -> io::Result<Received> {
    let mut length = None;
    loop {
        let mut line = Vec::new();
        if input.take(LONGEST_LINE).read_until(b'\n', &mut line)? == 0 {
            return Ok(Received::End);
        }
        let line = String::from_utf8_lossy(&line);
        let line = line.trim_end();
        match (line.split_once(':'), length) {
            (None, Some(length)) if line.is_empty() => return body(input, length),
            (None, None) if line.is_empty() => {}
            (Some((name, value)), _) if name.eq_ignore_ascii_case("content-length") => match value.trim().parse() {
                Ok(bytes) => length = Some(bytes),
                Err(_) => return Ok(Received::Stray("the length of a message is not a number".to_owned())),
            },
            (Some(_), _) => {}
            (None, _) => return Ok(Received::Stray("a line of a head is not of the form `NAME: VALUE`".to_owned())),
        }
    }
}

fn body(input: &mut impl BufRead, length: u64) -> io::Result<Received> {
    if length > LARGEST {
        io::copy(&mut input.take(length), &mut io::sink())?;
        return Ok(Received::Stray(format!("a message of {length} bytes is too large: at most {LARGEST} are read")));
    }
    let mut text = Vec::new();
    if input.take(length).read_to_end(&mut text)? as u64 != length {
        return Ok(Received::End);
    }
    Ok(message(&text).map_or_else(Received::Malformed, Received::Message))
}

/// The message that a text in JSON is.
fn message(text: &[u8]) -> Result<Message, RefusedMessage> {
    let value: Value = serde_json::from_slice(text).map_err(|error| RefusedMessage {
        id: Value::Null,
        code: ErrorCode::ParseError,
        message: format!("a message is not JSON: {error}"),
    })?;
    let id = value.get("id").filter(|id| id.is_number() || id.is_string()).cloned().unwrap_or_default();
    let refusal = |message: &str| RefusedMessage { id: id.clone(), code: ErrorCode::InvalidRequest, message: message.to_owned() };
    match serde_json::from_value(value) {
        // An answer would have no place to go.
        Ok(Message::Notification(_)) if !id.is_null() => {
            Err(refusal("the `id` of a request is a whole number of 32 bits, or a text"))
        }
        Ok(message) => Ok(message),
        Err(_) => Err(refusal("a message is no request, no notification and no answer")),
    }
}

/// A message as bytes.
///
/// # Errors
/// It cannot be written as JSON. The text says why.
pub(super) fn bytes(message: &Message) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    message.write(&mut bytes).map_err(|error| reason(&error))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lsp_server::Notification;

    #[test]
    fn what_is_no_message_is_passed_over() {
        let good = bytes(&Notification::new("exit".to_owned(), ()).into()).unwrap();
        let mut input =
            b"nonsense\r\nContent-Length: x\r\n\r\nContent-Length: 3\r\n\r\n{a}content-length: 99999999999\r\n\r\n".to_vec();
        let mut reader = io::BufReader::new(input.as_slice());
        assert!(matches!(receive(&mut reader).unwrap(), Received::Stray(_)));
        assert!(matches!(receive(&mut reader).unwrap(), Received::Stray(_)));
        assert!(matches!(receive(&mut reader).unwrap(), Received::Malformed(_)));
        assert!(matches!(receive(&mut reader).unwrap(), Received::Stray(_)), "too large");
        assert!(matches!(receive(&mut reader).unwrap(), Received::End));
        input = b"X-Other: 1\r\n".to_vec();
        input.extend(good);
        let mut reader = io::BufReader::new(input.as_slice());
        assert!(matches!(receive(&mut reader).unwrap(), Received::Message(Message::Notification(note)) if note.method == "exit"));
        assert!(matches!(receive(&mut reader).unwrap(), Received::End));
    }

    #[test]
    fn a_request_that_is_not_understood_is_answered() {
        let refused = |text: &str| {
            let refusal = message(text.as_bytes()).unwrap_err();
            (refusal.id, refusal.code as i32)
        };
        assert_eq!(refused("{"), (Value::Null, -32700));
        assert_eq!(refused("\u{ff}"), (Value::Null, -32700));
        assert_eq!(refused("[]"), (Value::Null, -32600));
        assert_eq!(refused(r#"{"id": 7, "method": 3}"#), (json!(7), -32600));
        assert_eq!(refused(r#"{"id": "a", "method": null}"#), (json!("a"), -32600));
        assert_eq!(refused(r#"{"id": 5000000000, "method": "shutdown"}"#), (json!(5_000_000_000_u64), -32600));
    }
}
