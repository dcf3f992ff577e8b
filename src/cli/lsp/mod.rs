//! `illuminator lsp`: a language server for editors. It reads requests from standard input and answers on standard
//! output, as the Language Server Protocol says.
//!
//! [`wire`] has messages as bytes, [`texts`] the open texts, [`server`] the state of the conversation and [`answers`]
//! the answers. What is known about a text comes from [`assist`](illuminator::assist).

mod answers;
mod server;
mod texts;
mod wire;

use crate::cli::report::{Failure, print_bytes};
use illuminator::files::reason;
use illuminator::lang::diagnostic::Diagnostic;
use server::{ConversationStage, Server};
use std::io::{self, IsTerminal};
use wire::{Received, bytes, receive};

/// Answers an editor until it ends the conversation.
pub(super) fn run() -> Result<(), Failure> {
    let mut input = io::stdin().lock();
    if input.is_terminal() {
        return Err(Failure::CommandLine(
            Diagnostic::error("the language server speaks with an editor, not with a person")
                .help("docs/editors.md says how editors start it; `illuminator check` reports mistakes"),
        ));
    }
    let mut server = Server::default();
    loop {
        let received = receive(&mut input).map_err(|error| Failure::input(format!("cannot read: {}", reason(&error))))?;
        let replies = match received {
            Received::Message(message) => server.take(message),
            Received::Stray(what) => vec![server::log(&what)],
            Received::Malformed(refusal) => {
                print_bytes(&refusal.bytes())?;
                continue;
            }
            Received::End => return if server.stage() == ConversationStage::ShutDown { Ok(()) } else { Err(Failure::Reported) },
        };
        for reply in replies {
            print_bytes(&bytes(&reply).map_err(Failure::input)?)?;
        }
        if let ConversationStage::Exited { properly } = server.stage() {
            return if properly { Ok(()) } else { Err(Failure::Reported) };
        }
    }
}
