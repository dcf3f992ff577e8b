//! The messages of the Language Server Protocol as bytes: a head with the length, and JSON.
//!
//! The reader takes any bytes. What is no message is reported, and the next message is read.

use illuminator::files::reason;
use lsp_server::Message;
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
    /// Something else; the text says what is wrong with it.
    Malformed(String),
    /// The end of the input.
    End,
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
                Err(_) => return Ok(Received::Malformed("the length of a message is not a number".to_owned())),
            },
            (Some(_), _) => {}
            (None, _) => return Ok(Received::Malformed("a line of a head is not of the form `NAME: VALUE`".to_owned())),
        }
    }
}

fn body(input: &mut impl BufRead, length: u64) -> io::Result<Received> {
    if length > LARGEST {
        io::copy(&mut input.take(length), &mut io::sink())?;
        return Ok(Received::Malformed(format!("a message of {length} bytes is too large: at most {LARGEST} are read")));
    }
    let mut text = Vec::new();
    if input.take(length).read_to_end(&mut text)? as u64 != length {
        return Ok(Received::End);
    }
    Ok(match serde_json::from_slice(&text) {
        Ok(message) => Received::Message(message),
        Err(error) => Received::Malformed(format!("a message is not understood: {error}")),
    })
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
        let tail = good.clone();
        let mut reader = io::BufReader::new(input.as_slice());
        let mut malformed = 0;
        while let Received::Malformed(_) = receive(&mut reader).unwrap() {
            malformed += 1;
        }
        assert_eq!(malformed, 4);
        input = b"X-Other: 1\r\n".to_vec();
        input.extend(tail);
        let mut reader = io::BufReader::new(input.as_slice());
        assert!(matches!(receive(&mut reader).unwrap(), Received::Message(Message::Notification(note)) if note.method == "exit"));
        assert!(matches!(receive(&mut reader).unwrap(), Received::End));
    }
}
